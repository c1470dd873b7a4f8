"""The numbers are those of the program, bit for bit."""

import math
import pickle
import re

import gfmd
import numpy as np
import pytest

GENERATED = ["--n=64", "--hurst=0.7", "--rms-gradient=0.2", "--seed=3"]
SURFACE = dict(n=64, hurst=0.7, rms_gradient=0.2, seed=3)
MORSE = dict(gamma=2e-4, range=2e-3)
TIMES = ("seconds", "peak_bytes")

CASES = {
    "pressures": (["--pressure=0.002,0.01"], SURFACE, {}, dict(pressure=[0.002, 0.01])),
    "reduced": (["--p-star=0.01,0.1"], SURFACE, {}, dict(p_star=[0.01, 0.1])),
    "approach": (["--approach=0.002"], SURFACE, {}, dict(approach=[0.002])),
    "slab": (
        ["--p-star=0.05", "--height=0.3", "--young=7", "--poisson=0.4"],
        SURFACE,
        dict(young=7.0, poisson=0.4, height=0.3),
        dict(p_star=[0.05]),
    ),
    "incompressible": (
        ["--p-star=0.05", "--height=0.5", "--poisson=0.5"],
        SURFACE,
        dict(poisson=0.5, height=0.5),
        dict(p_star=[0.05]),
    ),
    "contact modulus": (
        ["--p-star=0.05", "--e-star=3.3", "--poisson=0.2"],
        SURFACE,
        dict(e_star=3.3, poisson=0.2),
        dict(p_star=[0.05]),
    ),
    "sliding": (
        ["--p-star=0.05", "--height=0.3", "--base=sliding"],
        SURFACE,
        dict(height=0.3, base="sliding"),
        dict(p_star=[0.05]),
    ),
    "coated": (
        [
            "--p-star=0.05",
            "--height=0.05",
            "--layer=3.0,0.3,0.1",
            "--base=half-space",
            "--base-young=9.0",
            "--base-poisson=0.2",
        ],
        SURFACE,
        dict(height=0.05, layers=[(3.0, 0.3, 0.1)], base="half-space", base_young=9.0, base_poisson=0.2),
        dict(p_star=[0.05]),
    ),
    "pair": (
        ["--p-star=0.05", "--e-star=1.5", "--second-body=3.0,0.3,0.2"],
        SURFACE,
        dict(e_star=1.5, second_body=(3.0, 0.3, 0.2)),
        dict(p_star=[0.05]),
    ),
    "cg": (
        ["--p-star=0.05", "--solver=cg", "--tolerance=1e-10"],
        SURFACE,
        {},
        dict(p_star=[0.05], solver="cg", tolerance=1e-10),
    ),
    "fire": (["--p-star=0.1", "--solver=fire"], SURFACE, {}, dict(p_star=[0.1], solver="fire")),
    "verlet": (["--p-star=0.1", "--solver=verlet"], SURFACE, {}, dict(p_star=[0.1], solver="verlet")),
    "morse": (
        ["--p-star=0.05,0.0,-0.0005", "--law=morse", "--param=gamma=0.0002,range=0.002"],
        SURFACE,
        {},
        dict(p_star=[0.05, 0.0, -0.0005], law=("morse", MORSE)),
    ),
    "exponential": (
        ["--approach=0.001,-0.001", "--law=exponential", "--param=gamma=0.0002,range=0.002"],
        SURFACE,
        {},
        dict(approach=[0.001, -0.001], law=("exponential", MORSE)),
    ),
    "patch": (["--p-star=0.05", "--boundary=free"], SURFACE, {}, dict(p_star=[0.05], boundary="free")),
    "sticky patch": (
        ["--p-star=0.05,0.0", "--boundary=free", "--law=morse", "--param=gamma=0.0002,range=0.002"],
        SURFACE,
        {},
        dict(p_star=[0.05, 0.0], boundary="free", law=("morse", MORSE)),
    ),
    "patch of a slab": (
        ["--approach=0.003", "--boundary=free", "--height=0.2", "--poisson=0.4"],
        SURFACE,
        dict(height=0.2, poisson=0.4),
        dict(approach=[0.003], boundary="free"),
    ),
    "continued": (
        ["--approach=-0.001,0.001", "--law=exponential", "--param=gamma=0.0002,range=0.002", "--range-continuation"],
        SURFACE,
        {},
        dict(approach=[-0.001, 0.001], law=("exponential", MORSE), range_continuation=True),
    ),
    "coarse": (
        ["--p-star=0.05", "--law=morse", "--param=gamma=0.0002,range=1e-4", "--coarse"],
        SURFACE,
        {},
        dict(p_star=[0.05], law=("morse", dict(gamma=2e-4, range=1e-4)), coarse=True),
    ),
    "finite slopes": (
        ["--p-star=0.01,0.1", "--finite-slope", "--poisson=0.3"],
        SURFACE,
        dict(poisson=0.3),
        dict(p_star=[0.01, 0.1], finite_slope=True),
    ),
    "finite slopes, approach": (
        ["--approach=0.004", "--finite-slope", "--height=0.4"],
        SURFACE,
        dict(height=0.4),
        dict(approach=[0.004], finite_slope=True),
    ),
    "finite slopes, line": (
        ["--p-star=0.05", "--dim=2", "--finite-slope"],
        dict(SURFACE, dim=2),
        {},
        dict(p_star=[0.05], finite_slope=True),
    ),
    "squeezed": (
        ["--p-star=0.02,0.1", "--height=0.3", "--poisson=0.3", "--lower-seed=4"],
        SURFACE,
        dict(poisson=0.3, height=0.3),
        dict(p_star=[0.02, 0.1], lower_surface=dict(SURFACE, seed=4)),
    ),
    "squeezed, approach": (
        ["--approach=0.02", "--height=0.2", "--layer=3.0,0.3,0.1", "--lower-seed=4"],
        SURFACE,
        dict(height=0.2, layers=[(3.0, 0.3, 0.1)]),
        dict(approach=[0.02], lower_surface=dict(SURFACE, seed=4)),
    ),
    "squeezed line": (
        ["--p-star=0.05", "--dim=2", "--height=0.3", "--lower-seed=4"],
        dict(SURFACE, dim=2),
        dict(height=0.3),
        dict(p_star=[0.05], lower_surface=dict(SURFACE, dim=2, seed=4)),
    ),
    "size": (["--p-star=0.05", "--size=1.3"], dict(SURFACE, size=1.3), {}, dict(p_star=[0.05])),
    "oblong": (["--p-star=0.05", "--n=64,48"], dict(SURFACE, n=(64, 48)), {}, dict(p_star=[0.05])),
    "line": (["--p-star=0.05", "--dim=2"], dict(SURFACE, dim=2), {}, dict(p_star=[0.05])),
}


