"""Quantities with units, and numbers in units that people read."""

import copy
import pickle

import numpy as np
import pytest

import gfmd


@pytest.fixture(scope="module")
def scan():
    return gfmd.self_affine(n=32, size="50 um", unit="um", eps_f_inv=4)


@pytest.fixture(scope="module")
def pressed(scan):
    return gfmd.contact(scan, gfmd.Body(young="70 GPa", poisson=0.3), pressure="100 MPa")


def test_conductivities_have_units():
    scan = gfmd.self_affine(n=32, size="10 um", unit="um", eps_f_inv=4)
    c = gfmd.contact(scan, gfmd.Body(young="3 MPa"), p_star=0.05)
    assert c.conductance("0.2 W/(m K)", "5e4 mW/m/K") == pytest.approx(c.conductance(0.2, 50.0), rel=1e-14)
    for wrong, words in (("3 MPa", "k1 is .*it is a stress"), (None, "k1 is None"), ("0.2", "k1")):
        with pytest.raises(gfmd.InputError, match=words):
            c.conductance(wrong, 50.0)


def test_a_quantity_is_its_number(scan, pressed):
    body = gfmd.Body(young=70e9, poisson=0.3)
    bare = gfmd.contact(scan, body, pressure=1e8, stress_unit="Pa")
    assert bare == pressed and bare.body == pressed.body and pressed.units == ("µm", "Pa")
    assert gfmd.contact(scan, body, pressure=1e8).units == ("µm", None)
    layers = dict(
        height="20 um", layers=[("2GPa", 0.3, "3 um")], base="half-space", base_young="9 GPa", base_poisson=0.2
    )
    numbers = dict(height=20.0, layers=[(2e9, 0.3, 3.0)], base="half-space", base_young=9e9, base_poisson=0.2)
    with_units = gfmd.contact(scan, gfmd.Body(young="1GPa", **layers), approach="100 nm", hardness="2 GPa")
    assert with_units.body == gfmd.Body(young=1e9, **numbers) and with_units.hardness == 2e9
    assert with_units == gfmd.contact(
        scan, gfmd.Body(young=1e9, **numbers), approach=0.1, hardness=2e9, stress_unit="Pa"
    )
    law = gfmd.law("exponential", gamma="0.05 J/m^2", range="1 um")
    sticky = gfmd.contact(scan, gfmd.Body(e_star="10 MPa"), law=law, approach="1 nm")
    assert sticky.law == gfmd.law("exponential", gamma=0.05e6, range=1.0)
    assert sticky == gfmd.contact(scan, gfmd.Body(e_star=1e7), law=sticky.law, approach=1e-3, stress_unit="Pa")
    giga = gfmd.contact(scan, gfmd.Body(young="70 GPa"), pressure="50 MPa", stress_unit="GPa")
    assert giga.body.young == 70.0 and giga.mean_pressure == pytest.approx(0.05, rel=1e-8)


def test_a_force_is_the_mean_pressure_on_the_whole_surface(scan, tmp_path):
    body = gfmd.Body(young="70 GPa", poisson=0.3)
    pressed = gfmd.contact(scan, body, force="0.25 N")
    assert pressed.mean_pressure == pytest.approx(1e8, rel=1e-9)
    assert pressed == gfmd.contact(scan, body, force=2.5e11, stress_unit="Pa")
    several = gfmd.contacts(scan, body, force=["25 mN", "0.25 N"])
    assert several.mean_pressure == pytest.approx([1e7, 1e8], rel=1e-9)
    several.save(tmp_path / "forces.h5")
    assert np.array_equal(gfmd.load(tmp_path / "forces.h5").mean_pressure, several.mean_pressure)
    [once] = gfmd.many([scan], body, force="0.25 N")
    assert once.mean_pressure == pressed.mean_pressure
    followed = gfmd.path(scan, body, force=["25 mN", "0.25 N"], steps=1)
    assert followed.steps.mean_pressure == pytest.approx([1e7, 1e8], rel=1e-9)
    rubber = gfmd.Body(young="1 GPa", prony=[(1.0, 0.5)])
    assert gfmd.slide(scan, rubber, velocity=1.0, force="25 mN").states.mean_pressure == pytest.approx([1e7], rel=1e-9)
    with pytest.raises(gfmd.InputError, match="a force per length"):
        gfmd.contact(gfmd.self_affine(n=64, dim=2), gfmd.Body(), force=0.01)
    with pytest.raises(gfmd.InputError, match="force is .*it is a stress"):
        gfmd.contact(scan, body, force="1 MPa")


