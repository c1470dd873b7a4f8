"""Laws from tables and functions."""

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
    found, wanted = (gfmd.contact(surface, gfmd.Body(), law=law, mean_pressure=0.003) for law in (table, named))
    for name in ("displacement", "mean_gap", "interface_energy", "elastic_energy"):
        assert found[name] == pytest.approx(wanted[name], rel=1e-4)
    found.save(tmp_path / "t.h5")
    assert gfmd.load(tmp_path / "t.h5").law == table
    assert run_program("check", str(tmp_path / "t.h5"), "--rerun")["differing"] == 0
    again = gfmd.contact(surface, gfmd.Body(), law=gfmd.load(tmp_path / "t.h5").law, mean_pressure=0.003, start=found)
    assert again.approach == pytest.approx(found.approach, rel=1e-7)
    loop = gfmd.path(surface, gfmd.Body(), law=table, approach=[-0.002, 0.002], steps=2)
    assert loop.steps.interface_energy[-1] < 0


def test_a_table_has_units():
    scan = gfmd.self_affine(n=32, size="1 um", unit="um", eps_f_inv=4)
    in_units = gfmd.law(1e3 * GAPS, exponential(GAPS), units=("nm", "MPa"))
    sticky = gfmd.contact(scan, gfmd.Body(young="1 MPa"), law=in_units, mean_pressure="3 kPa")
    bare = gfmd.contact(scan, gfmd.Body(young="1 MPa"), law=gfmd.law(GAPS, 1e6 * exponential(GAPS)), mean_pressure="3 kPa")
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
