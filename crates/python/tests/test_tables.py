"""Laws and bodies from tables and functions."""

import pickle

import numpy as np
import pytest

import gfmd

GAMMA, RANGE = 2e-5, 1.2e-3
GAPS = RANGE * (25.0 * np.linspace(0.0, 1.0, 201) ** 3 + 2.0 * np.linspace(0.0, 1.0, 201))


def exponential(gap):
    return np.where(gap < GAPS[-1], GAMMA / RANGE * np.exp(-gap / RANGE), 0.0)


@pytest.fixture(scope="module")
def surface():
    return gfmd.self_affine(n=32, eps_f_inv=4)


def test_a_table_and_a_function_are_the_law_that_they_sample(surface, tmp_path, run_program):
    table = gfmd.law(GAPS, exponential(GAPS))
    assert table == gfmd.law(GAPS, exponential) == pickle.loads(pickle.dumps(table)) and table.name == "table"
    assert len(table.table) == 201 and table.parameters == {}
    named = gfmd.law("exponential", gamma=GAMMA, range=RANGE)
    middle = 0.5 * (GAPS[1:] + GAPS[:-1])
    assert np.abs(table.traction(middle) - named.traction(middle)).max() < 1e-4 * GAMMA / RANGE
    found, wanted = (gfmd.contact(surface, gfmd.Body(), law=law, pressure=0.003) for law in (table, named))
    for name in ("approach", "mean_gap", "interface_energy", "elastic_energy"):
        assert found[name] == pytest.approx(wanted[name], rel=1e-4)
    found.save(tmp_path / "t.h5")
    assert gfmd.load(tmp_path / "t.h5").law == table
    assert run_program("check", str(tmp_path / "t.h5"), "--rerun")["differing"] == 0
    again = gfmd.contact(surface, gfmd.Body(), law=gfmd.load(tmp_path / "t.h5").law, pressure=0.003, start=found)
    assert again.approach == pytest.approx(found.approach, rel=1e-7)
    loop = gfmd.path(surface, gfmd.Body(), law=table, approach=[-0.002, 0.002], steps=2)
    assert loop.steps.interface_energy[-1] < 0


def test_a_table_has_units():
    scan = gfmd.self_affine(n=32, size="1 um", unit="um", eps_f_inv=4)
    in_units = gfmd.law(1e3 * GAPS, exponential(GAPS), units=("nm", "MPa"))
    sticky = gfmd.contact(scan, gfmd.Body(young="1 MPa"), law=in_units, pressure="3 kPa")
    bare = gfmd.contact(scan, gfmd.Body(young="1 MPa"), law=gfmd.law(GAPS, 1e6 * exponential(GAPS)), pressure="3 kPa")
    assert sticky.approach == pytest.approx(bare.approach, rel=1e-9)
    assert sticky.law.table[1][0] == pytest.approx(GAPS[1], rel=1e-12)


def test_tables_that_are_no_law_are_refused():
    gaps = np.linspace(0.0, 1.0, 5)
    for arguments, words in [
        ((gaps, [1, 2, 3]), "traction has the shape"),
        ((gaps[::-1], 1 - gaps), "row 2 begins with"),
        ((gaps, np.full(5, np.nan)), "traction is nan; it must be a number"),
        ((gaps[:3], [1.0, 0.5, 0.0]), "3 rows; there must be at least 4"),
        ((gaps, np.ones(5)), "traction at the largest gap is 1e0"),
        ((gaps, lambda gap: np.cos(20.0 * gap) * (gap < 1.0)), "closer gaps make it"),
        ((gaps, lambda gap: "no"), "traction"),
        (("table",), "needs its rows"),
        (("morse", [1.0]), "traction is given"),
    ]:
        with pytest.raises(gfmd.InputError, match=words):
            gfmd.law(*arguments)
    with pytest.raises(gfmd.InputError, match="gamma is given"):
        gfmd.law(gaps, 1 - gaps, gamma=1.0)


def test_a_body_from_a_table_or_a_function_is_the_body_that_it_samples(surface, tmp_path, run_program):
    waves = np.geomspace(5.0, 300.0, 300)
    half_space = gfmd.Body(e_star=2.0)
    bodies = [gfmd.Body(e_star=2.0, compliance=(waves, given)) for given in (1.0 / waves, lambda q: 1.0 / q)]
    assert (
        bodies[0] == bodies[1] == pickle.loads(pickle.dumps(bodies[0])) != half_space
        and len(bodies[0]["compliance"]) == 300
    )
    found, wanted = (
        gfmd.contact(surface, body, p_star=0.05, stiffness_tolerance=1e-9) for body in (bodies[0], half_space)
    )
    for name in ("approach", "mean_gap", "elastic_energy", "stiffness", "kappa"):
        assert found[name] == pytest.approx(wanted[name], rel=1e-6)
    assert found.conductance() == pytest.approx(wanted.conductance(), rel=1e-6)
    assert found.vjp(approach=1.0).load == pytest.approx(1 / found.stiffness, rel=1e-7)
    slab = gfmd.Body(e_star=2.0, height=0.1)
    kept = [gfmd.green(slab, qx=float(q)).normal_compliance for q in waves]
    tabulated = gfmd.Body(e_star=2.0, compliance=(waves, kept), uniform_compliance=0.1 / 2.0)
    found, wanted = (gfmd.contact(surface, body, approach=0.002) for body in (tabulated, slab))
    assert found.mean_pressure == pytest.approx(wanted.mean_pressure, rel=1e-4)
    found.save(tmp_path / "b.h5")
    assert gfmd.load(tmp_path / "b.h5").body == found.body
    assert run_program("check", str(tmp_path / "b.h5"), "--rerun")["differing"] == 0
    loop = gfmd.path(surface, tabulated, pressure=[0.001, 0.003], steps=1)
    assert loop.steps.mean_gap[-1] < loop.steps.mean_gap[0]
    for ask in (
        lambda: found.interior(depths=[0.01]),
        lambda: gfmd.punch(tabulated, n=32),
        lambda: gfmd.green(tabulated, qx=1.0),
    ):
        with pytest.raises(gfmd.InputError, match="compliance"):
            ask()


