"""The numbers are those of the program, bit for bit."""

import math

import gfmd
import numpy as np
import pytest

GENERATED = ["--n=64", "--hurst=0.7", "--rms-gradient=0.2", "--seed=3"]
SURFACE = dict(n=64, hurst=0.7, rms_gradient=0.2, seed=3)
MORSE = dict(gamma=2e-4, range=2e-3)
TIMES = ("seconds", "peak_bytes")

CASES = {
    "pressures": (["--pressure=0.002,0.01"], SURFACE, {}, dict(mean_pressure=[0.002, 0.01])),
    "reduced": (["--p-star=0.01,0.1"], SURFACE, {}, dict(p_star=[0.01, 0.1])),
    "approach": (["--displacement=0.002"], SURFACE, {}, dict(approach=[0.002])),
    "slab": (["--p-star=0.05", "--height=0.3", "--young=7", "--poisson=0.4"], SURFACE, dict(young=7.0, poisson=0.4, height=0.3), dict(p_star=[0.05])),
    "incompressible": (["--p-star=0.05", "--height=0.5", "--poisson=0.5"], SURFACE, dict(poisson=0.5, height=0.5), dict(p_star=[0.05])),
    "contact modulus": (["--p-star=0.05", "--e-star=3.3", "--poisson=0.2"], SURFACE, dict(e_star=3.3, poisson=0.2), dict(p_star=[0.05])),
    "cg": (["--p-star=0.05", "--solver=cg", "--tol=1e-10"], SURFACE, {}, dict(p_star=[0.05], solver="cg", tolerance=1e-10)),
    "fire": (["--p-star=0.1", "--solver=fire"], SURFACE, {}, dict(p_star=[0.1], solver="fire")),
    "verlet": (["--p-star=0.1", "--solver=verlet"], SURFACE, {}, dict(p_star=[0.1], solver="verlet")),
    "morse": (["--p-star=0.05,0.0,-0.0005", "--law=morse", "--param=gamma=0.0002,range=0.002"], SURFACE, {}, dict(p_star=[0.05, 0.0, -0.0005], law=("morse", MORSE))),
    "exponential": (["--displacement=0.001,-0.001", "--law=exponential", "--param=gamma=0.0002,range=0.002"], SURFACE, {}, dict(approach=[0.001, -0.001], law=("exponential", MORSE))),
    "length": (["--p-star=0.05", "--length=1.3"], dict(SURFACE, size=1.3), {}, dict(p_star=[0.05])),
    "oblong": (["--p-star=0.05", "--n=64,48"], dict(SURFACE, n=(64, 48)), {}, dict(p_star=[0.05])),
    "line": (["--p-star=0.05", "--dim=2"], dict(SURFACE, dim=2), {}, dict(p_star=[0.05])),
}


def same(found, wanted, where=""):
    for name, value in wanted.items():
        if name in TIMES:
            continue
        if isinstance(value, dict):
            same(found[name], value, f"{where}{name}.")
        elif value is None:
            assert math.isnan(found[name]), where + name
        else:
            assert found[name] == value, (where + name, found[name], value)


@pytest.mark.parametrize("name", CASES)
def test_contacts_have_the_numbers_of_the_program(name, run_program, tmp_path):
    flags, surface, body, loads = CASES[name]
    loads = dict(loads)
    if "law" in loads:
        loads["law"] = gfmd.law(loads["law"][0], **loads["law"][1])
    file = tmp_path / "c.h5"
    generated = [flag for flag in GENERATED if not any(flag.split("=")[0] == other.split("=")[0] for other in flags)]
    wanted = run_program("contact", *generated, *flags, f"--out={file}")
    found = gfmd.contacts(gfmd.self_affine(**surface), gfmd.Body(**body), threads=1, **loads)
    assert len(found) == len(wanted["loads"])
    for contact, load in zip(found, wanted["loads"]):
        same(contact, load)
    read = gfmd.load(file)
    read = [read] if isinstance(read, gfmd.Contact) else read
    for contact, written in zip(found, read):
        for field in ("pressure", "displacement_z", "gap"):
            assert np.array_equal(getattr(contact, field), getattr(written, field)), field
        same(written, {key: value for key, value in contact.items() if key not in TIMES and value == value})
        assert np.array_equal(written.surface.heights, contact.surface.heights)


