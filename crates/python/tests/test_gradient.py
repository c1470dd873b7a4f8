"""Derivatives of contacts: difference quotients, adapters, refusals."""

import numpy as np
import pytest

import gfmd

HEIGHTS = gfmd.self_affine(n=16, eps_f_inv=2).heights
BODY = gfmd.Body(young=2.0, poisson=0.3)
RANDOM = np.random.default_rng(1)
PRESSURE, GAP = RANDOM.normal(size=(2, 16, 16))


def number(c):
    """A number that depends on everything."""
    # A law without a wall leaves a gap where it repels.
    open_gap = c.gap if c.law.name == "morse" else np.where(c.pressure > 0, 0.0, c.gap)
    return (
        (PRESSURE * c.pressure).sum()
        + (GAP * open_gap).sum()
        + 3 * c.approach
        + 5 * open_gap.mean()
        + 7 * c.elastic_energy
        - 2 * c.mean_pressure
    )


COTANGENTS = dict(pressure=PRESSURE, gap=GAP, approach=3.0, mean_gap=5.0, elastic_energy=7.0, mean_pressure=-2.0)


SLAB = gfmd.Body(young=2.0, poisson=0.3, height=0.4)
# A wall with an attraction, a law without a wall, and a table; all are smooth, and resolved by the grid.
EXPONENTIAL = gfmd.law("exponential", gamma=2e-3, range=0.02)
MORSE = gfmd.law("morse", gamma=2e-3, range=0.02)
GAPS = np.linspace(0.0, 0.2, 41)
TABLE = gfmd.law(GAPS, 0.1 * (1.0 - GAPS / 0.2) ** 3)
CASES = [
    {},
    {"boundary": "free"},
    {"components": "held"},
    {"law": EXPONENTIAL},
    {"law": EXPONENTIAL, "boundary": "free"},
    {"law": EXPONENTIAL, "body": SLAB},
    {"law": MORSE},
    {"law": MORSE, "boundary": "free"},
    {"law": TABLE},
]


@pytest.mark.parametrize("load", [{"pressure": 0.02}, {"approach": 0.004}])
@pytest.mark.parametrize("options", CASES)
def test_derivatives_are_difference_quotients(load, options):
    options = dict(options)
    own = options.pop("body", BODY)

    def solve(heights=HEIGHTS, body=own, **other):
        return gfmd.contact(heights, body, tolerance=1e-12, **(other or load), **options)

    found = solve().vjp(**COTANGENTS)
    (kind, value), step = *load.items(), 1e-7
    assert found.fixed == kind and found.error < 1e-8
    for i, j in [(0, 0), (3, 7), (11, 2), (15, 15), (8, 8), np.unravel_index(HEIGHTS.argmax(), HEIGHTS.shape)]:
        moved = np.zeros_like(HEIGHTS)
        moved[i, j] = step
        quotient = (number(solve(HEIGHTS + moved)) - number(solve(HEIGHTS - moved))) / (2 * step)
        assert found.heights[i, j] == pytest.approx(quotient, rel=1e-4, abs=1e-4)
    quotient = (number(solve(**{kind: value * (1 + 1e-6)})) - number(solve(**{kind: value * (1 - 1e-6)}))) / (
        2e-6 * value
    )
    assert found.load == pytest.approx(quotient, rel=1e-5)
    bodies = [gfmd.Body(e_star=own.e_star * (1 + change), poisson=0.3, height=own.height) for change in (1e-6, -1e-6)]
    quotient = (number(solve(body=bodies[0])) - number(solve(body=bodies[1]))) / (2e-6 * own.e_star)
    assert found.modulus == pytest.approx(quotient, rel=1e-5)


def test_it_is_that_of_a_file_and_of_the_other_load(tmp_path):
    c = gfmd.contact(HEIGHTS, BODY, p_star=0.1, tolerance=1e-12, stiffness_tolerance=1e-9)
    plain = c.vjp(approach=1.0)
    assert plain.fixed == "pressure" and plain.load == pytest.approx(1 / c.stiffness, rel=1e-8)
    assert c.vjp(mean_pressure=1.0, fixed="approach").load == pytest.approx(c.stiffness, rel=1e-8)
    c.save(tmp_path / "c.h5")
    assert gfmd.load(tmp_path / "c.h5").vjp(approach=1.0).heights == pytest.approx(plain.heights, rel=1e-8)
    line = gfmd.contact(HEIGHTS[:, 0], BODY, p_star=0.1)
    assert line.vjp(pressure=np.ones(16)).load == pytest.approx(16.0)


