"""Contacts with a hardness, and the stiffness of contacts."""

import pickle

import gfmd
import numpy as np
import pytest

BODY = gfmd.Body(e_star=1.0)
SMALL = gfmd.self_affine(n=32)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_a_hardness_bounds_the_pressure_and_survives_files_and_pickles(boundary, tmp_path):
    c = gfmd.contact(SMALL, BODY, p_star=0.5, hardness=0.12, boundary=boundary)
    assert c.hardness == 0.12 and c.pressure.max() == 0.12 and float(c.residual) <= 1e-8
    assert c.plastic_fraction == np.mean(c.pressure == 0.12) > 0.0
    assert c.plastic_depth.mean() == pytest.approx(c.plastic_volume, rel=1e-12)
    assert np.all(c.plastic_depth[c.pressure < 0.12] == 0.0) and c.residual.saturation <= 1e-8
    c.save(tmp_path / "c.h5")
    for again in (gfmd.load(tmp_path / "c.h5"), pickle.loads(pickle.dumps(c))):
        assert again.hardness == 0.12 and np.array_equal(again.plastic_depth, c.plastic_depth)
        assert dict(again)["plastic_volume"] == c.plastic_volume and again.stiffness == c.stiffness
        assert gfmd.contact(SMALL, BODY, p_star=0.51, hardness=0.12, boundary=boundary, start=again).converged
    hard = gfmd.contact(SMALL, BODY, p_star=0.5, boundary=boundary)
    assert hard.hardness is None and hard.plastic_depth is None and "plastic_fraction" not in hard


def test_a_hardness_that_cannot_be_used_is_named():
    for call, words in [
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, hardness=-1), "hardness is -1; it must be positive"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, hardness="x"), "hardness is 'x'"),
        (
            lambda: gfmd.contact(SMALL, BODY, p_star=0.1, hardness=1, law=gfmd.law("morse", gamma=1e-4, range=5e-3)),
            "hardness is given",
        ),
        (lambda: gfmd.contact(SMALL, BODY, pressure=0.2, hardness=0.1), "pressure: the mean pressure is 0.2"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, hardness=1, solver="cg"), "solver: "),
    ]:
        with pytest.raises(gfmd.InputError) as reported:
            call()
        assert str(reported.value).startswith(words), str(reported.value)


def test_the_stiffness_is_the_slope_of_the_load():
    low, high = (gfmd.contact(SMALL, BODY, approach=d, tolerance=1e-11) for d in (0.004, 0.004002))
    slope = (high.mean_pressure - low.mean_pressure) / (high.approach - low.approach)
    assert 0.5 * (low.stiffness + high.stiffness) == pytest.approx(slope, rel=1e-3)
    exact = gfmd.contact(SMALL, BODY, approach=0.004, tolerance=1e-11, stiffness_tolerance=1e-9)
    assert exact.stiffness_error <= 1e-9 and low.stiffness_error <= 5e-6
    assert low.stiffness == pytest.approx(exact.stiffness, rel=5e-6)
    assert np.isnan(gfmd.contact(SMALL, BODY, p_star=3.0).stiffness)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_a_hardness_may_be_a_field(boundary, tmp_path):
    field = np.where(np.indices((32, 32)).sum(0) // 4 % 2, 0.03, 0.3)
    c = gfmd.contact(SMALL, BODY, p_star=0.3, hardness=field, boundary=boundary)
    assert np.array_equal(c.hardness, field) and np.all(c.pressure <= field) and float(c.residual) <= 1e-8
    assert c.plastic_fraction == np.mean(c.pressure == field) > 0.0
    c.save(tmp_path / "c.h5")
    for again in (gfmd.load(tmp_path / "c.h5"), pickle.loads(pickle.dumps(c))):
        assert np.array_equal(again.hardness, field) and np.array_equal(again.plastic_depth, c.plastic_depth)
    with pytest.raises(gfmd.InputError, match="hardness has the shape"):
        gfmd.contact(SMALL, BODY, p_star=0.3, hardness=field[:5])
    with pytest.raises(gfmd.InputError, match="hardness: "):
        gfmd.contact(SMALL, BODY, p_star=0.3, hardness=0.0 * field)


def test_plastic_depth_stays_along_a_path():
    field = np.full((32, 32), 0.05)
    for hardness in (0.05, field):
        p = gfmd.path(SMALL, BODY, p_star=[0.05, 0.4, 0.02, 0.4], hardness=hardness, steps=2, tolerance=1e-10)
        assert p.plastic_depth.shape == (4, 32, 32) and np.all(np.asarray(p.hardness) == 0.05)
        assert p.plastic_depth[2].mean() == pytest.approx(p.steps.plastic_volume[4], rel=1e-12)
        assert p.steps.approach[6] == pytest.approx(p.steps.approach[2], rel=1e-8)
    free = gfmd.path(SMALL, BODY, p_star=[0.05, 0.4], boundary="free", steps=2)
    assert free.boundary == "free" and free.dissipated == 0.0
    with pytest.raises(gfmd.InputError, match="hardness"):
        gfmd.path(SMALL, BODY, p_star=[0.05, 0.4], hardness=0.1, lateral=[0, 0.001])


def test_two_surfaces_touch_as_their_composite():
    other = gfmd.self_affine(n=32, seed=2)
    both = SMALL.against(other, shift=(3 / 32, 0.0))
    assert np.array_equal(both.heights, SMALL.heights + np.roll(other.heights, 3, axis=0)) and both.n == (32, 32)
    part = SMALL.against(other.heights, shift=(3 / 32, -2 / 32), boundary="free")
    assert np.array_equal(part.heights, SMALL.heights[3:, :-2] + other.heights[:-3, 2:])
    assert part.size == pytest.approx((29 / 32, 30 / 32))
    for call, words in [
        (lambda: SMALL.against(gfmd.self_affine(n=16)), "n of the second surface"),
        (lambda: SMALL.against(other, shift=(0.01, 0), boundary="free"), "shift: "),
        (lambda: SMALL.against(other, shift=(1, 2, 3)), "shift is"),
    ]:
        with pytest.raises(gfmd.InputError, match=words):
            call()
