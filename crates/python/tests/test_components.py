"""Contacts with other unknown components of the displacement; the dynamics and the history of a punch."""

import pickle

import gfmd
import numpy as np
import pytest

BODY = gfmd.Body(young=1.0, poisson=0.3, height=0.5)
SMALL = gfmd.self_affine(n=15, eps_t_inv=1, eps_f_inv=5)


def test_all_components_are_those_that_follow_from_the_pressure(tmp_path):
    normal = gfmd.contact(SMALL, BODY, p_star=0.1, tolerance=1e-10)
    found = gfmd.contact(SMALL, BODY, p_star=0.1, tolerance=1e-10, components="all")
    assert found.stiffness == normal.stiffness and found.residual.lateral_traction == 0
    c = gfmd.contact(SMALL, BODY, p_star=0.1, tolerance=1e-10, components="all", solver="fire")
    assert np.abs(c.displacement_x - found.displacement_x).max() < 1e-7 * np.abs(c.displacement_x).max()
    assert normal.components == "normal" and normal.displacement_x is None
    assert c.components == "all" and c.contact_nodes == normal.contact_nodes
    assert abs(c.stiffness / normal.stiffness - 1) < 1e-5
    assert c.residual.lateral_traction <= 1e-10
    size = np.abs(c.displacement_z).max()
    assert np.abs(c.displacement_z - normal.displacement_z).max() < 1e-7 * size
    surface = normal.interior(depths=[0.0], quantities=["displacement"]).displacement[0]
    for axis, field in enumerate((c.displacement_x, c.displacement_y)):
        assert np.abs(field).max() > 0.01 * size and np.abs(field - surface[..., axis]).max() < 1e-7 * size
    c.save(tmp_path / "c.h5")
    for again in (gfmd.load(tmp_path / "c.h5"), pickle.loads(pickle.dumps(c))):
        assert again.components == "all" and np.array_equal(again.displacement_y, c.displacement_y)
        assert dict(again.residual) == dict(c.residual)
        for solver in ("auto", "fire"):
            options = dict(p_star=0.11, components="all", solver=solver)
            # A state that the other solver found is a start, too.
            other, *started = (gfmd.contact(SMALL, BODY, start=start, **options) for start in (found, again, c))
            assert np.allclose(started[0].pressure, started[1].pressure, atol=1e-6 * c.max_pressure)
            assert np.allclose(other.pressure, started[1].pressure, atol=1e-6 * c.max_pressure)


def test_a_surface_that_is_held_sideways_is_stiffer():
    half_space, s = gfmd.Body(young=1.0, poisson=0.33), (1 - 0.66) / (2 - 0.66)
    held = gfmd.contact(SMALL, half_space, pressure=0.002, components="held", tolerance=1e-10)
    stiffer = gfmd.Body(e_star=1 / (1 - 0.33**2) / (1 - s**2))
    wanted = gfmd.contact(SMALL, stiffer, pressure=0.002, tolerance=1e-10)
    assert held.approach == pytest.approx(wanted.approach, rel=1e-8) and held.displacement_x is None
    surface = held.interior(depths=[0.0], quantities=["displacement"]).displacement[0]
    assert np.abs(surface[..., :2]).max() < 1e-12 * np.abs(surface[..., 2]).max()


def test_components_that_cannot_be_unknown_are_named():
    law = gfmd.law("morse", gamma=1e-4, range=5e-3)
    for call, words in [
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, components="both"), 'components is "both"'),
        (lambda: gfmd.contact(SMALL, BODY, p_star=0.1, components="all", law=law, solver="cg"), "solver"),
        (
            lambda: gfmd.contact(
                SMALL, BODY, p_star=0.1, components="held", start=gfmd.contact(SMALL, BODY, p_star=0.1)
            ),
            "start has components='normal'",
        ),
    ]:
        with pytest.raises(gfmd.InputError) as reported:
            call()
        assert str(reported.value).startswith(words), str(reported.value)


def test_a_punch_has_dynamics_of_its_own_and_their_history():
    wanted = gfmd.punch(n=12, tolerance=1e-9).mean_pressure
    given = [
        dict(solver="verlet-modes", dt=0.5),
        dict(solver="verlet-critical", dt=0.5, damping=2.0),
        dict(solver="verlet-critical", damping=[1.0, 1.0, 0.8]),
    ]
    for options in given:
        modes, points = [(1, 0, "x"), (-1, 2, "z")], [(0.635, 0.635, "z")]
        punch = gfmd.punch(n=12, tolerance=1e-9, history=True, history_modes=modes, history_points=points, **options)
        assert punch.mean_pressure == pytest.approx(wanted, rel=1e-7)
        history = punch.history
        assert len(history.iteration) == len(history.residual) == punch.iterations + 1
        assert history.energy[-1] == pytest.approx(punch.elastic_energy, rel=1e-6)
        assert history.modes[1].mode == [-1, 2] and len(history.modes[1].re) == len(history.iteration)
        assert np.all(history.points[0].u == -0.005)
    assert np.isnan(gfmd.punch(n=12, history=True).history.energy[0])


def test_ragged_options_are_refused():
    with pytest.raises(gfmd.InputError, match="entries of three"):
        gfmd.punch(n=8, history=True, history_modes=[[], [0.0]])
