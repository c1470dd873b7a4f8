"""Contacts made of parts: a law, friction, a hardness, wear and a viscoelastic body on one path."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import gfmd

REFERENCE = json.loads((Path(__file__).parents[3] / "data" / "reference" / "composed_contacts.json").read_text())
N = 16


def rough(**given):
    return gfmd.self_affine(n=16, eps_f_inv=4, **given)


def heights(kind):
    """The surfaces of the reference, at the centres of the cells."""
    x, y = np.meshgrid(*2 * [(np.arange(N) + 0.5) / N], indexing="ij")
    turn = 2.0 * np.pi
    if kind == "waves":
        return (
            0.02 * np.cos(turn * x + 0.3) * np.cos(turn * y - 0.7)
            + 0.008 * np.cos(turn * (2 * x + y) + 1.1)
            + 0.004 * np.cos(turn * (x - 3 * y) + 2.0)
        )
    sphere = -((x - 0.51) ** 2 + (y - 0.47) ** 2) / 2.0
    return sphere + 0.004 * np.cos(turn * (2 * x + y) + 1.1) + 0.002 * np.cos(turn * (3 * x - 2 * y))


def arguments(parts):
    """The arguments of `gfmd.path` and `gfmd.Body` for the parts of a case."""
    given, body = dict(boundary=parts["boundary"], direction=0.0), dict(e_star=parts["e_star"], poisson=parts["nu"])
    if "prony" in parts:
        whole = 1.0 + sum(branch["weight"] for branch in parts["prony"])
        body["prony"] = [(branch["time"], branch["weight"] / whole) for branch in parts["prony"]]
    if "law" in parts:
        law = parts["law"]
        given["law"] = gfmd.law(law["kind"], gamma=law["gamma"], range=law["range"])
    for name, key in (("friction", "friction"), ("shear_strength", "tresca"), ("hardness", "hardness")):
        if key in parts:
            given[name] = parts[key]
    if "wear" in parts:
        given["wear"] = gfmd.Wear(parts["wear"])
    if "wear_by_slip" in parts:
        given["wear"] = gfmd.Wear(parts["wear_by_slip"], by="slip")
    return given, gfmd.Body(**body)


@pytest.mark.parametrize(
    "name", ["law+orowan", "hardness+law", "fretting-wear+coulomb", "visco+law+coulomb", "wear+law", "all free"]
)
def test_the_numbers_are_those_of_dense_solutions(name):
    case = REFERENCE["cases"][name]
    drives, wanted = case["drives"], case["steps"]
    given, body = arguments(case["parts"])
    assert {drive["load"][0] for drive in drives} == {"pressure"}
    given["pressure"] = [drive["load"][1] for drive in drives]
    if "friction" in given:
        given["lateral"] = [[drive["lateral"][axis] for drive in drives] for axis in (0, 1)]
    if "prony" in body and body.prony:
        given["time"] = np.diff([drive["time"] for drive in drives], prepend=0.0)
    if "wear" in given and given["wear"].by == "distance":
        given["distance"] = np.diff([drive["distance"] for drive in drives], prepend=0.0)
    surface = gfmd.Surface(heights(case["parts"]["surface"]))
    found = gfmd.path(surface, body, steps=1, tolerance=1e-10, energy_solves=0, **given).steps
    names = {
        "approach": "approach",
        "elastic_energy": "elastic",
        "max_pressure": "max_repulsion",
        "wear_volume": "wear_volume",
        "plastic_volume": "plastic_volume",
        "lost_relaxation": "loss_visc",
        "lost_friction": "loss_friction_mean_limits",
        "lost_wear": "loss_wear",
        "lost_plastic": "loss_plastic",
    }
    compared = 0
    for column, key in names.items():
        if column in found:
            reference = np.array([step[key] for step in wanted])
            assert found[column] == pytest.approx(reference, abs=1e-6 * np.abs(reference).max() + 1e-15), column
            compared += 1
    assert compared >= 4
    if "lateral" in given:
        shear = np.array([[step["shear_x"], step["shear_y"]] for step in wanted])
        assert found.mean_shear == pytest.approx(shear, abs=1e-6 * np.abs(shear).max())
        assert (found.stick_fraction * N * N).tolist() == [step["stick"] for step in wanted]
    assert (found.area_fraction * N * N).tolist() == [step["contact"] for step in wanted]


@pytest.mark.parametrize(
    ("words", "body", "given"),
    [
        (
            ["--law=exponential", "--param=gamma=2e-4,range=0.01", "--friction=0.3", "--shear-strength=0.02"],
            {},
            dict(law=gfmd.law("exponential", gamma=2e-4, range=0.01), friction=0.3, shear_strength=0.02),
        ),
        (
            ["--law=exponential", "--param=gamma=2e-4,range=0.01", "--friction=0.3", "--friction-of=net"],
            {},
            dict(law=gfmd.law("exponential", gamma=2e-4, range=0.01), friction=0.3, friction_of="net"),
        ),
        (["--hardness=0.1", "--friction=0.3"], {}, dict(hardness=0.1, friction=0.3)),
        (
            ["--friction=0.3", "--coefficient=3", "--wear-by=slip"],
            {},
            dict(friction=0.3, wear=gfmd.Wear(3.0, by="slip")),
        ),
        (
            ["--friction=0.3", "--coefficient=3", "--distance=0,0.1", "--prony=0.1:0.3", "--time=0,1"],
            dict(prony=[(0.1, 0.3)]),
            dict(friction=0.3, wear=gfmd.Wear(3.0), distance=[0, 0.1], time=[0, 1]),
        ),
    ],
)
def test_the_numbers_are_those_of_the_program(words, body, given, run_program):
    flags = ["--n=16", "--eps-f-inv=4", "--pressure=0.01", "--lateral=0,0.002", "--lateral-y=0,0.001", "--steps=2"]
    wanted = run_program("path", *flags, *words)
    lateral = ([0, 0.002], [0, 0.001])
    found = gfmd.path(rough(), gfmd.Body(**body), pressure=0.01, lateral=lateral, steps=2, **given)
    assert len(found.steps.approach) == len(wanted["steps"])
    lost = [name for name in wanted["steps"][0] if name.startswith("lost_") and "_limit" not in name]
    assert len(lost) > 1 or "hardness" not in given
    for name in ("approach", "mean_shear", "area_fraction", "elastic_energy", "dissipated", *lost):
        reported = [np.nan if step[name] is None else step[name] for step in wanted["steps"]]
        assert np.array_equal(found.steps[name], reported, equal_nan=True), name
    if len(lost) > 1:
        assert sum(found.steps[name] for name in lost) == pytest.approx(found.steps.dissipated, rel=1e-12, abs=1e-18)


def test_lateral_displacements_have_two_components():
    given = dict(pressure=0.01, friction=0.3, steps=2)
    both = gfmd.path(rough(), gfmd.Body(), lateral=([0, 0.002], [0, 0.001]), **given)
    assert both.steps.lateral[-1].tolist() == [0.002, 0.001]
    across = gfmd.path(rough(), gfmd.Body(), lateral=(None, [0, 0.001]), **given)
    assert across.steps.lateral[-1].tolist() == [0.0, 0.001] and across.steps.mean_shear[-1, 1] > 0.0
    # A turned direction, or the rows of an array, give an equal displacement.
    turned = gfmd.path(rough(), gfmd.Body(), lateral=[0, 0.001], direction=90.0, **given)
    assert turned.steps.mean_shear == pytest.approx(across.steps.mean_shear, abs=1e-8)
    rows = gfmd.path(rough(), gfmd.Body(), lateral=np.array([[0, 0.002], [0, 0.001]]), **given)
    assert np.array_equal(rows.steps.mean_shear, both.steps.mean_shear)
    pair = gfmd.path(rough(), gfmd.Body(), lateral=(0, 0.001), **given)
    assert pair.steps.lateral[-1].tolist() == [0.001, 0.0]


def test_quantities_may_have_units():
    scan = rough(size="10 um", unit="um")
    wear = gfmd.Wear("3e-12/Pa", by="slip")
    given = dict(friction=0.3, steps=2)
    lateral = ([0, "20 nm"], [0, "0.01 um"])
    body, limits = gfmd.Body(young="2 GPa"), dict(shear_strength="30 MPa", hardness="1 GPa")
    units = gfmd.path(scan, body, wear=wear, pressure="10 MPa", lateral=lateral, **limits, **given)
    bare = gfmd.path(
        scan,
        gfmd.Body(young=2e9),
        wear=gfmd.Wear(3e-12, by="slip"),
        pressure=1e7,
        lateral=([0, 0.02], [0, 0.01]),
        shear_strength=3e7,
        hardness=1e9,
        stress_unit="Pa",
        **given,
    )
    assert np.array_equal(units.steps.wear_volume, bare.steps.wear_volume) and units.steps.wear_volume[-1] > 0.0
    assert units.wear == wear and units.units == ("µm", "Pa")
    assert units.to_dataframe().attrs["units"]["wear_volume"] == "µm"


def test_wear_is_a_frozen_part():
    wear = gfmd.Wear(2)
    assert wear == gfmd.Wear(2.0, by="distance") and pickle.loads(pickle.dumps(wear)) == wear
    with pytest.raises(AttributeError):
        wear.coefficient = 3.0


@pytest.mark.parametrize(
    ("given", "words", "argument"),
    [
        (dict(coefficient=0.0), "coefficient is 0.0; it must be positive and finite", "coefficient"),
        (dict(coefficient="0/Pa"), "coefficient is '0/Pa'; it must be positive and finite", "coefficient"),
        (dict(coefficient=float("inf")), "coefficient is inf; it must be positive and finite", "coefficient"),
        (dict(coefficient=float("nan")), "coefficient is nan; it must be a number", None),
        (dict(coefficient="1 MPa"), 'coefficient is "1 MPa": it is a stress', None),
        (dict(coefficient=1.0, by="time"), "by is 'time'; it must be 'distance' or 'slip'", "by"),
    ],
)
def test_unusable_wear_is_refused(given, words, argument):
    with pytest.raises(gfmd.InputError) as error:
        gfmd.Wear(**given)
    assert words in str(error.value) and error.value.argument == argument


SHEARED = dict(p_star=0.05, lateral=[0, 1e-3], steps=1)
SLIP = gfmd.Wear(1.0, by="slip")
RUBBER = gfmd.Body(poisson=0.3, prony=[(0.1, 0.3)], relaxes="shear")


@pytest.mark.parametrize(
    ("body", "given", "words"),
    [
        (None, dict(p_star=0.05, wear=1.0), "wear is 1.0; it must be a gfmd.Wear"),
        (None, dict(p_star=0.05, wear=gfmd.Wear(1.0)), "distance is missing; it is needed with wear by distance"),
        (None, dict(p_star=0.05, distance=1.0), "distance is given; it must be left out without wear"),
        (
            None,
            dict(friction=0.3, wear=SLIP, distance=1.0, **SHEARED),
            "distance is given; it must be left out with wear by slip",
        ),
        (
            None,
            dict(wear=SLIP, p_star=0.05),
            'by="slip" is given; it must be distance with neither friction nor shear_strength',
        ),
        (None, dict(friction=-0.3, **SHEARED), "friction: mu is -0.3"),
        (None, dict(shear_strength=-0.1, **SHEARED), "shear_strength: "),
        (None, dict(friction=0.3, friction_of="load", **SHEARED), 'friction_of is "load"'),
        (None, dict(friction_of="net", **SHEARED), "friction_of is net; it must be left out without friction"),
        (RUBBER, dict(friction=0.3, time=1.0, **SHEARED), 'left out with relaxes="shear"'),
        (None, dict(friction=0.3, p_star=0.05, lateral=([0, 1, 2], [0, 1])), "lateral has 2 waypoints"),
        (None, dict(friction=0.3, p_star=0.05, lateral=([0, 1], [0, 1], [0, 1])), "lateral has 3 entries with lists"),
        (None, dict(friction=0.3, p_star=0.05, lateral=([0, "x"], [0, 1])), "lateral"),
    ],
)
def test_what_does_not_go_together_is_refused(body, given, words):
    with pytest.raises(gfmd.InputError) as error:
        gfmd.path(rough(), gfmd.Body() if body is None else body, **given)
    assert words in str(error.value), error.value


@pytest.fixture(scope="module")
def worn():
    law = gfmd.law("exponential", gamma=2e-4, range=0.01)
    parts = dict(law=law, friction=0.3, hardness=0.3, wear=gfmd.Wear(5.0, by="slip"))
    return gfmd.path(rough(), gfmd.Body(), p_star=0.05, lateral=[0, 0.005, -0.005], steps=3, **parts)


def test_a_path_of_parts_is_kept_and_copied(worn, tmp_path):
    h5py = pytest.importorskip("h5py")
    assert worn.wear_depth.shape == worn.shear_x.shape == worn.plastic_depth.shape == (3, 16, 16)
    assert worn.wear_depth[-1].mean() == pytest.approx(worn.steps.wear_volume[-1], rel=1e-12)
    assert worn.steps.max_wear[-1] == worn.wear_depth[-1].max()
    worn.save(tmp_path / "worn.h5")
    with h5py.File(tmp_path / "worn.h5") as file:
        assert np.array_equal(file["fields/wear_depth"][...], worn.wear_depth)
        assert np.array_equal(file["path/lost_friction"][...], worn.steps.lost_friction)
    copy = pickle.loads(pickle.dumps(worn))
    assert copy == worn and copy.wear == worn.wear
    table, data = worn.to_dataframe(), worn.to_xarray()
    assert table.lost_wear.tolist() == worn.steps.lost_wear.tolist()
    assert data.wear_depth.dims == ("waypoint", "y", "x") and data.lost_friction.attrs["long_name"]
    assert "depth" in data.wear_depth.attrs["long_name"]
    page = tmp_path / "page.html"
    worn.report(page)
    text = page.read_text(encoding="utf-8")
    assert "exponential, friction, hardness, wear by slip" in text and "Lost by friction" in text
    assert {"the-path", "wear-against-the-lateral-path", "energy-lost-by-cause", "depth-lost"} <= set(worn.figures())


def test_a_path_is_drawn_by_its_parts(worn):
    pytest.importorskip("matplotlib")
    shear = worn.plot()
    assert shear.get_xlabel().startswith("lateral") and shear.get_ylabel().startswith("mean shear")
    losses = worn.plot(y="losses")
    labels = [text.get_text() for text in losses.get_legend().get_texts()]
    assert labels == ["friction", "wear", "plastic", "jumps", "all"]
    assert losses.lines[-1].get_ydata()[-1] == pytest.approx(worn.dissipated)
    by_distance = gfmd.path(rough(), gfmd.Body(), p_star=0.05, wear=gfmd.Wear(1.0), distance=[0, 1.0], steps=2)
    ax = by_distance.plot()
    assert (ax.get_xlabel(), ax.get_ylabel().split(" (")[0]) == ("distance (length)", "wear volume")
    assert worn.plot("step", "lateral").lines[0].get_xdata().tolist()[:3] == [0.0, 1.0, 2.0]
    with pytest.raises(gfmd.InputError, match="the scalar is 'heat'"):
        worn.plot("heat")


def test_friction_takes_every_part():
    law = gfmd.law("exponential", gamma=2e-4, range=0.01)
    options = dict(p_star=0.05, lateral=[0, 1e-3], steps=1)
    both = gfmd.friction(rough(), gfmd.Body(), coefficient=0.3, shear_strength=0.02, law=law, **options)
    same = gfmd.path(rough(), gfmd.Body(), friction=0.3, shear_strength=0.02, law=law, **options)
    assert both == same
    with pytest.raises(gfmd.InputError, match="friction is missing"):
        gfmd.friction(rough(), gfmd.Body(), **options)


def test_the_plastic_strain_of_every_waypoint_is_kept_on_request(tmp_path):
    steel = gfmd.Body(poisson=0.3, yield_stress=0.01, hardening=0.02)
    loads = dict(p_star=[0.0001, 0.05, 0.01], steps=1)
    loop = gfmd.path(rough(), steel, **loads, kept_strain="waypoints")
    assert loop.kept_strain == "waypoints"
    strains = [loop.plastic_strain(waypoint) for waypoint in range(3)]
    assert strains[0].shape == (len(loop.cells), 16, 16) and strains[0].max() == 0.0
    assert [strain.max() for strain in strains] == loop.steps.max_plastic_strain.tolist()
    for waypoint in (-1, -3):
        assert np.array_equal(loop.plastic_strain(waypoint), strains[waypoint])
    assert np.array_equal(pickle.loads(pickle.dumps(loop)).plastic_strain(1), strains[1])
    for waypoint in (3, -4):
        with pytest.raises(gfmd.InputError, match=f"waypoint is {waypoint}; it must be from -3 to 2"):
            loop.plastic_strain(waypoint)
    last = gfmd.path(rough(), steel, **loads)
    assert "kept_strain" not in last and np.array_equal(last.plastic_strain(), strains[2])
    with pytest.raises(gfmd.InputError, match='waypoint is 0; it must be -1 without kept_strain="waypoints"'):
        last.plastic_strain(0)
    with pytest.raises(gfmd.InputError, match="kept_strain is given; it must be left out without yield_stress"):
        gfmd.path(rough(), gfmd.Body(), **loads, kept_strain="waypoints")
    with pytest.raises(gfmd.InputError, match="kept_strain"):
        gfmd.path(rough(), steel, **loads, kept_strain="all")