def same(found, wanted, where=""):
    for name, value in wanted.items():
        if name in TIMES:
            continue
        if name == "undefined" and any(isinstance(keys, list) for keys in value.values()):
            value = {key: reason for reason, keys in value.items() for key in keys}
        if isinstance(value, (dict, gfmd.Record)):
            same(found[name], value, f"{where}{name}.")
        elif value is None or value != value:
            assert math.isnan(found[name]), where + name
        else:
            assert found[name] == value, (where + name, found[name], value)


@pytest.mark.parametrize("name", CASES)
def test_contacts_have_the_numbers_of_the_program(name, run_program, tmp_path):
    flags, surface, body, loads = CASES[name]
    loads = dict(loads)
    if "law" in loads:
        loads["law"] = gfmd.law(loads["law"][0], **loads["law"][1])
    if "lower_surface" in loads:
        loads["lower_surface"] = gfmd.self_affine(**loads["lower_surface"])
    file = tmp_path / "c.h5"
    generated = [flag for flag in GENERATED if not any(flag.split("=")[0] == other.split("=")[0] for other in flags)]
    wanted = run_program("contact", *generated, *flags, f"--out={file}")
    found = gfmd.contacts(gfmd.self_affine(**surface), gfmd.Body(**body), threads=1, **loads)
    assert len(found) == len(wanted["loads"])
    for contact, load in zip(found, wanted["loads"]):
        same(contact, load)
        assert set(load) == set(contact), "each number of the program, and no other"
        assert dict(contact.adhesion() or {}) == wanted.get("adhesion", {})
    read = gfmd.load(file)
    read = [read] if isinstance(read, gfmd.Contact) else read
    for contact, written in zip(found, read):
        assert list(contact._fields) == list(written._fields)
        for field, values in contact._fields.items():
            assert np.array_equal(values, getattr(written, field)), field
        same(written, {key: value for key, value in contact.items() if key not in TIMES and value == value})
        assert np.array_equal(written.surface.heights, contact.surface.heights)