def test_a_law_has_the_derivatives_of_its_file_and_of_a_line(tmp_path):
    c = gfmd.contact(HEIGHTS, BODY, p_star=0.1, law=EXPONENTIAL, tolerance=1e-12)
    plain = c.vjp(approach=1.0)
    # d(approach)/d(mean pressure) and its inverse.
    assert c.vjp(mean_pressure=1.0, fixed="approach").load == pytest.approx(1 / plain.load, rel=1e-7)
    assert plain.heights.sum() == pytest.approx(0.0, abs=1e-9)
    c.save(tmp_path / "c.h5")
    assert gfmd.load(tmp_path / "c.h5").vjp(approach=1.0).heights == pytest.approx(plain.heights, rel=1e-6, abs=1e-9)
    # A law that does nothing leaves the derivatives of the hard wall.
    weak = gfmd.law("exponential", gamma=1e-14, range=0.02)
    bare, with_law = (gfmd.contact(HEIGHTS, BODY, p_star=0.1, tolerance=1e-12, **law) for law in ({}, {"law": weak}))
    assert with_law.vjp(**COTANGENTS).heights == pytest.approx(bare.vjp(**COTANGENTS).heights, rel=1e-5, abs=1e-5)
    line = gfmd.contact(HEIGHTS[:, 0], BODY, p_star=0.1, law=EXPONENTIAL)
    assert line.vjp(pressure=np.ones(16)).load == pytest.approx(16.0)
    free = gfmd.contact(HEIGHTS[:, 0], BODY, pressure=0.02, law=EXPONENTIAL, boundary="free")
    # The approach counts from points one length of the profile away.
    stiffness = free.stiffness
    assert free.vjp(approach=1.0).load * stiffness == pytest.approx(1.0, rel=1e-6)
    assert free.vjp(pressure=np.ones(16)).load == pytest.approx(16.0)


@pytest.mark.parametrize("hardness", [0.1, 0.1 + 0.02 * HEIGHTS / HEIGHTS.max()])
def test_a_hardness_has_a_derivative(hardness):
    def value(factor=1.0):
        c = gfmd.contact(HEIGHTS, BODY, pressure=0.02, hardness=factor * hardness, tolerance=1e-12)
        return (PRESSURE * c.pressure).sum() + 3 * c.approach + (GAP * c.plastic_depth).sum(), c

    total, c = value()
    found = c.vjp(pressure=PRESSURE, approach=3.0, plastic_depth=GAP)
    quotient = (value(1 + 1e-6)[0] - value(1 - 1e-6)[0]) / 2e-6
    assert np.shape(found.hardness) == np.shape(hardness)
    assert np.sum(found.hardness * hardness) == pytest.approx(quotient, rel=1e-5)
    assert "hardness" not in gfmd.contact(HEIGHTS, BODY, pressure=0.02).vjp(approach=1.0)


def test_what_has_no_derivative_is_named():
    c = gfmd.contact(HEIGHTS, BODY, p_star=0.1)
    for arguments, words in [
        (dict(pressure=np.ones((3, 3))), r"pressure has the shape \[3, 3\]"),
        (dict(gap=np.full((16, 16), np.inf)), "the derivative by the gap has inf"),
        (dict(approach=np.nan), "approach is nan"),
        (dict(fixed="load"), "fixed is 'load'"),
        (dict(plastic_depth=np.ones((16, 16))), "the derivative by the plastic depth is given"),
    ]:
        with pytest.raises(gfmd.InputError, match=words):
            c.vjp(**arguments)
    slab = gfmd.Body(height=0.3)
    for options, words in [
        (dict(finite_slope=True), "finite.slope is given"),
        (dict(lower_surface=0.0 * HEIGHTS), "lower.surface is given"),
        (dict(base_displacement=0.01 * HEIGHTS), "base.displacement is given"),
    ]:
        other = gfmd.contact(HEIGHTS, slab, pressure=0.01, **options)
        with pytest.raises(gfmd.InputError, match=words):
            other.vjp(approach=1.0)


def test_torch_differentiates_through_a_contact():
    torch = pytest.importorskip("torch")
    import gfmd.torch

    heights = torch.tensor(HEIGHTS.copy(), dtype=torch.float64, requires_grad=True)
    load = torch.tensor(0.02, dtype=torch.float64, requires_grad=True)
    found = gfmd.torch.contact(heights, BODY, pressure=load, tolerance=1e-12)
    value = (torch.tensor(PRESSURE) * found.pressure).sum() + 3 * found.approach + (found.gap * torch.tensor(GAP)).sum()
    value.backward()
    wanted = gfmd.contact(HEIGHTS, BODY, pressure=0.02, tolerance=1e-12).vjp(pressure=PRESSURE, gap=GAP, approach=3.0)
    assert heights.grad.numpy() == pytest.approx(wanted.heights, rel=1e-9) and float(load.grad) == pytest.approx(
        wanted.load
    )


def test_jax_differentiates_through_a_contact():
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    import gfmd.jax

    def value(heights, load):
        found = gfmd.jax.contact(heights, BODY, pressure=load, tolerance=1e-12)
        return (PRESSURE * found.pressure).sum() + 3 * found.approach + (found.gap * GAP).sum()

    wanted = gfmd.contact(HEIGHTS, BODY, pressure=0.02, tolerance=1e-12).vjp(pressure=PRESSURE, gap=GAP, approach=3.0)
    for differentiate in (jax.grad(value, argnums=(0, 1)), jax.jit(jax.grad(value, argnums=(0, 1)))):
        by_heights, by_load = differentiate(HEIGHTS.copy(), 0.02)
        assert np.asarray(by_heights) == pytest.approx(wanted.heights, rel=1e-9) and float(by_load) == pytest.approx(
            wanted.load
        )
