"""Viscoelastic bodies: a path in time, and steady sliding."""

import pickle

import numpy as np
import pytest

import gfmd

RUBBER = {"prony": [(0.1, 0.3), (10.0, 0.4)]}


def test_creep_grows_from_the_instantaneous_to_the_long_term_contact():
    surface = gfmd.self_affine(n=32, eps_f_inv=4)
    creep = gfmd.path(surface, gfmd.Body(**RUBBER), pressure=0.01, time=[0, 1, 1e4], steps=1, tolerance=1e-10)
    assert creep.steps.time.tolist() == [0.0, 1.0, 10001.0]
    assert creep.pressure.shape == (3, 32, 32)
    assert (creep.young_long_term, round(creep.young_instantaneous, 12)) == (1.0, round(1 / 0.3, 12))
    at_once = gfmd.contact(surface, gfmd.Body(young=1 / 0.3), pressure=0.01, tolerance=1e-10)
    assert creep.steps.approach[0] == pytest.approx(at_once.approach, rel=1e-8)
    assert (np.diff(creep.steps.area_fraction) > 0).all() and (creep.steps.dissipated >= 0).all()


def test_a_seal_that_is_sheared_after_a_day_has_steps_for_each_leg():
    surface, body = gfmd.self_affine(n=16, eps_f_inv=4), gfmd.Body(poisson=0.5, prony=[(1.0, 0.4)])
    given = dict(pressure=0.01, friction=0.3, time=[0, 86400, 10], lateral=[0, 0, 1e-3], tolerance=1e-6)
    seal = gfmd.path(surface, body, steps=np.array([1, 2, 3]), **given)
    assert seal.steps.time.tolist()[:3] == [0.0, 43200.0, 86400.0] and len(seal.steps.time) == 6
    assert [leg.leg for leg in seal.sliding] == [3] and seal.pressure.shape == (3, 16, 16)
    alike = gfmd.path(surface, body, steps=[2], **given), gfmd.path(surface, body, steps=2, **given)
    assert np.array_equal(*(path.steps.mean_shear for path in alike))
    for wrong in ([], 0, [1, 0, 3], 2.5, [1, "x"], "2", True, [1, 2**32, 1]):
        with pytest.raises(gfmd.InputError, match=r"^steps\b"):
            gfmd.path(surface, body, steps=wrong, **given)
    with pytest.raises(gfmd.InputError, match="steps has 2 numbers; it must have 1 or 3, one for each leg"):
        gfmd.path(surface, body, steps=[1, 2], **given)


def test_moduli_and_relaxes_are_those_of_the_body():
    body = gfmd.Body(young=10.0, poisson=0.3, height=0.3, moduli="instantaneous", relaxes="shear", **RUBBER)
    assert pickle.loads(pickle.dumps(body)) == body != gfmd.Body(young=10.0, poisson=0.3, height=0.3, **RUBBER)
    path = gfmd.path(gfmd.self_affine(n=24, eps_f_inv=4), body, p_star=0.05, time=1.0, steps=2)
    assert path.young_instantaneous == pytest.approx(10.0) and path.relaxes == "shear"


def test_sliding_has_friction_at_every_load_and_velocity():
    surface = gfmd.self_affine(n=32, eps_f_inv=4)
    sliding = gfmd.slide(surface, gfmd.Body(**RUBBER), velocity=[0.01, 1.0], p_star=[0.02, 0.1])
    states = sliding.states
    assert states.velocity.tolist() == [0.01, 1.0, 0.01, 1.0] and sliding.gap.shape == (4, 32, 32)
    assert (states.friction > 0).all() and states.converged.all() and (states.persson_friction > 0).all()
    assert sliding.direction == [1.0, 0.0]


def test_heat_warms_the_contact_and_is_shared():
    surface = gfmd.self_affine(n=32, eps_f_inv=4)
    given = dict(velocity=[0.1, 10.0], p_star=0.05, friction=0.3)
    alone = gfmd.slide(surface, gfmd.Body(), heat=(1.0, 0.01), **given)
    assert alone.temperature.shape == (2, 32, 32) and "heat_flux" not in alone and "prony" not in alone
    assert (alone.states.heat_fraction == 1).all() and (alone.states.dissipated_power == 0).all()
    # The lift moves contacts of a compressible body behind the summits.
    assert (alone.states.friction < 0.3).all() and (alone.states.friction > 0.28).all()
    flux = 0.3 * alone.states.velocity * alone.states.mean_pressure
    assert alone.states.heat_mean_flux == pytest.approx(flux)
    rise = np.where(alone.pressure > 0, alone.temperature, -np.inf).max(axis=(1, 2))
    assert alone.states.heat_max_rise == pytest.approx(rise)
    shared = gfmd.slide(surface, gfmd.Body(**RUBBER), heat=(1.0, 0.01, 0.2, 0.1), **given)
    fraction = shared.heat_flux.mean(axis=(1, 2)) / shared.states.heat_mean_flux
    assert shared.states.heat_fraction == pytest.approx(fraction) and (shared.states.heat_residual <= 1e-8).all()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"prony": [(0.0, 0.5)]}, "a relaxation time of prony is 0.0; it must be positive and finite"),
        ({"prony": [(1.0, 1.5)]}, "a fraction of prony is 1.5; it must be above 0 and below 1"),
        ({"prony": [(1.0, 0.5), (1.0, 0.2)]}, "its relaxation times must differ"),
        ({"prony": [(1.0, 0.5), (2.0, 0.5)]}, "its fractions must add up to less than 1"),
        ({"prony": [(1.0,)]}, "it must be a list of"),
        ({"moduli": "instantaneous"}, "moduli is 'instantaneous'; it must be left out without prony"),
        ({"relaxes": "bulk", **RUBBER}, "relaxes is 'bulk'; it must be 'both' or 'shear'"),
    ],
)
def test_bodies_that_no_material_is_are_refused(given, words):
    with pytest.raises(gfmd.InputError, match=".*") as error:
        gfmd.Body(**given)
    assert words in str(error.value)


