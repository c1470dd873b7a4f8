"""Estimates without a solution."""

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
