"""Files, pages and figures of results: those of the program, from the same numbers."""

import pickle
import re
import xml.etree.ElementTree as ElementTree

import gfmd
import numpy as np
import pytest

ROUGH = gfmd.self_affine(n=32, eps_f_inv=4)
RUBBER = gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)])
PRONY = ("--prony", "0.1:0.3,10:0.4")
# A call, and the words of the command that makes the same: the heights are in a file.
CASES = {
    "path": (
        lambda **more: gfmd.path(ROUGH, gfmd.Body(), p_star=[0.05, 0.01], steps=2, **more),
        ("path", "--surface", "h.npy", "--p-star", "0.05,0.01", "--steps", "2"),
    ),
    "friction": (
        lambda **more: gfmd.friction(
            ROUGH, gfmd.Body(), coefficient=0.3, p_star=0.05, lateral=[0, 0.001], steps=1, **more
        ),
        ("path", "--surface", "h.npy", "--p-star", "0.05", "--friction", "0.3", "--lateral", "0,0.001", "--steps", "1"),
    ),
    "creep": (
        lambda **more: gfmd.path(ROUGH, RUBBER, pressure=0.01, time=[0, 1], steps=1, **more),
        ("path", "--surface", "h.npy", *PRONY, "--pressure", "0.01", "--time", "0,1", "--steps", "1"),
    ),
    "imprint": (
        lambda **more: gfmd.path(ROUGH, gfmd.Body(), p_star=[0.2, 0.01], hardness=0.05, steps=1, **more),
        ("path", "--surface", "h.npy", "--p-star", "0.2,0.01", "--hardness", "0.05", "--steps", "1"),
    ),
    "wear": (
        lambda **more: gfmd.wear(ROUGH, gfmd.Body(), coefficient=1.0, distance=[0, 0.1], p_star=0.05, steps=2, **more),
        ("wear", "--surface", "h.npy", "--coefficient", "1", "--distance", "0,0.1", "--p-star", "0.05", "--steps", "2"),
    ),
    "slide": (
        lambda **more: gfmd.slide(ROUGH, RUBBER, velocity=[0.01, 1.0], p_star=0.05, **more),
        ("slide", "--surface", "h.npy", *PRONY, "--velocity", "0.01,1", "--p-star", "0.05"),
    ),
    "heat": (
        lambda **more: gfmd.slide(
            ROUGH, gfmd.Body(), velocity=1.0, p_star=0.05, heat=(1, 0.01, 0.2, 0.1), friction=0.3, **more
        ),
        (
            "slide",
            "--surface",
            "h.npy",
            "--velocity",
            "1",
            "--p-star",
            "0.05",
            "--heat",
            "1,0.01,0.2,0.1",
            "--friction",
            "0.3",
        ),
    ),
    "punch": (lambda **more: gfmd.punch(n=16, history=True, **more), ("punch", "--n", "16", "--history")),
    "strip": (
        lambda **more: gfmd.punch(n=16, dim=2, refine=2, **more),
        ("punch", "--n", "16", "--dim", "2", "--refine", "2"),
    ),
}
# Words about the run, and about the surface, which is a file of one and an array of the other.
OWN = {
    "command",
    "created",
    "config",
    "content_sha256",
    "description",
    "file",
    "file_sha256",
    "format",
    "notes",
    "details",
    "threads",
}


def contents(path):
    """Values, units and meanings of all variables, and the attributes of all groups, by their names."""
    h5py = pytest.importorskip("h5py")
    found = {}
    with h5py.File(path) as file:

        def see(name, thing):
            about = {key: value for key, value in thing.attrs.items() if key not in OWN and "LIST" not in key}
            found[name] = (
                thing[()] if isinstance(thing, h5py.Dataset) and not name.endswith("seconds") else None,
                about,
            )

        see("", file)
        file.visititems(see)
    return found


def same(a, b):
    assert a.keys() == b.keys()
    for name, (values, about) in a.items():
        assert about == b[name][1], name
        assert np.array_equal(values, b[name][0], equal_nan=getattr(values, "dtype", None) == np.float64), name


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.save("h.npy", ROUGH.heights)
    return tmp_path


