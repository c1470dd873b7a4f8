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
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, hardness=-1), "hardness: "),
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, hardness="x"), "hardness is 'x'"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, hardness=1, law=gfmd.law("morse", gamma=1e-4, range=5e-3)), "hardness is 1"),
        (lambda: gfmd.contact(SMALL, BODY, mean_pressure=0.2, hardness=0.1), "the mean pressure is 0.2"),
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, hardness=1, solver="cg"), "solver: "),
    ]:
        with pytest.raises(gfmd.InputError) as told:
            call()
        assert str(told.value).startswith(words), str(told.value)


def test_the_stiffness_is_the_slope_of_the_load():
    low, high = (gfmd.contact(SMALL, BODY, approach=d, tolerance=1e-11) for d in (0.004, 0.004002))
    slope = (high.mean_pressure - low.mean_pressure) / (high.approach - low.approach)
    assert 0.5 * (low.stiffness + high.stiffness) == pytest.approx(slope, rel=1e-3)
    assert low.stiffness_error <= 1e-9
    assert np.isnan(gfmd.contact(SMALL, BODY, p_star=3.0).stiffness)
