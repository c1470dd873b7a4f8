"""Estimates without a solution, and laws for finite elements."""

import gfmd
import numpy as np
import pytest

BODY = gfmd.Body(young="70 GPa")


def rough(seed=1):
    return gfmd.self_affine(n=64, eps_f_inv=8, eps_t_inv=2, hurst=0.8, size="100 um", unit="um", seed=seed)


def test_an_estimate_agrees_with_the_contact_within_twice_its_error():
    estimate, contact = (call(rough(), BODY, p_star=[0.03, 0.1]) for call in (gfmd.estimate, gfmd.contact))
    for name in ("area_fraction", "mean_gap", "stiffness"):
        wanted = contact.__getattr__(f"{name}_limit")
        assert np.all(np.abs(estimate[name] - wanted) < 2 * estimate[f"{name}_error"]), name
    assert estimate.units == ("um", "Pa") or estimate.units[0] == rough().unit


def test_loads_beyond_the_range_are_nan_with_a_reason():
    estimate = gfmd.estimate(rough(), BODY, p_star=[1e-6, 0.1])
    assert np.isnan(estimate.area_fraction[0]) and estimate.area_fraction[1] > 0
    assert "known from p*" in estimate.undefined["area_fraction"]
    assert len(gfmd.estimate(rough(), BODY).p_star) == 6
    assert "undefined" not in gfmd.estimate(rough(), BODY, p_star=0.1)


def test_a_surface_with_a_rough_seam_has_no_estimate_until_it_is_periodic():
    part = gfmd.Surface(rough().heights[:40, :40], size="62.5 um", unit="um")
    estimate = gfmd.estimate(part, BODY, p_star=0.1)
    assert np.isnan(estimate.area_fraction).all()
    assert "of the mean square slope are steps across the periodic seam" in estimate.undefined["area_fraction"]
    mirrored = part.periodise("mirror")
    assert "seam" not in str(gfmd.estimate(mirrored, BODY, p_star=0.1))


def test_smooth_and_rough_parts_have_an_estimate_with_larger_errors():
    """The short waves are multiplied by a lognormal factor, as in the measured surfaces, with another strength."""
    even = gfmd.self_affine(n=256, eps_f_inv=16, eps_t_inv=2, hurst=0.8, seed=41)
    wave = np.fft.fftfreq(256, 1 / 256)
    is_long = np.hypot(wave[:, np.newaxis], wave) <= 8
    long = np.fft.ifft2(np.where(is_long, np.fft.fft2(even.heights), 0)).real
    factor = gfmd.self_affine(n=256, eps_f_inv=2, eps_t_inv=2, hurst=0.0, seed=42).heights
    heights = long + (even.heights - long) * np.exp(0.6 * factor / factor.std())
    estimate, contact = (call(heights, gfmd.Body(), p_star=[0.003, 0.03]) for call in (gfmd.estimate, gfmd.contact))
    assert estimate.measured == "surfaces of uneven roughness"
    plain = gfmd.estimate(even, gfmd.Body(), p_star=[0.003, 0.03])
    assert plain.measured == "isotropic Gaussian surfaces"
    for name in ("area_fraction", "mean_gap", "stiffness", "max_pressure"):
        assert np.all(np.abs(estimate[name] - contact.__getattr__(name)) < 1.5 * estimate[f"{name}_error"]), name
    wider = estimate.area_fraction_error / estimate.area_fraction > plain.area_fraction_error / plain.area_fraction
    assert wider.all()


def test_a_spectrum_of_noise_has_no_estimate_and_its_number_is_named():
    noise = rough().heights.copy()
    noise[::2] += 1.0
    estimate = gfmd.estimate(noise, gfmd.Body(), p_star=0.1)
    assert np.isnan(estimate.area_fraction[0]) and "measured" not in estimate
    assert "the logarithm of the wavenumber has the skewness -" in estimate.reason("area_fraction")


@pytest.mark.parametrize(
    "given, words",
    [
        (dict(p_star=0.1, pressure=1.0), "given by pressure, p_star"),
        (dict(p_star=-0.1), "p_star is -0.1; it must be positive"),
        (dict(p_star=0.1, hardness=-1.0), "hardness is -1"),
        (dict(pressure="1 um"), "pressure is"),
        (dict(approach=1.0), "approach"),
    ],
)
def test_bad_loads_are_refused(given, words):
    with pytest.raises((gfmd.InputError, TypeError), match=words) as error:
        gfmd.estimate(rough(), BODY, **given)
    assert "\n" not in str(error.value)


