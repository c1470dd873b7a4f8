"""Surfaces that wear as they slide."""

import pickle

import gfmd
import numpy as np
import pytest

SURFACE = dict(n=32, eps_f_inv=4)


def test_a_surface_runs_in_and_its_volume_is_known():
    body = gfmd.Body()
    worn = gfmd.wear(gfmd.self_affine(**SURFACE), body, coefficient=0.5, distance=[0, 1, 1000], p_star=0.05, steps=10)
    steps = worn.steps
    assert steps.distance.shape == (21,) and worn.wear_depth.shape == worn.pressure.shape == (3, 32, 32)
    assert steps.distance[[0, 10, 20]].tolist() == [0.0, 1.0, 1001.0]
    assert (np.diff(steps.area_fraction) >= 0).all() and steps.area_fraction[-1] == 1.0
    assert steps.max_pressure[-1] == pytest.approx(steps.mean_pressure[-1], rel=1e-6)
    volume = np.cumsum(0.5 * steps.mean_pressure * np.diff(steps.distance, prepend=0.0))
    assert steps.wear_volume == pytest.approx(volume, rel=1e-12)
    assert worn.wear_depth.mean(axis=(1, 2)) == pytest.approx(volume[[0, 10, 20]], rel=1e-12)
    assert worn.wear_volume == steps.wear_volume[-1] and worn.coefficient == 0.5
    # The heights that are left are those that a further contact begins with.
    heights = gfmd.Surface(worn.surface.heights - worn.wear_depth[1])
    left = gfmd.contact(heights, body, pressure=float(steps.mean_pressure[10]))
    assert left.pressure == pytest.approx(worn.pressure[1], abs=1e-5 * steps.max_pressure[10])
    assert pickle.loads(pickle.dumps(worn)).steps.distance.tolist() == steps.distance.tolist()


@pytest.mark.parametrize(
    ("words", "body", "given"),
    [
        (["--pressure=0.01,0.004"], {}, dict(pressure=[0.01, 0.004])),
        (["--approach=0.005", "--height=0.3"], dict(height=0.3), dict(approach=0.005)),
        (["--p-star=0.05", "--boundary=free"], {}, dict(p_star=0.05, boundary="free")),
    ],
)
def test_the_numbers_are_those_of_the_program(words, body, given, run_program):
    flags = ["--n=32", "--eps-f-inv=4", "--coefficient=0.7", "--distance=0.1,2", "--steps=3"]
    wanted = run_program("wear", *flags, *words)
    surface = gfmd.self_affine(**SURFACE)
    worn = gfmd.wear(surface, gfmd.Body(**body), coefficient=0.7, distance=[0.1, 2], steps=3, **given)
    lengths = ("distance", "approach", "wear_volume", "max_wear")
    for name in (*lengths, "mean_pressure", "max_pressure", "dissipated", "elastic_energy"):
        assert worn.steps[name].tolist() == [step[name] for step in wanted["steps"]], name
    assert (worn.wear_volume, worn.dissipated) == (wanted["wear_volume"], wanted["dissipated"])


def test_quantities_may_have_units():
    made = gfmd.self_affine(**SURFACE)
    surface = gfmd.Surface(made.heights, size=made.size, unit="um")
    body = gfmd.Body(young="2GPa")
    units = gfmd.wear(surface, body, coefficient="3e-12 1/Pa", distance="1mm", pressure="10MPa", steps=2)
    bare = gfmd.wear(surface, gfmd.Body(young=2e9), coefficient=3e-12, distance=1000.0, pressure=1e7, steps=2)
    assert units.steps.wear_volume.tolist() == bare.steps.wear_volume.tolist()
    # The load grows over the first leg: half of it at the first of two steps.
    assert units.wear_volume == pytest.approx(0.75 * 3e-12 * 1e7 * 1000.0, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (dict(coefficient=0.0), "coefficient is 0.0; it must be positive and finite"),
        (dict(coefficient=float("nan")), "coefficient is"),
        (dict(distance=-1.0), "distance is -1; it must be finite and not negative"),
        (dict(distance=[]), "distance"),
        (dict(distance=[1, 2], p_star=[0.1, 0.2, 0.3]), "distance has 2 waypoints; it must have 1 or 3"),
        (dict(p_star=-0.1), "p_star is -0.1; it must be finite and not negative"),
        (dict(p_star=None), "the path is given by none"),
        (dict(steps=0), "steps is 0"),
    ],
)
def test_unusable_arguments_are_refused(given, words):
    arguments = {**dict(coefficient=1.0, distance=1.0, p_star=0.05), **given}
    with pytest.raises(gfmd.InputError) as error:
        gfmd.wear(gfmd.self_affine(n=16, eps_f_inv=4), gfmd.Body(), **arguments)
    assert words in str(error.value), error.value


def test_other_parts_of_a_path_may_be_given():
    rubber = gfmd.Body(prony=[(1.0, 0.5)])
    given = dict(coefficient=1.0, distance=[0, 1.0], time=[0, 1.0], p_star=0.05, steps=1)
    worn = gfmd.wear(gfmd.self_affine(n=16, eps_f_inv=4), rubber, **given)
    assert isinstance(worn, gfmd.Path) and worn.wear == gfmd.Wear(1.0)
    assert worn.wear_volume > 0.0 and worn.steps.lost_relaxation[-1] > 0.0
