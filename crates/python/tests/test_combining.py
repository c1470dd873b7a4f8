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
FIGURES = {"fretting": "wear", "adhesive": "path", "rubber": "path"}


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


@pytest.mark.parametrize("lines", LINES)
def test_the_lines_run(lines):
    pytest.importorskip("matplotlib")
    exec(lines, {})


def test_every_example_has_a_command_and_lines():
    assert len(COMMANDS) == len(LINES) == len(FIGURES)
