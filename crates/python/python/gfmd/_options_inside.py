"""Types of the options that functions pass on, as keyword arguments.

Made from the flags of crates/cli/src by `GFMD_DOCS=write cargo test -p gfmd-cli -- options`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Literal, Optional, TypedDict

from ._check import Quantity


class InteriorOptions(TypedDict, total=False):
    """Arguments of `interior` beside the depths."""

    levels: Optional[int]
    deepest: Optional[Quantity]
    along: Optional[str]
    quantities: Sequence[Literal["displacement", "strain", "stress", "von-mises", "energy-density"]]
    out: Optional[str | os.PathLike[str]]
    threads: Optional[int]