@pytest.mark.parametrize("case", CASES)
def test_the_file_is_that_of_the_program(case, folder, run_program):
    made, words = CASES[case]
    length = () if words[0] == "punch" else ("--size", "1")
    run_program(*words, *length, "--out", "theirs.h5")
    result = made(out="ours.h5")
    same(contents("ours.h5"), contents("theirs.h5"))
    # Saved later, and after a pickle: the same bytes.
    result.save("later.h5")
    pickle.loads(pickle.dumps(result)).save("pickled.h5")
    assert (
        (folder / "later.h5").read_bytes() == (folder / "ours.h5").read_bytes() == (folder / "pickled.h5").read_bytes()
    )
    run_program("check", "later.h5")
    # The page and its figures.
    run_program("report", "theirs.h5", "--out", "theirs.html")
    result.report("ours.html")
    drawn = [
        [re.sub(r"figure\d+", "", svg) for svg in re.findall("<svg.*?</svg>", (folder / name).read_text(), re.S)]
        for name in ("ours.html", "theirs.html")
    ]
    assert drawn[0] == drawn[1] and len(drawn[0]) == len(result.figures()) > 1


def equal(one, other):
    """True if two results, records or arrays have the same keys and numbers."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f")
    if isinstance(one, gfmd.Surface):
        return equal(one.heights, other.heights) and (one.size, one.unit) == (other.size, other.unit)
    if hasattr(one, "keys"):
        return one.keys() == other.keys() and all(equal(one[name], other[name]) for name in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(equal, one, other))
    return one == other or (one != one and other != other)


STEEL = gfmd.Body(poisson=0.3, yield_stress=0.01, hardening=0.02)
SLIP = dict(friction=0.5, lateral=[0, 0.002], wear=gfmd.Wear(10.0, by="slip"), tolerance=1e-6)
BETWEEN = dict(lower_surface=gfmd.self_affine(n=32, eps_f_inv=4, seed=7))
PATHS = {
    **{name: made for name, (made, words) in CASES.items() if "path" in words or "wear" in words},
    "steel": lambda **more: gfmd.path(ROUGH, STEEL, p_star=[0.02, 0.001], steps=1, **more),
    "fretting": lambda **more: gfmd.path(ROUGH, gfmd.Body(), pressure=0.01, steps=1, **SLIP, **more),
    "slab": lambda **more: gfmd.path(ROUGH, gfmd.Body(height=0.2), pressure=0.01, steps=1, **BETWEEN, **more),
    "field": lambda **more: gfmd.path(
        ROUGH, gfmd.Body(), p_star=[0.2, 0.01], steps=1, hardness=0.1 + np.abs(ROUGH.heights), **more
    ),
    "sticky": lambda **more: gfmd.path(
        ROUGH, gfmd.Body(), law=gfmd.law("exponential", gamma=1e-4, range=1.2e-3), approach=[-0.004, 0.004], **more
    ),
    "patch": lambda **more: gfmd.path(
        gfmd.sphere("2 mm", size="0.2 mm", n=32),
        gfmd.Body(young="70 GPa", poisson=0.3),
        force=["0.1 N", "0.2 N"],
        boundary="free",
        statistics=True,
        flow=True,
        **more,
    ),
}


@pytest.mark.parametrize("case", PATHS)
def test_a_path_is_loaded_from_its_file(case, folder):
    made = PATHS[case](out="p.h5")
    loaded = gfmd.load("p.h5")
    assert type(loaded) is gfmd.Path
    assert loaded.keys() == made.keys()
    # The steps of a file have the largest part of each residual; what is below is described by its place.
    differing = [name for name in made.keys() - {"steps", "lower"} if not equal(made[name], loaded[name])]
    assert not differing, [(made[name], loaded[name]) for name in differing]
    names = [name for name in made.steps if not name.startswith("residual_")]
    differing = [name for name in names if not equal(made.steps[name], loaded.steps[name])]
    assert not differing, [(made.steps[name], loaded.steps[name]) for name in differing]
    assert equal(made.residual.largest, loaded.residual.largest)
    assert made.get("lower", {}).get("rms_height") == loaded.get("lower", {}).get("rms_height")
    loaded.save("again.h5")
    assert (folder / "again.h5").read_bytes() == (folder / "p.h5").read_bytes()
    assert loaded.figures().keys() == made.figures().keys()


RING = np.hypot(*np.indices((16, 16)) - 8) // 1 == 4
HELD = np.zeros((16, 16, 3)) + np.where(RING, 0.0, 0.01)[..., None]
COATED = gfmd.Body(young=2.0, poisson=0.3, height=0.1, base="half-space", base_young=1.0, base_poisson=0.2)
LINE = gfmd.self_affine(n=32, dim=2, eps_f_inv=4, size="10 um", unit="um")
MANY = {"command": "contact", "contact": {"n": 16, "p_star": [0.1, 0.2]}, "study": {"seed": "1:3"}}
OTHERS = {
    "punch": lambda: gfmd.punch(n=16),
    "grids": lambda: gfmd.punch(n=16, dim=2, refine=3, contact="frictionless", depth=0.1),
    "ring": lambda: gfmd.punch(COATED, size=1.0, mask=RING, traction=HELD, shift=(1e-3, 0)),
    "steps": lambda: gfmd.punch(
        n=16,
        solver="verlet",
        history=True,
        history_modes=[(1, -1, "x"), (0, 1, "z")],
        history_points=[(0.1, 0.2, "z")],
        tolerance=1e-3,
    ),
    "below": lambda: gfmd.interior(gfmd.contact(ROUGH, COATED, p_star=0.05), levels=5, deepest=0.2),
    "slice": lambda: gfmd.punch(n=16).interior(depths=[0.0, 0.1], along="y=0.5", quantities=["stress"]),
    "line": lambda: gfmd.contact(LINE, gfmd.Body(young="3 MPa"), p_star=0.05).interior(depths=["0.5 um", "1 um"]),
    "sweep": lambda: gfmd.kappa_sweep("smoke"),
    "study": lambda: gfmd.study(MANY),
}


@pytest.mark.parametrize("case", OTHERS)
def test_other_results_are_loaded_from_their_files(case, folder):
    made = OTHERS[case]()
    made.save("r.h5")
    loaded = gfmd.load("r.h5")
    assert type(loaded) is type(made) and loaded.units == made.units and repr(loaded) == repr(made)
    names = (made.keys() | loaded.keys()) - {"seconds"}  # a study has the time until its file was written
    differing = [name for name in names if not equal(made.get(name), loaded.get(name))]
    assert not differing, [(name, made.get(name), loaded.get(name)) for name in differing]
    assert loaded == made
    loaded.save("again.h5")
    assert (folder / "again.h5").read_bytes() == (folder / "r.h5").read_bytes()
    if isinstance(made, gfmd.Punch):
        assert loaded.interior(depths=[0.05]) == made.interior(depths=[0.05])


def test_results_of_the_program_are_loaded(folder, run_program):
    run_program("punch", "--n", "16", "--nodes", "inclusive", "--refine", "3", "--out", "punch.h5")
    assert gfmd.load("punch.h5") == gfmd.punch(n=16, nodes="inclusive", refine=3)
    run_program("body", "--surface", "punch.h5", "--depths", "0,0.1", "--slice", "x=0.5", "--out", "below.h5")
    below = gfmd.load("below.h5")
    assert below == gfmd.load("punch.h5").interior(depths=[0.0, 0.1], along="x=0.5") and below.n == [16, 16]
    wave = ("--wave", "1,1,z,0.005", "--young", "1", "--poisson", "0.3", "--height", "1", "--depths", "0.2")
    run_program("body", *wave, "--n", "8", "--out", "wave.h5")
    assert gfmd.load("wave.h5").stress.shape == (1, 8, 8, 6)
    run_program("kappa-sweep", "--preset", "smoke", "--out", "kappa.h5")
    assert gfmd.load("kappa.h5") == gfmd.kappa_sweep("smoke")
    words = ("--n", "32", "--eps-f-inv", "4", "--size", "10um", "--unit", "um")
    run_program("surface", *words, "--statistics", "--out", "surface.h5")
    surface = gfmd.load("surface.h5")
    assert surface == gfmd.self_affine(n=32, eps_f_inv=4, size="10 um", unit="um") and "seed 1" in repr(surface)


def test_a_punch_that_did_not_converge_is_loaded_as_it_ended(folder):
    with pytest.raises(gfmd.NotConverged) as error:
        gfmd.punch(n=16, solver="verlet", max_iterations=3, out="cut.h5")
    made, loaded = error.value.state, gfmd.load("cut.h5")
    assert loaded == made and not loaded.converged and loaded.not_converged.why == made.not_converged.why


@pytest.mark.parametrize("case", ["punch", "below", "sweep", "study"])
def test_a_damaged_file_is_refused_in_one_line(case, folder):
    OTHERS[case]().save("r.h5")
    whole = bytearray((folder / "r.h5").read_bytes())
    refused = 0
    for place in np.linspace(len(whole) // 3, len(whole) - 9, 40).astype(int):
        broken = bytearray(whole)
        broken[place : place + 8] = bytes(255 - byte for byte in broken[place : place + 8])
        (folder / "broken.h5").write_bytes(broken)
        try:
            loaded = gfmd.load("broken.h5")
        except gfmd.InputError as error:
            assert "\n" not in str(error) and len(str(error)) < 300, error
            refused += 1
        else:
            assert type(loaded) is type(gfmd.load("r.h5"))  # a byte that no variable has
    assert refused > 5
    for part in (whole[: len(whole) // 2], b"", b"no file"):
        (folder / "broken.h5").write_bytes(part)
        with pytest.raises(gfmd.InputError, match="^[^\n]*broken.h5[^\n]*$"):
            gfmd.load("broken.h5")


def test_a_path_that_ended_early_is_loaded_as_it_ended(folder):
    with pytest.raises(gfmd.NotConverged) as error:
        gfmd.path(ROUGH, gfmd.Body(), p_star=[0.01, 0.1], steps=2, max_iterations=2, out="cut.h5")
    made, loaded = error.value.state, gfmd.load("cut.h5")
    assert equal(made.steps.mean_pressure, loaded.steps.mean_pressure) and made.parted_at is loaded.parted_at is None
    assert equal(made.steps.converged, loaded.steps.converged) and not loaded.steps.converged[-1]
    assert equal(made.not_converged, loaded.not_converged)
    adhesion = gfmd.law("exponential", gamma=1e-4, range=1.2e-3)
    pulled = gfmd.path(ROUGH, gfmd.Body(), law=adhesion, pressure=[0.001, -0.1], steps=4, coarse=True, out="parted.h5")
    assert pulled.parted_at is not None and gfmd.load("parted.h5").parted_at == pulled.parted_at


def test_figures_are_pictures_under_plain_names(folder):
    below = gfmd.punch(n=16).interior(depths=[0.1, 0.2], out="below.h5")
    contacts = gfmd.contact(ROUGH, gfmd.Body(), p_star=[0.02, 0.05])
    for result, wanted in ((below, "stress-yz"), (contacts, "contact-area-against-pressure"), (contacts[1], "gap")):
        figures = result.figures()
        assert wanted in figures, list(figures)
        assert figures._repr_html_().count("data:image/svg+xml;base64,") == len(figures)
        paths = result.save_figures("drawn")
        assert len(paths) == len(figures) and all(re.fullmatch(r"drawn/[a-z0-9-]+\.svg", path) for path in paths)
        assert all(ElementTree.parse(path).getroot().tag.endswith("svg") for path in paths)
    with pytest.raises(gfmd.InputError, match="folder"):
        below.save_figures("h.npy")
    with pytest.raises(gfmd.InputError, match="no contacts"):
        contacts[:0].figures()


def test_components_below_have_their_names(folder):
    """The page of a punch in plane strain along y has no shear along y, and the one along x and z."""
    below = gfmd.punch(n=16).interior(depths=[0.05], out="below.h5")
    shear = [np.abs(below.stress[..., k]).max() for k in (3, 4, 5)]  # yz, xz, xy
    below.report("below.html")
    page = re.sub("<.*?>", " ", (folder / "below.html").read_text())
    heads = re.findall(r"σ\s+([xyz]{2})", page)
    assert heads[:6] == ["xx", "yy", "zz", "yz", "xz", "xy"] and max(shear) > 0


def test_fields_below_have_the_units_of_their_contact(folder):
    surface = gfmd.self_affine(n=16, size="10 um", unit="um")
    contact = gfmd.contact(surface, gfmd.Body(young="3 MPa"), p_star=0.05)
    below = contact.interior(depths=["0.5 um"], out="below.h5")
    assert (below.unit, below.stress_unit) == ("µm", "Pa")
    units = {
        name: contents("below.h5")[f"fields/{name}"][1]["units"]
        for name in ("displacement", "stress", "strain", "energy_density", "x")
    }
    assert units == {"displacement": "µm", "stress": "Pa", "strain": "1", "energy_density": "Pa", "x": "µm"}


def test_an_early_end_has_its_file(folder, run_program):
    with pytest.raises(gfmd.NotConverged) as caught:
        gfmd.path(ROUGH, gfmd.Body(), p_star=[0.05], steps=2, max_iterations=2, out="cut.h5")
    state = caught.value.state
    state.save("again.h5")
    assert (folder / "cut.h5").read_bytes() == (folder / "again.h5").read_bytes()
    assert run_program("report", "cut.h5", "--out", "cut.html")["figures"] > 0


def test_a_file_that_cannot_be_written_is_refused_before_the_work(folder):
    for out in ("nowhere/p.h5", ".", ""):
        with pytest.raises(gfmd.InputError, match="out"):
            gfmd.path(ROUGH, gfmd.Body(), p_star=[0.05], steps=1, out=out)
    result = gfmd.punch(n=16)
    with pytest.raises(gfmd.InputError, match="path"):
        result.save("nowhere/p.h5")
    with pytest.raises(gfmd.InputError, match="no page that gfmd report made"):
        result.report("h.npy")
    assert np.array_equal(np.load("h.npy"), ROUGH.heights)