def test_heights_through_numpy_lose_nothing(run_program, tmp_path):
    made = gfmd.self_affine(**SURFACE)
    np.save(tmp_path / "h.npy", made.heights)
    wanted = run_program("contact", f"--surface={tmp_path / 'h.npy'}", "--length=1", "--p-star=0.05")["loads"][0]
    same(gfmd.contact(gfmd.Surface(np.array(made.heights)), gfmd.Body(), p_star=0.05), wanted)
    assert gfmd.read(tmp_path / "h.npy").heights.tobytes() == made.heights.tobytes()


def test_statistics_are_those_of_the_program(run_program):
    wanted = run_program("surface", *GENERATED)
    found = gfmd.self_affine(**SURFACE).statistics()
    for name in ("rms_height", "rms_gradient", "rms_gradient_central", "rms_curvature", "nayak", "m0", "m2", "m4", "highest"):
        assert found[name] == wanted[name], name


def test_paths_are_those_of_the_program(run_program):
    flags = ["--n=32", "--eps-f-inv=8", "--law=exponential", "--param=gamma=2e-4,range=5e-3", "--displacement=-0.004,0.004", "--steps=4"]
    wanted = run_program("path", *flags)
    found = gfmd.path(
        gfmd.self_affine(n=32, eps_f_inv=8), gfmd.Body(), law=gfmd.law("exponential", gamma=2e-4, range=5e-3), approach=[-0.004, 0.004], steps=4
    )
    assert [step["mean_pressure"] for step in wanted["steps"]] == list(found.steps.mean_pressure)
    assert found.dissipated == wanted["dissipated"]


def test_friction_is_that_of_the_program(run_program):
    wanted = run_program("path", "--n=32", "--p-star=0.05", "--friction=0.3", "--lateral=0,0.002", "--steps=4")
    found = gfmd.friction(gfmd.self_affine(n=32), gfmd.Body(), coefficient=0.3, p_star=0.05, lateral=[0, 0.002], steps=4)
    assert found.sliding[0].friction_coefficient == wanted["sliding"][0]["friction_coefficient"]
    assert found.shear_x.shape[1:] == (32, 32)


def test_punch_body_and_green_are_those_of_the_program(run_program, tmp_path):
    wanted = run_program("punch", "--n=32", "--nodes=inclusive", f"--out={tmp_path / 'p.h5'}")
    found = gfmd.punch(n=32, nodes="inclusive")
    same({**found, "height": wanted["height"]}, {key: value for key, value in wanted.items() if key not in ("out", "plots")})
    below = run_program("body", f"--surface={tmp_path / 'p.h5'}", "--depths=0.1,0.2")
    levels = gfmd.interior(found, depths=[0.1, 0.2])
    assert [level["max_von_mises"] for level in below["levels"]] == [level.max_von_mises for level in levels.levels]
    assert levels.stress.shape == (2, 32, 32, 6)
    wanted = run_program("green", "--qx=3", "--qy=4", "--height=0.3", "--young=1", "--poisson=0.33")
    found = gfmd.green(gfmd.Body(1.0, 0.33, height=0.3), qx=3, qy=4)
    assert found.normal_compliance == wanted["normal_compliance"]
    assert found.stiffness[0, 1] == complex(*wanted["stiffness"][0][1])


def test_kappa_sweep_is_that_of_the_program(run_program, tmp_path):
    wanted = run_program("kappa-sweep", "--preset=smoke", f"--out={tmp_path / 'k.h5'}")
    found = gfmd.kappa_sweep("smoke")
    assert found.fit.kappa_tfc == wanted["fit"]["kappa_tfc"]
    assert [point.kappa for point in found.points] == [point["kappa"] for point in wanted["points"]]