def test_tables_that_are_no_body_are_refused(surface):
    waves = np.geomspace(5.0, 300.0, 50)
    for arguments, words in [
        (dict(compliance=(waves, 1 / waves)), "young or e_star is missing"),
        (dict(young=1.0, poisson=0.3, compliance=(waves, 1 / waves)), "poisson is 0.3"),
        (dict(young=1.0, height=0.3, compliance=(waves, 1 / waves)), "height is 0.3"),
        (dict(young=1.0, compliance=(waves, -1 / waves)), "must be positive and finite"),
        (dict(young=1.0, compliance=(waves[::-1], 1 / waves)), "row 2"),
        (dict(young=1.0, compliance=(waves, [1.0, 2.0])), r"shape \[2\]"),
        (dict(young=1.0, compliance=lambda q: 1 / q), "wavenumbers, compliances or a function"),
        (dict(young=1.0, uniform_compliance=1.0), "left out without compliance"),
    ]:
        with pytest.raises(gfmd.InputError, match=words):
            gfmd.Body(**arguments)
    short = gfmd.Body(young=1.0, compliance=(waves[:20], 1 / waves[:20]))
    with pytest.raises(gfmd.InputError, match="wavenumbers"):
        gfmd.contact(surface, short, p_star=0.1)
    with pytest.raises(gfmd.InputError, match="compliance"):
        gfmd.contact(surface, gfmd.Body(young=1.0, compliance=(waves, 1 / waves)), p_star=0.1, components="held")


def test_a_body_by_direction_presses_waves_as_their_directions_do(tmp_path, run_program):
    """Cosines along x and y, and obliquely, in full contact (p = h/G) and in part of it (Westergaard)."""
    waves = np.geomspace(5.0, 1000.0, 6)

    def compliance(x, y):
        angle = np.arctan2(y, x)
        return 2.0 / np.hypot(x, y) / (1.0 + 0.3 * np.cos(2.0 * angle) + 0.2 * np.sin(2.0 * angle))

    body = gfmd.Body(e_star=1.0, compliance=(waves, 32, compliance))
    assert body == pickle.loads(pickle.dumps(body)) and len(body["compliance"]) == 192
    assert body == gfmd.Body(e_star=1.0, compliance=np.array(body["compliance"]))
    n, amplitude = 64, 1e-3
    x = 2.0 * np.pi * np.arange(n)[:, None] / n
    for p, q in ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1)):
        heights = amplitude * np.cos(p * x + q * x.T)
        softness = compliance(2.0 * np.pi * p, 2.0 * np.pi * q)
        full = amplitude / softness
        surface = gfmd.Surface(heights, size=1.0)
        pressed = gfmd.contact(surface, body, pressure=1.5 * full)
        assert np.abs(pressed.pressure - 1.5 * full - heights / softness).max() < 1e-6 * full
        # The area of a wave below the pressure of full contact, to the points of its crest.
        part = gfmd.contact(surface, body, pressure=0.4 * full)
        assert part.area_fraction == pytest.approx(
            2.0 / np.pi * np.arcsin(np.sqrt(0.4)), abs=2.0 * max(abs(p), abs(q)) / n
        )
    part.save(tmp_path / "a.h5")
    assert gfmd.load(tmp_path / "a.h5").body == body
    assert run_program("check", str(tmp_path / "a.h5"), "--rerun")["differing"] == 0
    bumps = np.random.default_rng(1).normal(size=part.surface.heights.shape)
    step = 1e-7 * amplitude
    moved = [gfmd.Surface(part.surface.heights + sign * step * bumps, size=1.0) for sign in (1, -1)]
    ends = [gfmd.contact(surface, body, pressure=0.4 * full, tolerance=1e-12) for surface in moved]
    wanted = (ends[0].elastic_energy - ends[1].elastic_energy) / (2.0 * step)
    assert np.sum(part.vjp(elastic_energy=1.0).heights * bumps) == pytest.approx(wanted, rel=1e-3)


def test_tables_by_direction_that_are_none_are_refused():
    waves = np.geomspace(1.0, 1000.0, 5)
    for given, words in [
        ((waves, 3, lambda x, y: 1 / np.hypot(x, y)), "directions of compliance is 3"),
        ((waves, 8, np.ones((5, 7))), r"shape \[5, 7\]"),
        ((waves, 8, lambda x, y: -np.hypot(x, y)), "must be positive and finite"),
        (np.ones((4, 3)), "3 rows|4 rows|directions|row"),
        (np.ones((4, 5)), "an array of rows"),
    ]:
        with pytest.raises(gfmd.InputError, match=words):
            gfmd.Body(young=1.0, compliance=given)