def equal(found, wanted, where):
    assert np.asarray(found).shape == np.asarray(wanted).shape, where
    assert np.array_equal(found, wanted, equal_nan=True), where


def plain(value):
    if isinstance(value, gfmd.Record):
        return {key: plain(entry) for key, entry in value.items()}
    return [plain(entry) for entry in value] if isinstance(value, list) else value


def test_heights_through_numpy_lose_nothing(run_program, tmp_path):
    made = gfmd.self_affine(**SURFACE)
    np.save(tmp_path / "h.npy", made.heights)
    wanted = run_program("contact", f"--surface={tmp_path / 'h.npy'}", "--size=1", "--p-star=0.05")["loads"][0]
    same(gfmd.contact(gfmd.Surface(np.array(made.heights)), gfmd.Body(), p_star=0.05), wanted)
    assert gfmd.read(tmp_path / "h.npy").heights.tobytes() == made.heights.tobytes()


SURFACES = {
    "spectrum": (
        ["--n=64,48", "--hurst=0.3", "--eps-t-inv=3", "--eps-f-inv=5", "--seed=9223372036854775807", "--size=2,1.5"],
        dict(n=(64, 48), hurst=0.3, eps_t_inv=3, eps_f_inv=5, seed=2**63 - 1, size=(2, 1.5)),
    ),
    "rms height": (
        ["--n=64", "--rms-height=0.02", "--amplitudes=fixed"],
        dict(n=64, rms_height=0.02, amplitudes="fixed"),
    ),
    "roll-off": (
        ["--n=64", "--roll-off=0.3", "--roll-off-shape=smooth"],
        dict(n=64, roll_off=0.3, roll_off_shape="smooth"),
    ),
    "points per wave": (
        ["--eps-t-inv=1", "--eps-f-inv=8", "--eps-c-inv=6"],
        dict(eps_t_inv=1, eps_f_inv=8, eps_c_inv=6),
    ),
    "sra": (["--n=65", "--method=sra"], dict(n=65, method="sra")),
    "rmd": (["--n=65", "--method=rmd"], dict(n=65, method="rmd")),
    "profile": (["--n=256", "--dim=2"], dict(n=256, dim=2)),
}


@pytest.mark.parametrize("name", SURFACES)
def test_surfaces_are_those_of_the_program(name, run_program, tmp_path):
    words, arguments = SURFACES[name]
    wanted = run_program("surface", *words, f"--out={tmp_path / 'h.npy'}")
    found = gfmd.self_affine(**arguments)
    heights = np.load(tmp_path / "h.npy")
    assert found.heights.tobytes() == heights.tobytes() and found.size == tuple(wanted["size"])
    statistics = found.statistics()
    fitted = ("source", "unit", "asked", "out", "hurst", "hurst_error", "hurst_range")
    same(statistics, {key: value for key, value in wanted.items() if key not in fitted and not isinstance(value, list)})
    assert set(statistics) == set(wanted) - {"source", "unit", "asked", "out", "warnings"}
    ranges = ",".join(map(repr, statistics.hurst_range))
    wanted = run_program("surface", *words, f"--fit-range={ranges}")
    assert found.statistics(fit_range=statistics.hurst_range).hurst == wanted["hurst"] == statistics.hurst


