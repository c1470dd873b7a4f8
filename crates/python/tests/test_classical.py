"""The page of classical problems: its lines run, print what stands below them, and agree with the closed forms.

`GFMD_DOCS=write pytest crates/python/tests/test_classical.py` writes the notebook with the lines of the page.
"""

import contextlib
import io
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import gfmd
import numpy as np
import pytest

PAGE = Path(__file__).parents[3] / "docs" / "classical.md"
NOTEBOOK = Path(__file__).parents[1] / "examples" / "classical.ipynb"

pytestmark = pytest.mark.skipif(not PAGE.exists(), reason="the repository is not there")

# Largest relative difference between the number of the program and the closed form: laws of finite range, the singular
# edge of a punch, the staircase of a rim.
ALLOWED = {"exponential": 0.04, "dugdale": 0.06, "stick": 0.015}
ELSE = 0.006


def sections():
    for section in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        blocks = re.findall(r"```(sh|python|text)\n(.*?)```", section, re.DOTALL)
        yield pytest.param(dict(blocks), id=section.splitlines()[0].split(":")[0])


def printed(code):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(code, {"gfmd": gfmd, "np": np})
    return out.getvalue()


@pytest.mark.parametrize("blocks", [*sections()])
def test_the_lines_print_what_stands_below_and_agree_with_the_closed_form(blocks):
    assert len(blocks["python"].splitlines()) <= 5
    found = printed(blocks["python"])
    assert found == blocks["text"]
    for line in found.splitlines():
        numbers = [float(number) for number in re.findall(r"(?<= )[0-9.]+(?= |,|$)", line)]
        assert len(numbers) == 2, line
        assert numbers[0] == pytest.approx(numbers[1], rel=ALLOWED.get(re.split("[ :]", line)[0], ELSE)), line


@pytest.mark.parametrize("blocks", [*sections()])
def test_the_command_is_the_same_contact(blocks, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "c.h5"
    words = shlex.split(blocks["sh"].replace("\\\n", " "))
    assert words[0] == "gfmd"
    program = [sys.executable, "-c", "from gfmd._program import main; main()"]
    subprocess.run([*program, *words[1:], "-q", "--out", str(out)], check=True, stdout=subprocess.DEVNULL)
    names = {}
    exec(blocks["python"].split("print")[0].rpartition("\n")[0], {"gfmd": gfmd, "np": np}, names)
    surfaces = [value for value in names.values() if isinstance(value, gfmd.Surface)]
    surfaces += [value.surface for value in names.values() if isinstance(value, gfmd.Contact)]
    assert np.array_equal(gfmd.read(f"{out}:/surface/height").heights, surfaces[0].heights)


def cells():
    """Yields the cells of the notebook: the text of the page without its commands, its lines, what they print."""

    def cell(kind, text, **more):
        return {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text.splitlines(True), **more}

    def code(text, printed=""):
        output = {"output_type": "stream", "name": "stdout", "text": printed.splitlines(True)}
        return cell("code", text, execution_count=None, outputs=[output] if printed else [])

    number = 0
    imports = "import gfmd\nimport numpy as np"
    yield code(imports)
    page = re.sub(r"```sh\n.*?```\n+", "", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    page = page.replace(f"```python\n{imports}\n```\n\n", "")
    page = re.sub(r"\]\((?!http|#)[^)]*\)", "]", page).replace("[", "").replace("]", "")
    for text in re.split(r"(```python\n.*?```\n+```text\n.*?```)", page, flags=re.DOTALL):
        number += 1
        blocks = dict(re.findall(r"```(python|text)\n(.*?)```", text, re.DOTALL))
        if blocks:
            yield code(blocks["python"].rstrip("\n"), blocks["text"])
        elif text.strip():
            yield cell("markdown", text.strip())


def test_the_notebook_has_the_lines_of_the_page():
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    notebook = {"cells": [*cells()], "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
    if os.environ.get("GFMD_DOCS") == "write":
        NOTEBOOK.write_text(text, encoding="utf-8")
    assert NOTEBOOK.read_text(encoding="utf-8") == text


def test_shapes_are_the_closed_forms_and_may_be_rough():
    s = gfmd.sphere("2 mm", size="1 mm", n=32)
    x = (np.arange(32) - 16) / 32
    r2 = x[:, None] ** 2 + x[None, :] ** 2
    assert s.unit == "mm" and np.allclose(s.heights, np.sqrt(4 - r2) - 2, rtol=0, atol=1e-15)
    assert not s.is_periodic and s == gfmd.self_affine(shape="sphere:R=2000um", size=1.0, unit="mm", n=32)
    rough = gfmd.sphere(2.0, n=32, rms_height=1e-3, seed=5, eps_f_inv=4)
    flat = gfmd.self_affine(n=32, rms_height=1e-3, seed=5, eps_f_inv=4)
    assert np.allclose(rough.heights, gfmd.sphere(2.0, n=32).heights + flat.heights, rtol=0, atol=1e-15)
    assert gfmd.wave(0.1, (0.5, "0.25 m"), size="1 m", n=32).is_periodic
    both = gfmd.paraboloid((1.0, 2.0), n=4).heights
    assert both[0, 2] == -0.125 and both[2, 0] == -0.0625
    assert gfmd.cylinder(1.0, axis="x", n=8).heights[0, 4] == 0.0


@pytest.mark.parametrize(
    "made, words",
    [
        (lambda: gfmd.sphere(-1.0), "shape: R of sphere is -1; it must be positive"),
        (lambda: gfmd.sphere("2 mm"), "shape: .*it has a unit"),
        (lambda: gfmd.sphere("2 N", size="1 mm"), "radius is '2 N'|radius.*force"),
        (lambda: gfmd.sphere(1e-3, n=16), "at least 0.0625, the grid spacing"),
        (lambda: gfmd.sphere(1.0, n=16, seed=3), "seed describes roughness"),
        (lambda: gfmd.sphere(1.0, dim=2), "shape: the shape is sphere; a profile has"),
        (lambda: gfmd.wave(0.1, 0.3), "Lx of wave is 0.3"),
        (lambda: gfmd.wave(0.1, (0.5, 0.5, 0.5)), "wavelength is"),
        (lambda: gfmd.ellipsoid((1.0, 2.0)), "semi_axes is"),
        (lambda: gfmd.cylinder(1.0, axis="z"), "axis of cylinder is z"),
        (lambda: gfmd.flat_punch(0.2), "R of flat-punch is 0; it must be positive without a depth"),
        (lambda: gfmd.self_affine(shape="torus:R=1"), 'the shape is "torus"'),
    ],
)
def test_unusable_shapes_are_refused(made, words):
    with pytest.raises(gfmd.InputError, match=words):
        made()
