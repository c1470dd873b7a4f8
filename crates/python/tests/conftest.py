"""Figures without a screen; the program of this package beside the one that Cargo built."""

import json
import os
import subprocess
import sys

import pytest

os.environ.setdefault("MPLBACKEND", "Agg")


def program(*words):
    """The JSON of the program with these words: GFMD_PROGRAM names it; else the one of the package, in a process of its
    own.
    """
    named = os.environ.get("GFMD_PROGRAM")
    start = [named] if named else [sys.executable, "-c", "from gfmd._program import main; main()"]
    done = subprocess.run([*start, *words, "--json", "--quiet"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture
def run_program():
    return program
