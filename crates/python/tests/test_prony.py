"""A Prony series from storage and loss moduli, from a file and from arrays."""

import json
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


def test_a_body_takes_a_whole_fit():
    fit = gfmd.prony(**curves(), stress_unit="MPa")
    assert gfmd.Body(prony=fit, poisson=0.5) == gfmd.Body(young=fit.young, poisson=0.5, prony=fit.series)
    assert gfmd.Body(e_star=2.0, prony=fit) == gfmd.Body(e_star=2.0, prony=fit.series)
    assert gfmd.Body(young=3.0, prony=fit, moduli="instantaneous").prony == tuple(fit.series)
    with pytest.raises(gfmd.InputError, match="young is missing; it is needed with moduli 'instantaneous'"):
        gfmd.Body(prony=fit, moduli="instantaneous")


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


def test_a_saved_fit_and_a_printed_one_are_loaded(tmp_path, run_program):
    fit, given = gfmd.prony(EXAMPLE, wlf=(8.86, 101.6, 20.0)), gfmd.prony(**curves(), long_term=3.0)
    fit.save(tmp_path / "fit.json")
    read = gfmd.load(tmp_path / "fit.json")
    assert read == fit and read.units == (None, "MPa") and read.series == fit.series
    given.save(tmp_path / "given.json")
    assert np.isnan(given.young_long_term_error) and gfmd.load(tmp_path / "given.json") == given
    printed = run_program("prony", "--dma", str(EXAMPLE), "--wlf", "8.86,101.6,20")
    (tmp_path / "printed.json").write_text(json.dumps(printed))
    assert gfmd.load(tmp_path / "printed.json") == fit


@pytest.mark.parametrize(
    "text, words",
    [
        ("{}", "it has no young_long_term of a Prony series"),
        ('{"young_long_term": 1.0, "young_long_term_error": "no"}', "it has no young_long_term_error"),
        ("{", "it is no JSON"),
        ('{"young_long_term": 1.0, "young_long_term_error": null, "prony": [[1.0]]}', "it has no prony"),
        ("[1.0]", "HDF5"),
    ],
)
def test_files_without_a_fit_are_refused(tmp_path, text, words):
    (tmp_path / "fit.json").write_text(text)
    with pytest.raises(gfmd.InputError) as error:
        gfmd.load(tmp_path / "fit.json")
    assert words in str(error.value) and "\n" not in str(error.value)


def test_measured_moduli_rub_in_full_contact_as_in_the_closed_form():
    """The friction force per area is the sum of |h|² q_x |q| Im E(q_x v)/(2 (1 − ν²)) over all waves."""
    fit = gfmd.prony(EXAMPLE, wlf=(8.86, 101.6, 20.0))
    rubber = gfmd.Body(young=fit.young, poisson=0.5, prony=fit.series)
    surface = gfmd.self_affine(n=64, eps_f_inv=8, size="1 mm", unit="mm")
    velocity = np.geomspace(1e-3, 1e6, 10)
    sliding = gfmd.slide(surface, rubber, velocity=velocity, pressure="20 GPa").states
    assert np.all(sliding.area_fraction == 1.0)
    wave = 2 * np.pi * np.fft.fftfreq(64, 1 / 64)
    power = np.abs(np.fft.fft2(surface.heights) / 64**2) ** 2 * wave[:, np.newaxis] * np.hypot(*np.meshgrid(wave, wave))
    y = 1j * wave[:, np.newaxis, np.newaxis] * velocity[:, np.newaxis] * [branch.time for branch in fit.branches]
    loss = 1e6 * (y / (1 + y) @ [branch.modulus for branch in fit.branches]).imag
    force = np.einsum("xy,xv->v", power, loss) / (2 * 0.75)
    assert sliding.friction_hysteresis == pytest.approx(force / sliding.mean_pressure, rel=1e-6)
    assert 0 < np.argmax(force) < 9


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
