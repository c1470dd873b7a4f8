"""Every example runs, quickly, and draws its figure."""

import subprocess
import sys
from pathlib import Path

import pytest

resource = pytest.importorskip("resource")

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example(example, tmp_path):
    pytest.importorskip("matplotlib")
    figure = tmp_path / "figure.png"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, example, figure], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr
    assert figure.stat().st_size > 5000
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # Time of the processor, which is that of a quiet machine with one core.
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 10.0