def test_scans_are_those_of_the_program(run_program, tmp_path):
    heights = gfmd.self_affine(n=48, seed=5).heights + 0.1 * np.arange(48)[:, None]
    np.save(tmp_path / "h.npy", heights)
    for trend in ("plane", "slope", "quadratic"):
        words = [
            f"--surface={tmp_path / 'h.npy'}",
            "--size=2",
            "--flip",
            f"--detrend={trend}",
            "--periodise=mirror",
            f"--out={tmp_path / 'out.npy'}",
        ]
        run_program("surface", *words)
        found = gfmd.read(tmp_path / "h.npy", size=2).flip().detrend(trend).periodise("mirror")
        equal(found.heights, np.load(tmp_path / "out.npy"), trend)


@pytest.mark.parametrize(
    "law",
    [None, gfmd.law("dugdale", gamma=2e-4, range=2e-3), gfmd.law("morse", **MORSE)],
    ids=["wall", "dugdale", "morse"],
)
@pytest.mark.parametrize("load", ["p_star", "approach"])
def test_a_start_from_a_file_or_a_pickle_changes_no_bit(law, load, tmp_path):
    surface, body = gfmd.self_affine(**SURFACE), gfmd.Body(poisson=0.3, height=0.5)
    values = [0.03, 0.06] if load == "p_star" else [0.001, 0.002]
    wanted = gfmd.contacts(surface, body, law=law, **{load: values})
    first = gfmd.contact(surface, body, law=law, **{load: values[0]})
    first.save(tmp_path / "first.h5")
    for start in (first, pickle.loads(pickle.dumps(first)), gfmd.load(tmp_path / "first.h5")):
        again = gfmd.contact(surface, body, law=law, start=start, **{load: values[1]})
        for field in ("pressure", "displacement_z", "gap"):
            equal(getattr(again, field), getattr(wanted[1], field), field)
        same(again, {key: value for key, value in wanted[1].items() if key not in TIMES and value == value})


PATHS = {
    "adhesion": (
        [
            "--n=32",
            "--eps-f-inv=8",
            "--law=exponential",
            "--param=gamma=2e-4,range=5e-3",
            "--approach=-0.004,0.004,-0.008",
            "--steps=4",
        ],
        lambda s: gfmd.path(
            s(eps_f_inv=8),
            gfmd.Body(),
            law=gfmd.law("exponential", gamma=2e-4, range=5e-3),
            approach=[-0.004, 0.004, -0.008],
            steps=4,
        ),
    ),
    "load": (
        ["--n=32", "--p-star=0.01,0.1,0.01", "--steps=3", "--height=0.4", "--young=3", "--poisson=0.3", "--size=2"],
        lambda s: gfmd.path(s(size=2), gfmd.Body(3.0, 0.3, height=0.4), p_star=[0.01, 0.1, 0.01], steps=3),
    ),
    "coulomb": (
        ["--n=32", "--p-star=0.05", "--friction=0.3", "--lateral=0,0.002", "--steps=4"],
        lambda s: gfmd.friction(s(), gfmd.Body(), coefficient=0.3, p_star=0.05, lateral=[0, 0.002], steps=4),
    ),
    "tresca": (
        [
            "--n=32",
            "--pressure=0.005",
            "--shear-strength=0.01",
            "--lateral=0,0.001,0",
            "--direction=30",
            "--steps=3",
            "--poisson=0.5",
        ],
        lambda s: gfmd.friction(
            s(),
            gfmd.Body(poisson=0.5),
            shear_strength=0.01,
            pressure=0.005,
            lateral=[0, 0.001, 0],
            direction=30,
            steps=3,
        ),
    ),
}