def test_loads_in_a_list_are_contacts_one_after_the_other(scan):
    body = gfmd.Body(young="70 GPa")
    several = gfmd.contact(scan, body, pressure=["50 MPa", 1e8, "0.2 GPa"])
    assert isinstance(several, gfmd.Contacts)
    assert several == gfmd.contacts(scan, gfmd.Body(young=70e9), pressure=[5e7, 1e8, 2e8], stress_unit="Pa")
    assert "approach / nm" in repr(several)
    assert len(gfmd.contact(scan, body, p_star=np.array([0.01, 0.02]))) == 2


def test_a_path_and_the_interior_take_units(scan, pressed):
    law = gfmd.law("exponential", gamma="0.05 J/m^2", range="1 um")
    with_units = gfmd.path(scan, gfmd.Body(e_star="10 MPa"), law=law, approach=["-10 nm", "5 nm"], steps=2)
    plain = gfmd.law("exponential", gamma=0.05e6, range=1.0)
    bare = gfmd.path(scan, gfmd.Body(e_star=1e7), law=plain, approach=[-0.01, 0.005], steps=2)
    assert np.array_equal(with_units.steps.mean_pressure, bare.steps.mean_pressure)
    pushed = gfmd.path(scan, gfmd.Body(young="1GPa"), friction=0.3, pressure="10 MPa", lateral=[0, "2 nm"], steps=2)
    assert pushed.steps.lateral[-1][0] == 2e-3
    assert np.array_equal(pressed.interior(depths=["500 nm"]).von_mises, pressed.interior(depths=[0.5]).von_mises)


def test_surfaces_are_converted(scan, tmp_path):
    nano = scan.to_unit("nm")
    assert nano.unit == "nm" and nano.size == (5e4, 5e4) and np.allclose(nano.heights, 1e3 * scan.heights, rtol=1e-15)
    assert nano.to_unit("um") == scan or np.allclose(nano.to_unit("um").heights, scan.heights, rtol=1e-15)
    assert gfmd.Surface(scan.heights, size=("50um", "0.05 mm"), unit="um") == scan
    np.save(tmp_path / "h.npy", scan.heights)
    assert gfmd.read(tmp_path / "h.npy", size="50 um", unit="um").unit == "µm"
    body = gfmd.Body(young="1 GPa")
    one, other = (gfmd.contact(surface, body, pressure="20 MPa") for surface in (scan, nano))
    assert other.mean_gap == pytest.approx(1e3 * one.mean_gap, rel=1e-6)
    with pytest.raises(gfmd.InputError, match="the surface has none"):
        gfmd.Surface(scan.heights).to_unit("um")
    with pytest.raises(gfmd.InputError, match='the unit is "px"'):
        scan.to_unit("px")


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda s: gfmd.contact(s, gfmd.Body(), p_star=0.1), "young is missing; lengths are in µm"),
        (lambda s: gfmd.contact(s.heights, gfmd.Body(young="1 GPa"), p_star=0.1), "the lengths have none"),
        (lambda s: gfmd.contact(s.heights, gfmd.Body(), pressure="1 MPa"), "the lengths have none"),
        (lambda s: gfmd.contact(s, gfmd.Body(young=1e9), pressure="1 nm"), 'pressure is "1 nm": it is a length'),
        (lambda s: gfmd.contact(s, gfmd.Body(young=1e9), approach="1 MPa"), 'approach is "1 MPa": it is a stress'),
        (lambda s: gfmd.contact(s, gfmd.Body(young=1e9), p_star="1 MPa"), "it must be a number without a unit"),
        (lambda s: gfmd.Body(young="70 GPaa"), '"GPaa" is no unit'),
        (lambda s: gfmd.Body(young="seventy"), "young is 'seventy'; it must be a number, or a text with a unit"),
        (lambda s: gfmd.law("morse", gamma="1 Pa", range=1.0), 'gamma is "1 Pa": it is a stress'),
        (lambda s: gfmd.green(gfmd.Body(young="1 GPa"), qx=1.0), "the lengths of green have none"),
        (lambda s: gfmd.punch(gfmd.Body(height="1 um"), n=16), "the lengths of punch have none"),
        (lambda s: gfmd.Surface(s.heights, size="3 um"), "the lengths have none"),
    ],
)
def test_wrong_quantities_are_named(scan, call, words):
    with pytest.raises(gfmd.InputError) as refused:
        call(scan)
    assert words in str(refused.value)


