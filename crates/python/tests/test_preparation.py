"""Preparation of scans: each step returns a new surface, as the program prepares a file."""

import json
import subprocess

import numpy as np
import pytest

import gfmd

X, Y = np.meshgrid(np.arange(64), np.arange(48), indexing="ij")


@pytest.fixture
def raw():
    rng = np.random.default_rng(3)
    heights = 30e-9 * np.sin(0.2 * X) * np.cos(0.15 * Y) + 2e-9 * X - 1e-9 * Y + 1e-11 * X * Y
    heights += 1e-9 * rng.standard_normal(X.shape) + 5e-9 * rng.standard_normal(48)[np.newaxis, :]
    heights[20, 30] += 4e-7
    heights[50, 11] -= 4e-7
    return gfmd.Surface(heights, size=("32 um", "24 um"), unit="m")


def test_steps_are_those_of_the_program(raw, tmp_path):
    np.savetxt(tmp_path / "scan.txt", raw.heights.T, header="Width: 32e-6 m\nHeight: 24e-6 m\nValue units: m")
    flags = (
        "--crop 2um:30um,: --invalid above:300nm --despike 6,7 --level rows:median --detrend cubic --fill harmonic"
        " --resample 28,24 --filter s:5um,l:20um"
    )
    command = ["gfmd", "surface", "--surface", "scan.txt", *flags.split(), "--json", "--out", "h.npy"]
    printed = json.loads(subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True).stdout)
    read = gfmd.read(tmp_path / "scan.txt")
    surface = read.mask("above:300nm").crop(x=("2 um", "30 um")).despike(6, window=7).level("rows", "median")
    surface = surface.detrend("cubic").fill("harmonic").resample((28, 24)).filter(s="5 um", l=20e-6)
    assert np.abs(surface.heights - np.load(tmp_path / "h.npy")).max() < 1e-21
    assert surface.is_complete and surface.n == (28, 24)
    steps, of_program = surface.preparation, printed["scan"]["preparation"]
    # The program filters with both indices in one step of its option, recorded one after the other.
    assert [step["step"] for step in steps] == [step["step"] for step in of_program]
    for own, other in zip(steps, of_program):
        if own["step"] != "fill":
            assert own == other
    assert "despike" in str(steps) and "spikes taken out" in surface.description


def test_undefined_points_stay_until_they_are_filled(raw):
    mask = (X > 50) & (Y > 40)
    holed = raw.mask(mask)
    assert holed.undefined == mask.sum() and not holed.is_complete and f"{mask.sum()} undefined" in repr(holed)
    with pytest.raises(gfmd.InputError, match="undefined"):
        gfmd.contact(holed, gfmd.Body(young=1e9), pressure=1e6)
    with pytest.raises(gfmd.InputError):
        holed.statistics()
    levelled = holed.detrend("plane")
    assert (np.isnan(levelled.heights) == mask).all()
    assert holed.crop(x=(0, "25 um")).is_complete
    filled = levelled.fill("nearest")
    assert filled.is_complete and filled.undefined == mask.sum()
    assert gfmd.contact(filled.periodise(), gfmd.Body(young=1e9), pressure=1e6).area_fraction > 0
    assert raw.is_complete and raw.preparation == []


def test_points_left_out_of_a_fit_keep_their_heights():
    plane = 1e-9 * X - 2e-9 * Y
    bumped = plane + np.where((X > 20) & (X < 30), 1e-7, 0)
    surface = gfmd.Surface(bumped, size=(64, 48))
    for exclude in ((X > 20) & (X < 30), "20.5:29.5,:"):
        rest = surface.detrend("polynomial:1", exclude=exclude).heights
        assert np.allclose(rest, bumped - plane, atol=1e-20)
        assert np.allclose(surface.level("rows", "polynomial:1", exclude=exclude).heights[25], 1e-7, atol=1e-18)


def test_periodic_surfaces_stay_periodic_where_they_do():
    made = gfmd.self_affine(64, seed=2)
    assert made.filter(s=0.1).is_periodic and made.level("rows", "mean").is_periodic
    for other in (made.crop(x=(0, 0.5)), made.level("rows", "difference"), made.resample(32)):
        assert not other.is_periodic
    edges = made.filter(s=0.1, edges="regression")
    assert not np.allclose(edges.heights, made.filter(s=0.1).heights)


@pytest.mark.parametrize(
    "step, words",
    [
        (lambda s: s.crop(x=("5 um", "4 um")), "no range"),
        (lambda s: s.crop(x=(0, "40 um")), "START:END"),
        (lambda s: s.crop(x=("a", 1)), "no number"),
        (lambda s: s.mask(np.zeros((3, 3), bool)), "shape"),
        (lambda s: s.mask(np.zeros((64, 48))), "bool"),
        (lambda s: s.mask(np.ones((64, 48), bool)), "every point"),
        (lambda s: s.despike(0), "positive"),
        (lambda s: s.despike(window=4), "odd number"),
        (lambda s: s.descar(0.1, 0.2), "HIGH >= LOW"),
        (lambda s: s.level("lines"), "rows or columns"),
        (lambda s: s.level("rows", "polynomial:9"), "0 to 8"),
        (lambda s: s.detrend("bow"), "polynomial:D"),
        (lambda s: s.detrend("polynomial:9"), "0 to 8"),
        (lambda s: s.filter(), "no nesting index"),
        (lambda s: s.filter(s="0.1 um"), "two spacings"),
        (lambda s: s.filter(s="1 kg"), "no unit"),
        (lambda s: s.filter(s="4 um", degree=3), "degree"),
        (lambda s: s.filter(s="4 um", kind="spline"), "profile"),
        (lambda s: s.resample(), "one of them"),
        (lambda s: s.resample(65), "2 to 64"),
        (lambda s: s.resample(spacing="-1 um"), "positive"),
        (lambda s: s.fill("linear"), "harmonic"),
    ],
)
def test_what_cannot_be_prepared_is_refused(raw, step, words):
    with pytest.raises(gfmd.InputError, match=words) as caught:
        step(raw)
    assert "--" not in str(caught.value).replace("--refine", ""), caught.value