@pytest.mark.parametrize("name", PATHS)
def test_paths_are_those_of_the_program(name, run_program, tmp_path):
    h5py = pytest.importorskip("h5py")
    words, call = PATHS[name]
    wanted = run_program("path", *words, f"--out={tmp_path / 'p.h5'}")
    found = call(lambda **more: gfmd.self_affine(n=32, **more))
    for index, step in enumerate(wanted["steps"]):
        step |= {f"residual_{part}": value for part, value in step.pop("residual").items()}
        assert {name for names in step.pop("undefined", {}).values() for name in names} <= set(found.undefined)
        assert set(step) == set(found.steps)
        for key in set(step) - {"seconds"}:
            equal(found.steps[key][index], np.array(step[key], dtype=float), (key, index))
    for key in (
        "dissipated",
        "dissipated_error",
        "extra_solves",
        "lowest_mean_pressure",
        "parted_at",
        "law",
        "direction",
        "n",
        "size",
        "e_star",
        "rms_gradient",
        "rms_height",
    ):
        assert found[key] == wanted[key], key
    assert [dict(leg) for leg in found.sliding] == wanted["sliding"]
    with h5py.File(tmp_path / "p.h5") as file:
        kept = set(file["fields"]) - {"waypoint", "x", "y"}
        assert kept == {key for key in ("pressure", "gap", "displacement_z", "shear_x", "shear_y") if key in found}
        for key in kept:
            equal(found[key], file["fields"][key][...], key)


def test_punches_and_fields_below_are_those_of_the_program(run_program, tmp_path):
    h5py = pytest.importorskip("h5py")
    cases = [
        (["--n=32", "--nodes=inclusive"], dict(n=32, nodes="inclusive"), None),
        (
            ["--n=64", "--dim=2", "--contact=frictionless", "--size=2", "--height=0.7", "--young=3", "--poisson=0.2"],
            dict(n=64, dim=2, contact="frictionless", size=2.0),
            gfmd.Body(3.0, 0.2, height=0.7),
        ),
        (["--n=16", "--refine=2", "--height=inf", "--young=1", "--poisson=0"], dict(n=16, refine=2), gfmd.Body()),
    ]
    for words, arguments, body in cases:
        wanted = run_program("punch", *words, f"--out={tmp_path / 'p.h5'}")
        found = gfmd.punch(body, **arguments)
        assert set(found) == set(wanted) - {"out", "plots", "peak_bytes"} | {"displacement", "traction", "under_punch"}
        wanted["height"] = float(wanted["height"])
        for key in set(wanted) - {"out", "plots", "peak_bytes", "seconds"}:
            assert plain(found[key]) == wanted[key], key
        with h5py.File(tmp_path / "p.h5") as file:
            for key in ("displacement", "traction", "under_punch"):
                equal(found[key], file["fields"][key][...], key)
        below = run_program("body", f"--surface={tmp_path / 'p.h5'}", "--depths=0.1,0.2", f"--out={tmp_path / 'b.h5'}")
        levels = found.interior(depths=[0.1, 0.2])
        assert [dict(level) for level in levels.levels] == below["levels"]
        with h5py.File(tmp_path / "b.h5") as file:
            for key in ("displacement", "strain", "stress", "von_mises", "energy_density"):
                equal(levels[key], file["fields"][key][...], key)