def test_friction_and_a_hardness_while_sliding():
    surface = gfmd.self_affine(n=24, eps_f_inv=6)
    given = dict(velocity=[0.1, 1.0], p_star=0.1)
    rubber = gfmd.Body(poisson=0.5, prony=[(0.1, 0.3), (10.0, 0.4)])
    plain, rubbing = gfmd.slide(surface, rubber, **given), gfmd.slide(surface, rubber, friction=0.3, **given)
    assert np.array_equal(plain.pressure, rubbing.pressure)
    assert np.array_equal(rubbing.states.friction, 0.3 + plain.states.friction)
    assert np.array_equal(rubbing.states.friction_hysteresis, plain.states.friction)
    assert np.all(rubbing.states.friction_interface == 0.3) and np.all(plain.states.friction_interface == 0)
    elastic = gfmd.slide(surface, gfmd.Body(poisson=0.2), friction=0.3, **given)
    assert np.all(elastic.states.friction_hysteresis < 0) and np.all(elastic.states.dissipated_power == 0)
    hard = gfmd.slide(surface, rubber, hardness=0.05, **given)
    each = gfmd.slide(surface, rubber, hardness=np.full((24, 24), 0.05), **given)
    assert hard.hardness == 0.05 and each.hardness.shape == (24, 24)
    assert hard.pressure.max() == 0.05 and np.all(hard.states.plastic_fraction > 0)
    assert np.array_equal(hard.plastic_depth, each.plastic_depth)
    assert np.allclose(hard.plastic_depth.mean(axis=(1, 2)), hard.states.plastic_volume)


def test_what_does_not_go_together_is_refused():
    surface, rubber = gfmd.self_affine(n=16, eps_f_inv=4), gfmd.Body(**RUBBER)
    with pytest.raises(gfmd.InputError, match="body is viscoelastic; it must be elastic here"):
        gfmd.contact(surface, rubber, p_star=0.05)
    with pytest.raises(gfmd.InputError, match="time is missing"):
        gfmd.path(surface, rubber, p_star=0.05)
    with pytest.raises(gfmd.InputError, match="body is elastic; it must be viscoelastic to slide without friction"):
        gfmd.slide(surface, gfmd.Body(), velocity=1.0, p_star=0.05)
    with pytest.raises(gfmd.InputError, match="friction is missing; it is needed with heat"):
        gfmd.slide(surface, rubber, velocity=1.0, p_star=0.05, heat=(1, 1))
    with pytest.raises(gfmd.InputError, match="friction is -1; it must be at least 0"):
        gfmd.slide(surface, rubber, velocity=1.0, p_star=0.05, friction=-1)
    with pytest.raises(gfmd.InputError, match="the mean pressure is 0.05; it must be .*hardness"):
        gfmd.slide(surface, rubber, velocity=1.0, pressure=0.05, hardness=0.05)
    for heat, words in [
        ((1,), "heat has 1 numbers"),
        (1, "heat is 1;"),
        ((1, 0), "diffusivity is 0"),
        ("1,1", "heat is '1,1'"),
    ]:
        with pytest.raises(gfmd.InputError, match=words):
            gfmd.slide(surface, gfmd.Body(), velocity=1.0, p_star=0.05, heat=heat, friction=0.3)
    table = gfmd.Body(young=1.0, compliance=([1.0, 10.0, 100.0, 1e3, 1e4], [2.0, 0.2, 0.02, 2e-3, 2e-4]))
    with pytest.raises(gfmd.InputError, match="body has a table of compliances; it must have moduli to slide"):
        gfmd.slide(surface, table, velocity=1.0, pressure=0.01, heat=(1, 1), friction=0.3)
    with pytest.raises(gfmd.InputError, match="velocity is 0; it must be positive and finite"):
        gfmd.slide(surface, rubber, velocity=0.0, p_star=0.05)
