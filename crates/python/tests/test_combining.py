"""The commands of docs/combining.md make its figures, and its lines of Python run.

`GFMD_DOCS=write pytest crates/python/tests/test_combining.py` writes the figures.
"""

import os
import re
import shlex
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[3] / "docs"
TEXT = (DOCS / "combining.md").read_text(encoding="utf-8")
COMMANDS = [block.replace("\\\n", " ") for block in re.findall(r"```sh\n(.*?)```", TEXT, re.DOTALL)]
LINES = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)

# End of the name of the file that is the figure, by the prefix of the plots.
FIGURES = {"fretting": "wear", "adhesive": "path", "rubber": "path", "seal": "path"}


def parts(svg):
    """The text of a figure without its numbers, and the numbers."""
    number = r"-?\d+(?:\.\d+)?"
    return re.sub(number, "", svg), [float(found) for found in re.findall(number, svg)]


@pytest.mark.parametrize("command", COMMANDS)
def test_the_command_makes_the_figure(command, run_program, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, *words = shlex.split(command)
    assert name == "gfmd"
    report = run_program(*words)
    assert all(step["converged"] for step in report["steps"])
    prefix = words[words.index("--plots") + 1]
    drawn = (tmp_path / f"{prefix}-{FIGURES[prefix]}.svg").read_text(encoding="utf-8")
    kept = DOCS / "images" / f"combining-{prefix}.svg"
    if os.environ.get("GFMD_DOCS") == "write":
        kept.write_text(drawn, encoding="utf-8")
    assert f"images/{kept.name}" in TEXT
    (words_kept, places_kept), (words_drawn, places_drawn) = parts(kept.read_text(encoding="utf-8")), parts(drawn)
    # A tenth of a point cannot be seen.
    assert words_kept == words_drawn and places_drawn == pytest.approx(places_kept, abs=0.1)


def test_the_table_of_the_seal_is_measured(run_program):
    words = shlex.split(next(command for command in COMMANDS if "seal" in command))[1:-2]

    def both(*limits):
        """Returns the reports of the seal sheared at once and after a day, with these limits of the shear."""
        given = {"--friction": None, "--shear-strength": None, **dict(zip(limits[::2], limits[1::2]))}
        at_once = {"--time": "0,10s", "--lateral": "0,20um", "--steps": "1,10"}
        options = [dict(zip(words[1::2], words[2::2])) | given | legs for legs in (at_once, {})]
        kept = [{name: value for name, value in all.items() if value is not None} for all in options]
        return [run_program("path", *(word for pair in all.items() for word in pair)) for all in kept]

    def row(name, reports, number, unit):
        return f"| {name} | {' | '.join(number(report['steps']) + unit for report in reports)} |"

    def lost(steps):
        sums = [sum(step[f"lost_{cause}"] for step in steps) / 1e3 for cause in ("friction", "relaxation")]
        return ", ".join(f"{energy:.2f}" for energy in sums)

    def shear_after_2_um(steps):
        return next(f"{step['mean_shear'][0] / 1e3:.0f}" for step in steps if abs(step["lateral"][0] - 2e-3) < 1e-9)

    def largest_shear(steps):
        return f"{max(step['mean_shear'][0] for step in steps) / 1e3:.0f}"

    limits = {
        "both limits": both("--friction", "2", "--shear-strength", "0.2MPa"),
        "friction alone": both("--friction", "0.6"),
    }
    area = row("contact area at the end", limits["both limits"], lambda s: f"{100 * s[-1]['area_fraction']:.0f}", " %")
    assert area in TEXT
    for name, reports in limits.items():
        assert row(f"shear after 2 µm, {name}", reports, shear_after_2_um, " kPa") in TEXT
        assert row(f"largest shear, {name}", reports, largest_shear, " kPa") in TEXT
        assert row("lost by friction, by relaxation", reports, lost, " J/m²") in TEXT
    ratio = [max(step["mean_shear"][0] for step in report["steps"]) for report in limits["both limits"]]
    assert f"by {100 * (ratio[1] / ratio[0] - 1):.0f} %" in TEXT


@pytest.mark.parametrize("lines", LINES)
def test_the_lines_run(lines):
    pytest.importorskip("matplotlib")
    exec(lines, {})


def test_every_example_has_a_command_and_lines():
    assert len(COMMANDS) == len(LINES) == len(FIGURES)
