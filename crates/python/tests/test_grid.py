"""The grid error of the numbers."""

import gfmd
import numpy as np
import pytest

BODY = gfmd.Body()
ROUGH = dict(hurst=0.8, eps_t_inv=2, eps_f_inv=6, seed=4)
NAMES = ["area_fraction", "approach", "mean_gap", "elastic_energy", "stiffness"]


def agree(coarse, fine, names=NAMES):
    for name in names:
        [a, of_a], [b, of_b] = ([c[f"{name}_limit"], c[f"{name}_limit_error"]] for c in (coarse, fine))
        assert abs(a - b) <= 1.5 * (of_a + of_b), (name, a, of_a, b, of_b)


def test_two_grids_tell_the_error_of_the_first_also_where_one_does_not():
    [surface, fine] = [gfmd.self_affine(n=n, **ROUGH) for n in (48, 192)]
    estimate, refined, none = [
        gfmd.contact(surface, BODY, p_star=0.1, grid_error=way) for way in ("estimate", "refine", "none")
    ]
    assert estimate.area_fraction == refined.area_fraction == none.area_fraction
    assert "area_fraction_limit" not in none
    agree(estimate, gfmd.contact(fine, BODY, p_star=0.1))
    agree(refined, gfmd.contact(fine, BODY, p_star=0.1))
    assert refined.mean_gap_limit_error < 0.5 * estimate.mean_gap_limit_error
    slab = gfmd.Body(height=0.1, poisson=0.3)
    assert np.isnan(gfmd.contact(surface, slab, p_star=0.1).area_fraction_limit)
    agree(*[gfmd.contact(s, slab, p_star=0.1, grid_error="refine") for s in (surface, fine)])
    several = gfmd.contacts(surface, slab, p_star=[0.05, 0.1], grid_error="refine")
    assert several[1].area_fraction_limit == pytest.approx(
        gfmd.contact(surface, slab, p_star=0.1, grid_error="refine").area_fraction_limit, rel=1e-6
    )


def test_the_grid_is_made_finer_until_all_numbers_are_that_exact():
    surface = gfmd.self_affine(n=48, **ROUGH)
    for accuracy in (0.02, "2%"):
        c = gfmd.contact(surface, BODY, p_star=0.1, accuracy=accuracy)
        assert c.surface.n[0] > 48 and c.surface.size == surface.size
        assert all(c[f"{name}_limit_error"] <= 0.02 * c[f"{name}_limit"] for name in NAMES)
    agree(gfmd.contact(surface, BODY, p_star=0.1), c)
    cs = gfmd.contacts(surface, BODY, p_star=[0.05, 0.1], accuracy=0.05)
    assert len(cs) == 2 and cs[0].surface.n == cs[1].surface.n and cs[0].surface.n[0] > 48


def test_a_path_on_a_finer_grid_tells_the_error_of_the_pull_off():
    surface, law = gfmd.self_affine(n=24, eps_f_inv=4, seed=3), gfmd.law("exponential", gamma=1e-6, range=4e-3)
    options = dict(law=law, approach=[-0.003, 0.002, -0.008], steps=8, energy_solves=0)
    one, two = [gfmd.path(surface, BODY, grid_error=way, **options) for way in ("estimate", "refine")]
    assert one.lowest_mean_pressure == two.lowest_mean_pressure and "lowest_mean_pressure_limit" not in one
    apart = abs(two.lowest_mean_pressure_limit - two.lowest_mean_pressure)
    assert two.lowest_mean_pressure_limit_error == pytest.approx(2.5 * apart)
    assert two.lowest_mean_pressure_grid_error == pytest.approx(3.5 * apart)
    assert np.isnan(one.steps.area_fraction_limit).all() and np.isfinite(two.steps.area_fraction_limit).all()
    assert "not with a law" in one.undefined["area_fraction_limit"]
    wall = gfmd.path(surface, BODY, p_star=[0.1], steps=1, lateral=0.001)
    assert (
        wall.steps.mean_shear_limit.shape == wall.steps.mean_shear.shape and np.isnan(wall.steps.mean_shear_limit).all()
    )


@pytest.mark.parametrize("options", [dict(approach=1e-2), dict(p_star=0.1, boundary="free")])
def test_an_approach_and_a_patch_have_limits_from_two_grids(options):
    c = gfmd.contact(gfmd.self_affine(n=32, eps_f_inv=4), BODY, grid_error="refine", **options)
    assert (
        np.isfinite(c.area_fraction_limit)
        and abs(c.area_fraction - c.area_fraction_limit) <= c.area_fraction_grid_error
    )


@pytest.mark.parametrize(
    "options, wanted",
    [
        (dict(p_star=0.1, accuracy=2), "relative error from 1e-6 to 0.5"),
        (dict(p_star=0.1, accuracy="much"), "relative error from 1e-6 to 0.5"),
        (dict(p_star=0.1, accuracy=0.01, hardness=0.1), "not with a hardness"),
        (dict(approach=1e-3, accuracy=0.01), "the approach counts from the highest point"),
        (dict(p_star=0.1, accuracy=0.01, grid_error="refine"), "accuracy is given with"),
        (dict(p_star=0.1, grid_error="guess"), "grid_error"),
    ],
)
def test_what_cannot_be_made_finer_is_refused(options, wanted):
    with pytest.raises(gfmd.InputError, match=wanted):
        gfmd.contact(gfmd.self_affine(n=32), BODY, **options)
