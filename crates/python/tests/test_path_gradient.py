"""Derivatives along paths: difference quotients, pickles, refusals."""

import pickle

import numpy as np
import pytest

import gfmd

HEIGHTS = gfmd.self_affine(n=16, eps_f_inv=2).heights
RUBBER = gfmd.Body(young=2.0, poisson=0.3, prony=[(0.5, 0.3), (4.0, 0.3)])
STEEL = gfmd.Body(young=2.0, poisson=0.3)
RANDOM = np.random.default_rng(1)
PRESSURE, GAP = RANDOM.normal(size=(2, 3, 16, 16))
SLIDING = dict(distance=[0, 0.5, 1.0], wear=gfmd.Wear(0.1))
EXPONENTIAL = gfmd.law("exponential", gamma=2e-3, range=0.02)
# Waypoints end the steps 0, 2 and 4.
PRESSURES = dict(pressure=[0.02, 0.05, 0.03])
APPROACHES = dict(approach=[0.004, 0.008, 0.006])
CASES = [
    (RUBBER, dict(time=[0, 0.5, 2.0])),
    (RUBBER, dict(time=[0, 0.5, 2.0], boundary="free")),
    (RUBBER, dict(time=[0, 0.5, 2.0], law=EXPONENTIAL)),
    (STEEL, SLIDING),
    (STEEL, dict(law=EXPONENTIAL, **SLIDING)),
    (RUBBER, dict(time=[0, 0.5, 2.0], **SLIDING)),
    (STEEL, dict(law=EXPONENTIAL)),
]


def number(p):
    """A number that depends on every step."""
    steps = p.steps
    weights = np.arange(1.0, len(steps.approach) + 1)
    open_gap = np.where(p.pressure > 0, 0.0, p.gap)
    fields = (PRESSURE * p.pressure).sum() + (GAP * open_gap).sum()
    return fields + (weights * (3 * steps.approach + 7 * steps.elastic_energy - 2 * steps.mean_pressure)).sum()


def cotangents(count):
    weights = np.arange(1.0, count + 1)
    return dict(
        pressure=PRESSURE, gap=GAP, approach=3 * weights, elastic_energy=7 * weights, mean_pressure=-2 * weights
    )