def test_units_that_are_mixed_up_are_told(scan):
    with pytest.warns(UserWarning, match="softer than any gel"):
        gfmd.contact(gfmd.self_affine(n=16, size=1e-4, unit="m"), gfmd.Body(young=70), p_star=0.05)
    with pytest.warns(UserWarning, match="far beyond full contact"):
        gfmd.contact(scan, gfmd.Body(young="1 MPa"), pressure="20 MPa")


@pytest.mark.parametrize(
    "options, words, argument",
    [
        ({"dt": 0.1}, 'dt is 0.1; it must be left out without solver="verlet-critical" or verlet-modes', "dt"),
        ({"finite_slope": True, "boundary": "free"}, "it must be periodic with finite_slope", "boundary"),
        ({"tolerance": 0.5}, "tolerance: ", "tolerance"),
        ({"hardness": -1.0}, "hardness is -1; it must be positive", "hardness"),
    ],
)
def test_messages_name_arguments_as_python_writes_them(options, words, argument):
    with pytest.raises(gfmd.InputError) as refused:
        gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(), p_star=0.05, **options)
    assert words in str(refused.value) and "--" not in str(refused.value)
    assert refused.value.argument == argument
    again = pickle.loads(pickle.dumps(refused.value))
    assert (str(again), again.argument, again.allowed) == (
        str(refused.value),
        refused.value.argument,
        refused.value.allowed,
    )


def test_values_in_messages_are_python(scan):
    with pytest.raises(gfmd.InputError, match='unit gives them one, as in unit="um"'):
        gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(young="70 GPa"), p_star=0.05)
    with pytest.warns(UserWarning, match='young="70GPa" has its own'):
        gfmd.contact(gfmd.self_affine(n=16, size=1e-4, unit="m"), gfmd.Body(young=70), p_star=0.05)
    with pytest.raises(gfmd.InputError) as refused:
        gfmd.contact(scan, gfmd.Body(young="1 GPa"), p_star=0.05, dt=0.1)
    assert (refused.value.argument, refused.value.found) == ("dt", "0.1")
    assert refused.value.allowed == 'left out without solver="verlet-critical" or verlet-modes'


def test_results_are_read_with_units_and_stored_without(scan, pressed, tmp_path):
    assert "100 MPa" in repr(pressed) and "MPa/µm" in repr(pressed) and pressed.mean_pressure == pytest.approx(1e8)
    assert repr(scan).startswith("Surface of 32 x 32 points on 50 x 50 µm")
    file = tmp_path / "c.h5"
    pressed.save(file)
    again = gfmd.load(file)
    assert again == pressed and again.units == pressed.units and pickle.loads(pickle.dumps(pressed)) == pressed
    assert copy.copy(scan) == scan and hash(scan) == hash(copy.copy(scan)) and scan != scan.flip()
    page = tmp_path / "c.html"
    pressed.report(page)
    assert "MPa" in page.read_text()