def test_profiles_slabs_and_relaxing_bodies_have_no_estimate():
    with pytest.raises(gfmd.InputError, match="profile"):
        gfmd.estimate(np.sin(np.arange(16.0)), gfmd.Body(), p_star=0.1)
    with pytest.raises(gfmd.InputError, match="half-space"):
        gfmd.estimate(np.random.default_rng(1).random((16, 16)), gfmd.Body(height=0.1), p_star=0.1)
    with pytest.raises(gfmd.InputError, match="viscoelastic"):
        gfmd.estimate(rough(), gfmd.Body(prony=[(0.1, 0.3)]), p_star=0.1)


@pytest.mark.parametrize(
    "given, words",
    [
        ({"force": "-5 N"}, "force is -5 N; it must be positive and finite"),
        ({"pressure": ["1 MPa", "-1 kPa"]}, "pressure is -1 kPa; it must be positive and finite"),
        ({"approach": "-5 nm"}, "approach is -5 nm; it must be positive and finite"),
        ({"pressure": "1 MPa", "hardness": "-2 GPa"}, "hardness is -2 GPa; it must be positive and finite"),
    ],
)
def test_refusals_show_quantities_as_they_were_written(given, words):
    surface = gfmd.self_affine(n=16, size="100 um", unit="um")
    with pytest.raises(gfmd.InputError, match=words):
        gfmd.contact(surface, gfmd.Body(young="1 GPa"), **given)
    with pytest.raises(gfmd.InputError, match="young is -1 GPa; it must be positive and finite"):
        gfmd.Body(young="-1 GPa")
    with pytest.raises(gfmd.InputError, match="pressure is -1 MPa; it must be positive"):
        gfmd.estimate(surface, gfmd.Body(young="1 GPa"), pressure="-1 MPa")


def rows(text, keyword):
    lines = iter(text.splitlines())
    for line in lines:
        if line.startswith(keyword):
            break
    found = []
    for line in lines:
        if line.startswith("*"):
            break
        found.append([float(number) for number in line.split(",")])
    return np.array(found)


def test_a_law_has_the_numbers_of_the_contacts():
    contacts = gfmd.contact(rough(), BODY, pressure=["1 GPa", "10 MPa", "0.1 GPa"])
    text = gfmd.fe_table(contacts, format="abaqus", conductivity=("16 W/(m K)", "200 W/(m K)"))
    law = rows(text, "*SURFACE BEHAVIOR")
    order = [1, 2, 0]
    assert law[0, 0] == 0 and np.all(np.diff(law, axis=0) > 0)
    np.testing.assert_allclose(law[1:, 0], contacts.mean_pressure[order], rtol=1e-8)
    np.testing.assert_allclose(-law[1:, 1], 1e-6 * contacts.mean_gap[order], rtol=1e-8)
    conductance = rows(text, "*GAP CONDUCTANCE")
    wanted = [contacts[index].conductance("16 W/(m K)", "200 W/(m K)") for index in order]
    # The column is 2 stiffness/E*, whose relative error is at most 5e-6 (stiffness_tolerance).
    np.testing.assert_allclose(conductance[1:, 0], wanted, rtol=1e-5)
    flow = gfmd.fe_table(contacts, flow=True).splitlines()
    heads = next(line for line in flow if not line.startswith("#")).split(",")
    last = flow[-2].split(",")
    through = contacts[2].flow().transmissivity[0, 0] * 1e-18
    assert float(last[heads.index("transmissivity_x [m3]")]) == pytest.approx(through, rel=1e-8)


def test_seeds_have_a_mean_and_a_standard_error():
    loads = ["10 MPa", "0.1 GPa"]
    seeds = [gfmd.contact(rough(seed), BODY, pressure=loads) for seed in (1, 2, 3)]
    lines = [line.split(",") for line in gfmd.fe_table(seeds).splitlines() if not line.startswith("#")]
    gaps = 1e-6 * np.array([contacts.mean_gap for contacts in seeds])
    for row, of_load in zip(lines[2:], gaps.T):
        value, error = (float(row[lines[0].index(f"mean_gap{end} [m]")]) for end in ("", "_standard_error"))
        assert value == pytest.approx(of_load.mean(), rel=1e-8)
        assert error == pytest.approx(of_load.std(ddof=1) / np.sqrt(3), rel=1e-6)


