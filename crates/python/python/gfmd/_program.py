"""The command `gfmd`."""

from __future__ import annotations

import sys

from . import _gfmd


def main() -> None:
    """Runs the program with the arguments of the command line."""
    sys.exit(_gfmd.program(["gfmd", *sys.argv[1:]]))