@pytest.mark.parametrize("loads", [PRESSURES, APPROACHES])
@pytest.mark.parametrize("body, options", CASES)
def test_derivatives_are_difference_quotients(loads, body, options):
    def follow(heights=HEIGHTS, **other):
        return gfmd.path(heights, body, steps=2, tolerance=1e-12, energy_solves=0, **{**loads, **options, **other})

    # A law leaves no set of points with pressure: its gap counts everywhere but at the wall.
    has_law = "law" in options
    if has_law:
        of = dict(approach=3.0, elastic_energy=7.0, pressure=PRESSURE)

        def value(p):
            return (PRESSURE * p.pressure).sum() + (3 * p.steps.approach + 7 * p.steps.elastic_energy).sum()

    else:
        of, value = None, number
    plain = follow()
    count = len(plain.steps.approach)
    found = plain.vjp(**(of or cotangents(count)))
    assert found.error < 1e-8 and found.heights.shape == (16, 16) and found.loads.shape == (count,)
    step = 1e-7
    for i, j in [(0, 0), (3, 7), (11, 2), (8, 8), np.unravel_index(HEIGHTS.argmax(), HEIGHTS.shape)]:
        moved = np.zeros_like(HEIGHTS)
        moved[i, j] = step
        quotient = (value(follow(HEIGHTS + moved)) - value(follow(HEIGHTS - moved))) / (2 * step)
        assert found.heights[i, j] == pytest.approx(quotient, rel=1e-4, abs=1e-4)
    # The loads of the steps between two waypoints lie between theirs.
    ((kind, waypoints),) = loads.items()
    ends = np.arange(0, count, (count - 1) // 2)
    for waypoint, end in enumerate(ends):
        share = np.maximum(0.0, 1.0 - np.abs(np.arange(count) - end) / ends[1])
        change = 1e-6 * waypoints[waypoint]
        up, down = ([w + sign * change * (k == waypoint) for k, w in enumerate(waypoints)] for sign in (1, -1))
        quotient = (value(follow(**{kind: up})) - value(follow(**{kind: down}))) / (2 * change)
        assert share @ found.loads == pytest.approx(quotient, rel=1e-4, abs=1e-4)


def test_friction_and_hardness_have_derivatives_of_their_own():
    options = dict(pressure=[0.02, 0.03], lateral=[0, 1e-3], direction=30, steps=2, tolerance=1e-11, energy_solves=0)

    def follow(friction=0.3, hardness=0.15, far=1e-3):
        return gfmd.path(HEIGHTS, STEEL, friction=friction, hardness=hardness, **{**options, "lateral": [0, far]})

    def value(p):
        return (PRESSURE[:2] * (p.shear_x - 2 * p.shear_y + 5 * p.plastic_depth)).sum() + 3 * p.steps.mean_shear[-1, 0]

    p = follow()
    assert 0 < p.steps.stick_fraction[-1] < p.steps.area_fraction[-1] and p.steps.plastic_fraction[-1] > 0
    last = np.eye(len(p.steps.approach))[-1]
    found = p.vjp(
        shear_x=PRESSURE[:2], shear_y=-2 * PRESSURE[:2], plastic_depth=5 * PRESSURE[:2], mean_shear_x=3 * last
    )
    for name, at in [("friction", 0.3), ("hardness", 0.15)]:
        step = 1e-4 * at
        up, down = (value(follow(**{name: at + sign * step})) for sign in (1, -1))
        assert found[name] == pytest.approx((up - down) / (2 * step), rel=1e-4)
    # The steps between the waypoints lie between them.
    share = np.linspace(0.0, 1.0, len(last))
    up, down = (value(follow(far=1e-3 + sign * 1e-7)) for sign in (1, -1))
    along = share @ found.lateral @ [np.cos(np.pi / 6), np.sin(np.pi / 6)]
    assert along == pytest.approx((up - down) / 2e-7, rel=1e-5)
    assert found.shear_strength == 0.0 and found.wear_by_slip == 0.0
    # One component alone: the other is zero.
    alone, both = (p.vjp(shear_x=PRESSURE[:2], **other) for other in ({}, {"shear_y": 0 * PRESSURE[:2]}))
    assert np.any(alone.heights != 0) and np.array_equal(alone.heights, both.heights)


def test_steps_made_in_several_increments_have_the_derivatives_of_all():
    def follow(last):
        return gfmd.path(HEIGHTS, RUBBER, pressure=[0.02, last], time=[0, 3], steps=1, tolerance=1e-12, energy_solves=4)

    found = follow(0.05).vjp(approach=[0.0, 1.0])
    quotient = (follow(0.05 + 1e-7).steps.approach[-1] - follow(0.05 - 1e-7).steps.approach[-1]) / 2e-7
    assert found.loads[-1] == pytest.approx(quotient, rel=1e-5)
    # In one increment it is another one.
    once = gfmd.path(HEIGHTS, RUBBER, pressure=[0.02, 0.05], time=[0, 3], steps=1, tolerance=1e-12)
    assert once.vjp(approach=[0.0, 1.0]).loads[-1] != pytest.approx(quotient, rel=1e-5)


def test_a_step_without_history_is_a_contact():
    p = gfmd.path(HEIGHTS, STEEL, pressure=[0.02, 0.05], steps=1, tolerance=1e-12)
    c = gfmd.contact(HEIGHTS, STEEL, pressure=0.05, tolerance=1e-12)
    found, wanted = p.vjp(approach=[0.0, 1.0], mean_gap=[0.0, 2.0]), c.vjp(approach=1.0, mean_gap=2.0)
    assert found.heights == pytest.approx(wanted.heights, rel=1e-6, abs=1e-8)
    assert found.loads == pytest.approx([0.0, wanted.load], rel=1e-7)
    assert found.modulus == pytest.approx(wanted.modulus, rel=1e-7)
    line = gfmd.path(HEIGHTS[:, 0], RUBBER, pressure=0.02, time=[0, 1], steps=1)
    assert line.vjp(pressure=np.ones((2, 16))).loads == pytest.approx([16.0, 16.0])
    # The sum of the pressure is prescribed.
    creep = gfmd.path(HEIGHTS, RUBBER, pressure=0.02, time=[0, 1], steps=1)
    found = creep.vjp(pressure=np.ones((2, 16, 16)))
    assert found.loads == pytest.approx([256.0, 256.0]) and np.abs(found.heights).max() < 1e-9
    # A pickle is followed again; a file has not all options of a path.
    again = pickle.loads(pickle.dumps(p))
    assert again.vjp(approach=[0.0, 1.0]).heights == pytest.approx(p.vjp(approach=[0.0, 1.0]).heights, rel=1e-12)


def test_what_has_no_derivative_is_named(tmp_path):
    p = gfmd.path(HEIGHTS, RUBBER, pressure=0.02, time=[0, 1], steps=1)
    for arguments, words in [
        (dict(pressure=np.ones((3, 3))), r"pressure has the shape \[3, 3\]; it must be \[2, 16, 16\]"),
        (dict(gap=np.full((2, 16, 16), np.inf)), "the derivative by the gap has inf"),
        (dict(approach=np.nan), "approach is nan"),
        (dict(approach=[1.0, 2.0, 3.0]), r"approach has the shape \[3\]; it must be a number or \[2\]"),
        (dict(mean_gap="large"), "mean_gap"),
        (dict(mean_shear_x=1.0), "the derivative by the mean shear traction is given; it must be left out"),
        (dict(shear_y=np.ones((2, 16, 16))), "the derivative by the shear traction is given"),
        (dict(plastic_depth=np.ones((2, 16, 16))), "the derivative by the plastic depth is given"),
    ]:
        with pytest.raises(gfmd.InputError, match=words):
            p.vjp(**arguments)
    p.save(tmp_path / "p.h5")
    with pytest.raises(gfmd.InputError, match="the path was read from a file"):
        gfmd.load(tmp_path / "p.h5").vjp(approach=1.0)
    slab = gfmd.Body(height=0.3)
    for options, words in [
        (dict(lower_surface=0.0 * HEIGHTS), "lower.surface is given"),
        (dict(base_displacement=0.01 * HEIGHTS), "base.displacement is given"),
    ]:
        other = gfmd.path(HEIGHTS, slab, pressure=[0.01, 0.02], steps=1, **options)
        with pytest.raises(gfmd.InputError, match=words):
            other.vjp(approach=1.0)
    steel = gfmd.Body(poisson=0.3, yield_stress=0.01)
    dented = gfmd.path(HEIGHTS, steel, p_star=[0.02, 0.05], steps=1)
    with pytest.raises(gfmd.InputError, match="a path has derivatives if its contact is made of parts"):
        dented.vjp(approach=1.0)
    drawn = gfmd.path(HEIGHTS, RUBBER, pressure=0.02, time=[1], steps=1, law=EXPONENTIAL)
    with pytest.raises(gfmd.InputError, match="it must end at time 0"):
        drawn.vjp(approach=1.0)