def test_fields_below_a_contact_are_those_of_the_program(run_program, tmp_path):
    h5py = pytest.importorskip("h5py")
    run_program("contact", *GENERATED, "--p-star=0.05", "--poisson=0.3", f"--out={tmp_path / 'c.h5'}")
    run_program(
        "body",
        f"--surface={tmp_path / 'c.h5'}",
        "--levels=3",
        "--deepest=0.2",
        "--slice=y=0.5",
        f"--out={tmp_path / 'b.h5'}",
    )
    contact = gfmd.contact(gfmd.self_affine(**SURFACE), gfmd.Body(poisson=0.3), p_star=0.05)
    below = contact.interior(levels=3, deepest=0.2, along="y=0.5")
    with h5py.File(tmp_path / "b.h5") as file:
        for key in ("displacement", "strain", "stress", "von_mises", "energy_density"):
            equal(below[key], file["fields"][key][...], key)


@pytest.mark.parametrize(
    "words, body",
    [
        (["--height=0.3", "--poisson=0.33"], gfmd.Body(poisson=0.33, height=0.3)),
        (["--height=0.3", "--base=sliding"], gfmd.Body(height=0.3, base="sliding")),
        (["--height=0.3", "--base=free", "--young=2"], gfmd.Body(2.0, height=0.3, base="free")),
        (
            ["--height=0.3", "--base=half-space", "--base-young=5", "--base-poisson=0.4"],
            gfmd.Body(height=0.3, base="half-space", base_young=5.0, base_poisson=0.4),
        ),
    ],
)
def test_green_is_that_of_the_program(words, body, run_program):
    wanted = run_program("green", "--qx=3", "--qy=-4", "--depth=0.1", *words)
    found = gfmd.green(body, qx=3.0, qy=-4.0, depth=0.1)
    assert set(found) == set(wanted)
    for key, value in wanted.items():
        if key in ("stiffness", "compliance", "displacement_transfer", "stress_transfer"):
            value = [[complex(*pair) for pair in row] for row in value]
        assert np.array_equal(found[key], value), key


def test_kappa_sweep_is_that_of_the_program(run_program, tmp_path):
    # Few contacts, and every part of the analysis; the preset is that of the example of `kappa_sweep`.
    points = "eps_t_inv = [1, 2]\neps_f_inv = [4, 8]\neps_c_inv = [2, 4]\ncentre = [1, 4, 2]"
    (tmp_path / "k.toml").write_text(f"[points]\n{points}\n[statistics]\nrealisations = 4\n[fit]\nresamples = 500\n")
    wanted = run_program("kappa-sweep", f"--config={tmp_path / 'k.toml'}", f"--out={tmp_path / 'k.h5'}")
    found = gfmd.kappa_sweep(tmp_path / "k.toml")
    for key in ("points", "fit", "fits", "theory"):
        assert plain(found[key]) == wanted[key], key
    # The file, the page and the figures are those of the program, and a second sweep is equal.
    cells = {"eps_t_inv": [1, 2], "eps_f_inv": [4, 8], "eps_c_inv": [2, 4], "centre": [1, 4, 2]}
    again = gfmd.kappa_sweep(
        {"points": cells, "statistics": {"realisations": 4}, "fit": {"resamples": 500}, "body": {"young": "1 Pa"}}
    )
    assert found == again == pickle.loads(pickle.dumps(found)) and found != wanted and hash(found) == hash(again)
    found.save(tmp_path / "saved.h5")
    assert run_program("check", str(tmp_path / "saved.h5"))["differing"] == 0
    run_program("report", str(tmp_path / "k.h5"), "--out", str(tmp_path / "theirs.html"))
    found.report(tmp_path / "ours.html")
    pages = [(tmp_path / name).read_text() for name in ("ours.html", "theirs.html")]
    drawn = [[re.sub(r"figure\d+", "", svg) for svg in re.findall("<svg.*?</svg>", page, re.S)] for page in pages]
    assert (
        drawn[0] == drawn[1]
        and len(drawn[0]) == len(found.figures()) == len(found.save_figures(tmp_path / "drawn")) > 1
    )
    pytest.importorskip("pandas")
    assert found.to_dataframe().kappa.tolist() == [point.kappa for point in found.points]
