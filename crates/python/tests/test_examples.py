"""Every example runs, quickly, and draws its figure."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example(example, tmp_path):
    pytest.importorskip("matplotlib")
    figure = tmp_path / "figure.png"
    started = time.perf_counter()
    done = subprocess.run([sys.executable, example, figure], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert figure.stat().st_size > 5000
    assert time.perf_counter() - started < 10.0


def test_the_package_and_the_examples_are_typed():
    pytest.importorskip("mypy")
    folder = Path(__file__).parents[1]
    words = ["--strict", "--ignore-missing-imports", "--allow-untyped-calls", folder / "python" / "gfmd", *EXAMPLES]
    done = subprocess.run([sys.executable, "-m", "mypy", *words], capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stdout