def test_contacts_without_a_law_are_refused():
    two = gfmd.contact(rough(), BODY, pressure=["10 MPa", "0.1 GPa"])
    bare = gfmd.contact(gfmd.self_affine(n=16), gfmd.Body(), p_star=[0.01, 0.1])
    free = gfmd.contact(rough(), BODY, pressure=["10 MPa", "0.1 GPa"], boundary="free")
    for given, options, words in [
        (gfmd.contacts(rough(), BODY, pressure=["10 MPa"]), {}, "1 load"),
        (bare, {}, "no unit"),
        (free, {}, "boundary"),
        (two[0], {}, "results has a Contact; it must have Contacts, of two or more loads"),
        ([two, gfmd.contact(rough(), BODY, pressure=["10 MPa", "0.2 GPa"])], {}, "realisation 1"),
        (two, {"format": "vtk"}, "csv, abaqus or ansys"),
        (two, {"flow": 1}, "flow"),
        (two, {"conductivity": (1.0,)}, "two numbers"),
        (two, {"conductivity": (1.0, -1.0)}, "positive"),
    ]:
        with pytest.raises((gfmd.InputError, TypeError), match=words) as error:
            gfmd.fe_table(given, **options)
        assert "\n" not in str(error.value)


def test_a_rubber_relaxes_with_the_series_of_its_source():
    rubber = gfmd.material("nbr", "prony", "relaxes")
    body = gfmd.Body(**rubber)
    assert "Linder" in rubber.source and body.moduli == "long-term" and body.relaxes == "shear"
    fractions = [fraction for _, fraction in body.prony]
    assert sum(fractions) == pytest.approx(776.6 / 1176.6, rel=1e-4)
    with pytest.raises(gfmd.InputError, match="'prony' is not a value that the source of ptfe has"):
        gfmd.material("ptfe", "prony")
    assert gfmd.material("peek", "conductivity")["conductivity"] == "0.299W/(m*K)"


def test_a_second_body_and_a_fluid_have_names():
    named = gfmd.Body(young="70 GPa", second_material="steel-s355")
    plain = gfmd.Body(young="70 GPa", second_body=("210GPa", 0.3))
    assert named.e_star == plain.e_star and named.second_body == plain.second_body
    assert named.second_material.startswith("steel-s355 (EN 1993") and "second_material" not in plain
    contacts = [gfmd.contact(rough(), body, pressure="10 MPa") for body in (named, plain)]
    assert contacts[0].area_fraction == contacts[1].area_fraction
    assert contacts[0].leak_rate(fluid="water", pressure_drop="1 bar") == pytest.approx(
        contacts[1].leak_rate(viscosity="1.0016 mPa*s", pressure_drop="1 bar"), rel=1e-14
    )
    path = gfmd.path(rough(), named, pressure="10 MPa", steps=1, flow=True, fluid="water", pressure_drop="1 bar")
    leak = path.leak_rate(fluid="water", pressure_drop="1 bar")[-1]
    assert 1e-18 * path.steps.leak[-1] == pytest.approx(leak, rel=1e-9)  # um^3/s
    assert "IAPWS 2008" in path.fluid and path.second_material == named.second_material


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: gfmd.Body(second_material="mithril"), "second_material is 'mithril'; it must be one of aluminium"),
        (lambda: gfmd.Body(second_material="peek", second_body=(1.0, 0.3)), "must be given without second_body"),
        (lambda: gfmd.contact(rough(), BODY, pressure="1 MPa").leak_rate(pressure_drop=1.0), "viscosity is missing"),
        (
            lambda: gfmd.contact(rough(), BODY, pressure="1 MPa").leak_rate(fluid="honey", pressure_drop=1.0),
            "fluid is 'honey'; it must be one of air",
        ),
        (
            lambda: gfmd.contact(rough(), BODY, pressure="1 MPa").leak_rate(
                fluid="air", viscosity=1.0, pressure_drop=1.0
            ),
            "must be given without viscosity",
        ),
    ],
)
def test_names_that_cannot_be_used_are_refused(call, words):
    with pytest.raises(gfmd.InputError, match=words) as error:
        call()
    assert "\n" not in str(error.value)