def test_tables_and_datasets_have_units(pressed):
    xarray = pytest.importorskip("xarray")
    data = pressed.to_xarray()
    assert isinstance(data, xarray.Dataset) and data.pressure.dims == ("y", "x")
    assert np.array_equal(data.pressure.values, pressed.pressure.T)
    assert (
        data.pressure.attrs["units"] == "Pa"
        and data.x.attrs["units"] == "µm"
        and data.stiffness.attrs["units"] == "Pa/µm"
    )
    bare = gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(), p_star=0.1).to_xarray()
    assert "units" not in bare.pressure.attrs and "units" not in bare.x.attrs
    pandas = pytest.importorskip("pandas")
    table = pressed.to_dataframe()
    assert isinstance(table, pandas.DataFrame) and table.attrs["units"]["mean_gap"] == "µm"
    assert table.area_fraction[0] == pressed.area_fraction


def test_flow_and_conductance_in_si(scan, pressed):
    flow, rate = pressed.flow(), pressed.leak_rate(viscosity="1 mPa*s", pressure_drop="1 bar")
    gap = pressed.mean_gap * 1e-6
    slit = gap**3 / (12 * 1e-3) * 1e5
    assert np.allclose(rate, np.diag(flow.conductivity) * slit, rtol=1e-12)
    assert np.allclose(flow.transmissivity, flow.conductivity * pressed.mean_gap**3 / 12)
    metres = gfmd.contact(scan.to_unit("m"), gfmd.Body(young="70 GPa", poisson=0.3), pressure="100 MPa")
    assert np.allclose(metres.leak_rate(viscosity=1e-3, pressure_drop=1e5), rate, rtol=1e-5)
    # Of two bodies with k = 50 and 20 W/(m K): h = G / (1/50 + 1/20).
    assert pressed.conductance(50, 20) == pytest.approx(pressed.conductance() * 1e6 / (1 / 50 + 1 / 20))
    assert metres.conductance(50, 20) == pytest.approx(pressed.conductance(50, 20), rel=1e-5)
    assert pressed.conductance(conductor_height="100 um") == pressed.conductance(conductor_height=100.0)
    with pytest.raises(TypeError, match="leak_rate"):
        pressed.flow(viscosity=1.0)
    with pytest.raises(AttributeError, match="write leak_rate"):
        pressed.flow().rate


def test_gas_in_the_gap_in_si(scan, pressed):
    k, jump = 0.026, 0.3
    gap = np.where(pressed.touching, np.inf, np.maximum(pressed.gap, 0.0) + jump)
    numbers = pressed.gas_conductance(conductivity=k, jump="300 nm")
    assert numbers == pytest.approx(np.mean(k / gap) * 1e6, rel=1e-12)
    air = pressed.gas_conductance("air")
    metres = gfmd.contact(scan.to_unit("m"), gfmd.Body(young="70 GPa", poisson=0.3), pressure="100 MPa")
    assert metres.gas_conductance("air") == pytest.approx(air, rel=1e-5)
    assert pressed.gas_conductance("air", temperature="300 K", pressure=101325, accommodation=0.8562) == pytest.approx(
        air, rel=1e-3
    )
    assert pressed.gas_conductance("air", pressure="1 kPa") < air < pressed.gas_conductance("helium", accommodation=1)
    for wrong, words in (
        (dict(gas="steam"), "one of air"),
        (dict(gas="air", jump=1.0), "left out"),
        (dict(gas="air", temperature=20.0), "from 200 to 1000 K"),
        (dict(conductivity=1.0), "gas is missing"),
        (dict(conductivity=1.0, jump=0.0), "positive and finite"),
        (dict(conductivity=1.0, jump=1.0, pressure=3.0), "left out without gas"),
    ):
        with pytest.raises(gfmd.InputError, match=words):
            pressed.gas_conductance(**wrong)
    bare = gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(), p_star=0.1)
    with pytest.raises(gfmd.InputError, match="length unit"):
        bare.gas_conductance("air")
    way = gfmd.path(scan, gfmd.Body(young="70 GPa", poisson=0.3), pressure="100 MPa", steps=1, gas="air")
    # Pa µm/(s K) are 1e-6 W/(m² K).
    assert way.steps.gas_conductance[-1] * 1e-6 == pytest.approx(air, rel=1e-4)


