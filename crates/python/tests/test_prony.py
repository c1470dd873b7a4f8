"""A Prony series from storage and loss moduli, from a file and from arrays."""

from pathlib import Path

import gfmd
import numpy as np
import pytest

EXAMPLE = Path(__file__).parents[3] / "data" / "examples" / "dma.csv"
TIMES, MODULI = np.array([0.01, 1.0, 100.0]), np.array([500.0, 60.0, 8.0])


def curves(noise=0.0, seed=1):
    """Moduli of a series with the long-term modulus 3."""
    omega = np.geomspace(1e-2, 1e2, 41)
    y = 1j * omega[:, np.newaxis] * TIMES
    found = 3.0 + y / (1 + y) @ MODULI
    errors = 1 + noise * np.random.default_rng(seed).standard_normal((2, 41))
    return dict(frequency=omega / (2 * np.pi), storage=found.real * errors[0], loss=found.imag * errors[1])


def test_arrays_give_the_series_they_are_made_of():
    fit = gfmd.prony(**curves(), stress_unit="MPa")
    assert [branch.time for branch in fit.branches] == pytest.approx(TIMES, rel=1e-6)
    assert [branch.modulus for branch in fit.branches] == pytest.approx(MODULI, rel=1e-6)
    assert fit.young.endswith(" MPa") and fit.young_long_term == pytest.approx(3.0, rel=1e-6)
    assert fit.units == (None, "MPa") and len(fit.points) == 41
    body = gfmd.Body(young=fit.young_long_term, poisson=0.5, prony=fit.series)
    sliding = gfmd.slide(gfmd.self_affine(n=16, eps_f_inv=4), body, velocity=1.0, p_star=0.05)
    assert sliding.young_instantaneous == pytest.approx(571.0, rel=1e-6)


def test_noise_stays_within_standard_errors():
    fit = gfmd.prony(**curves(0.02), branches=3)
    assert 0.015 < np.hypot(fit.storage_misfit, fit.loss_misfit) / np.sqrt(2) < 0.025
    for branch, modulus in zip(fit.branches, MODULI):
        assert abs(branch.modulus - modulus) < 4 * branch.modulus_error


def test_a_file_is_shifted_and_read_as_the_program_does(tmp_path):
    fit = gfmd.prony(EXAMPLE, wlf=(8.86, 101.6, 20.0))
    assert fit.reference_temperature == 20.0 and fit.stress_unit == "MPa"
    assert fit.young_long_term == pytest.approx(2.0, rel=0.03) and not fit.warnings
    copied = gfmd.prony(
        **{name: [point[name] for point in fit.points] for name in ("frequency", "storage", "loss")}, stress_unit="MPa"
    )
    assert copied.young_long_term == pytest.approx(fit.young_long_term, rel=1e-9)


def test_figure_and_table():
    pytest.importorskip("matplotlib")
    pytest.importorskip("pandas")
    fit = gfmd.prony(EXAMPLE, wlf=(8.86, 101.6, 20.0))
    ax = fit.plot()
    assert ax.get_xlabel() == "reduced frequency / Hz" and ax.get_ylabel() == "modulus / MPa"
    frame = fit.to_dataframe()
    assert list(frame) == ["time", "modulus", "modulus_error", "fraction"]
    assert frame.attrs["units"]["modulus"] == "MPa" and len(frame) == len(fit.branches)


@pytest.mark.parametrize(
    "given, words",
    [
        (dict(), "frequency is missing"),
        (dict(dma="a.csv", loss=[1.0]), "loss is given beside the file"),
        (dict(curves(), loss=[1.0]), "loss has 1 numbers; it must have as many as frequency, 41"),
        (dict(curves(), branches=42), "branches: there are 41 points for 42 relaxation times"),
        (dict(curves(), wlf=(17.0, 51.0)), "wlf is 2 numbers; it must be three numbers"),
        (dict(curves(), wlf=(17.0, 51.0, 20.0)), "no column temperature; it must have one with wlf"),
        (dict(curves(), stress_unit="nm"), "stress"),
        (dict(curves(), long_term=1e3), "long_term: the long-term modulus is 1000"),
        (dict(frequency=[1.0, 2.0], storage=[1.0, -1.0], loss=[1.0, 1.0]), "line 3 has the storage -1"),
        (dict(dma="none.csv"), "none.csv"),
    ],
)
def test_data_without_a_series_are_refused(given, words):
    with pytest.raises(gfmd.InputError) as error:
        gfmd.prony(**given)
    assert words in str(error.value), error.value
