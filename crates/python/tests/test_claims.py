"""Sentences of README and docs with numbers in them are those that the data of the repository make.

The tables between `<!-- results: NAME -->` are compared by `cargo xtask results --check`; here are the numbers in
running text. A sentence that is reworded is changed here, too; a number that changes fails here first.
"""

import json
import math
import re
from pathlib import Path

import gfmd
import pytest

ROOT = Path(__file__).parents[3]
PERSSON, BUSH = math.sqrt(8 / math.pi), math.sqrt(2 * math.pi)
HURSTS = (0.0, 0.3, 0.5, 0.8)

pytestmark = pytest.mark.skipif(not (ROOT / "data" / "results").is_dir(), reason="the repository is not there")


def text(page):
    """A page with single spaces, without the signs of Markdown."""
    return re.sub(r"\s+", " ", re.sub(r"[*\\]", "", (ROOT / page).read_text(encoding="utf-8")))


def limits():
    return json.loads((ROOT / "data/results/limits.json").read_text())["limits"]


def at(hurst, p_star):
    [found] = [limit for limit in limits() if limit["hurst"] == hurst and limit["p_star"] == p_star]
    return found


def half(limit):
    return 0.5 * (limit["ci95"][1] - limit["ci95"][0])


def swept():
    """The points of the sweep of the results."""
    return json.loads((ROOT / "data/results/ladders.json").read_text())["points"]


def ladder(hurst):
    """A point of the sweep of the results: three decades of roughness at 0.02, one longest wave a cell."""
    wanted = {"hurst": hurst, "eps_t_inv": 1.0, "eps_f_inv": 128.0, "eps_c_inv": 4.0, "p_star": 0.02}
    [found] = [point for point in swept() if all(point[key] == value for key, value in wanted.items())]
    return found


def rows(page, head):
    """The rows of the first table below a heading, as lists of cells."""
    below = (ROOT / page).read_text(encoding="utf-8").split(f"## {head}", 1)[1]
    table = [line for line in below.split("\n\n", 2)[1].splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]]


def ratios(column):
    """The smallest and the largest time divided by the time of gfmd in docs/benchmarks.md."""
    cells = [row[column].split("/") for row in rows("docs/benchmarks.md", "Time divided by the time of gfmd")]
    return min(float(cell[0]) for cell in cells), max(float(cell[2]) for cell in cells)


def pairs():
    """The fewest and the most transform pairs of gfmd in docs/benchmarks.md."""
    counts = [
        float(row[3].split("/")[1]) for row in rows("docs/benchmarks.md", "Iterations / transform pairs computed")
    ]
    return min(counts), max(counts)


def pair_seconds():
    """Time of a transform pair of 2048 x 2048 points on one thread, ms."""
    times = [float(row[3]) for row in rows("docs/benchmarks.md", "Cost in pairs of FFTW, 1 thread") if row[0] == "2048"]
    return sum(times) / len(times)


def claims():
    kappas = [limit["kappa"] for limit in limits() if limit["p_star"] <= 0.02]
    low, high = min(kappas), max(kappas)
    (tamaas_low, tamaas_high), (aspher_low, aspher_high) = ratios(2), ratios(3)
    fewest, most = pairs()
    cited = at(0.8, 0.02)
    yield "README.md", f"{fewest:.0f} to {most:.0f} pairs of Fourier transforms from first touch to full contact"
    yield "docs/how-it-works.md", f"It takes {fewest:.0f} to {most:.0f} pairs of transforms"
    yield "docs/how-it-works.md", f"costs {pair_seconds():.0f} milliseconds"
    tamaas, aspher = f"{tamaas_low:.0f} to {tamaas_high:.0f}", f"{aspher_low:.0f} to {aspher_high:.0f}"
    yield "docs/others.md", f"Tamaas takes {tamaas} times the time of gfmd, and ASPHER {aspher} times"
    yield "docs/glossary.md", f"nearly constant at small loads, {low:.1f} to {high:.1f}"
    yield "docs/glossary.md", f"√(8/π) = {PERSSON:.3f}, the theory of Bush, Gibson and Thomas √(2π) = {BUSH:.3f}"
    yield "docs/tutorials/kappa.md", f"Persson's theory gives {PERSSON:.3f}, Bush, Gibson and Thomas give {BUSH:.3f}"
    light, heavy = (100 * load * at(0.8, load)["kappa"] for load in (0.01, 0.2))
    yield "docs/glossary.md", f"at 0.01 about {light:.0f} % are in contact, at 0.2 about {heavy:.0f} %"
    falls = f"κ falls with H towards Persson's {PERSSON:.3f}"
    yield "docs/results.md", f"{falls}; Bush, Gibson and Thomas have {BUSH:.3f} for any H"
    points = [ladder(hurst) for hurst in HURSTS]
    yield "docs/results.md", "at 1/ε_f = 128 κ is " + ", ".join(
        f"{point['kappa'] - point['edge']:.3f}" for point in points
    )
    yield "docs/results.md", f"κ is higher by {ladder(0.8)['edge']:.2f} (H = 0.8) to {ladder(0.0)['edge']:.2f} (H = 0)"
    band = {"hurst": 0.8, "eps_t_inv": 1.0, "eps_c_inv": 4.0, "p_star": 0.02}
    points = [point for point in swept() if all(point[key] == value for key, value in band.items())]
    composed = [point["kappa_composed"] for point in points]
    computed = [point["kappa"] - point["edge"] for point in points]
    yield "docs/theory.md", f"from {min(composed):.3f} to {max(composed):.3f} at H = 0.8, p = 0.02"
    yield "docs/theory.md", f"κ as computed falls from {max(computed):.2f} to {min(computed):.2f}"
    yield "README.md", f"{cited['kappa']:.3f} ± {half(cited):.3f} for H = 0.8"


CLAIMS = list(claims()) if (ROOT / "data" / "results").is_dir() else []


@pytest.mark.parametrize("page, sentence", CLAIMS, ids=[f"{page}-{number}" for number, (page, _) in enumerate(CLAIMS)])
def test_the_sentence_is_that_of_the_data(page, sentence):
    assert sentence in text(page), f"{page} does not say {sentence!r}"


def test_the_page_of_the_interface_has_every_name():
    pages = [path.read_text(encoding="utf-8") for path in (ROOT / "docs/python-api").glob("*.md")]
    named = re.findall(r"^\.\. auto(?:function|class|exception):: (\w+)", "\n".join(pages), re.M)
    listed = re.findall(r"`(\w+)`", (ROOT / "docs/python-api.md").read_text(encoding="utf-8"))
    assert sorted(named) == sorted(set(gfmd.__all__) - {"__version__"})
    assert set(listed) == set(named)


def test_versions_agree():
    [version] = set(re.findall(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M))
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text()
    oldest = re.search(r'^rust-version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M)[1]
    for page in ("README.md", "CONTRIBUTING.md", "docs/start.md", "docs/versions.md", "docs/python.md"):
        assert f"{oldest}" in text(page), (page, oldest)