def test_patches_and_distributions_are_those_of_the_program(pressed, tmp_path, run_program):
    h5py = pytest.importorskip("h5py")
    np.save(tmp_path / "h.npy", pressed.surface.heights)
    words = (
        f"contact --surface {tmp_path}/h.npy --unit um --size 50 --young 70GPa --poisson 0.3 --pressure 100MPa"
        f" --statistics --flow --out {tmp_path}/c.h5"
    )
    run_program(*words.split())
    patches, distributions, flow = pressed.patches(), pressed.distributions(), pressed.flow()
    with h5py.File(tmp_path / "c.h5") as file:
        for name in ("area", "perimeter", "force", "x", "y"):
            assert np.array_equal(file["patches"][name], patches[name], equal_nan=True), name
        for name in ("pressure", "pressure_at", "gap", "gap_at"):
            assert np.array_equal(file["distributions"][name][0], distributions[name]), name
        assert np.array_equal(file["spectra/pressure"][0], distributions.pressure_spectrum)
        assert (
            file["loads/flow_xx"][0] == flow.conductivity[0, 0] and file["loads/flow_yx"][0] == flow.conductivity[1, 0]
        )
        assert file["loads/conductance"].attrs["units"] in ("1/µm", b"1/\xc2\xb5m")
    assert patches.force.sum() == pytest.approx(pressed.mean_pressure * 2500.0)
    assert (patches.area.sum() / 2500.0) == pytest.approx(pressed.area_fraction)
    pressed.save(tmp_path / "p.h5")
    stored = gfmd.load(tmp_path / "p.h5")
    assert np.array_equal(stored.patches().force, patches.force) and stored.flow().conductivity[0, 0] == pytest.approx(
        flow.conductivity[0, 0]
    )


def test_a_reason_stands_where_a_number_is_none():
    full = gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(), p_star=10.0)
    assert (
        np.isnan(full.stiffness) and full.reason("stiffness").startswith("infinite") and full.reason("mean_gap") is None
    )
    with pytest.raises(gfmd.InputError, match="name is 'stifness'"):
        full.reason("stifness")


def test_the_spectrum_is_that_of_the_program(scan, tmp_path, run_program):
    h5py = pytest.importorskip("h5py")
    np.save(tmp_path / "h.npy", scan.heights)
    run_program(
        "surface", "--surface", f"{tmp_path}/h.npy", *"--size 50 --window hann --out".split(), f"{tmp_path}/s.h5"
    )
    spectrum = scan.psd(window="hann")
    with h5py.File(tmp_path / "s.h5") as file:
        assert np.array_equal(file["spectrum/density"], spectrum.density)
        modes = file["spectrum/modes"][:]
    # Parseval: the mean square is the sum over the modes of each ring of their density times the area of a mode.
    plain = scan.psd()
    assert np.sum(plain.density * modes) * (2 * np.pi / 50.0) ** 2 == pytest.approx(scan.rms_height**2, rel=1e-9)


def test_conductivities_without_a_unit_are_in_watts_if_lengths_have_one():
    rough = gfmd.self_affine(n=32, size="100 um", unit="um", rms_gradient=0.05, eps_f_inv=4)
    body, pair = gfmd.Body(young="70 GPa", poisson=0.3), ("16 W/(m K)", "200 W/(m K)")
    found = gfmd.contacts(rough, body, pressure=["0.1 GPa", "0.3 GPa"])
    tables = [gfmd.fe_table(found, conductivity=both) for both in (pair, (16, 200))]
    assert tables[0] == tables[1]
    steps = [
        gfmd.path(rough, body, pressure="0.1 GPa", steps=1, statistics=True, conductivity=both).steps
        for both in (pair, (16, 200))
    ]
    assert steps[0].contact_conductance == pytest.approx(steps[1].contact_conductance, rel=1e-14)
    # Pa µm/(s K) are 10^-6 W/(m² K).
    assert 1e-6 * steps[0].contact_conductance[-1] == pytest.approx(found[0].conductance(*pair), rel=1e-6)
