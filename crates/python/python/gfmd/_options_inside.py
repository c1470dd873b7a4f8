"""Types of the options that functions take as keyword arguments; None is the default.

Made from the flags of crates/cli/src by `GFMD_DOCS=write cargo test -p gfmd-cli -- options`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Literal, Optional, TypedDict

import numpy.typing as npt

from ._check import Quantity


class InteriorOptions(TypedDict, total=False):
    """Arguments of `interior` beside the depths."""

    levels: Optional[int]
    deepest: Optional[Quantity]
    along: Optional[str]
    quantities: Optional[Sequence[Literal["displacement", "strain", "stress", "von-mises", "energy-density"]]]
    out: Optional[str | os.PathLike[str]]
    threads: Optional[int]


class PunchOptions(TypedDict, total=False):
    """Arguments of `punch` beside the body."""

    size: Optional[float]
    dim: Optional[int]
    n: Optional[int]
    punch_fraction: Optional[float]
    depth: Optional[float]
    contact: Optional[Literal["sticking", "frictionless"]]
    nodes: Optional[Literal["strict", "inclusive"]]
    mask: Optional[npt.ArrayLike]
    traction: Optional[npt.ArrayLike]
    shift: Optional[Sequence[float]]
    solver: Optional[Literal["auto", "cg", "verlet", "verlet-critical", "verlet-modes", "fire"]]
    dt: Optional[float]
    damping: Optional[float | Sequence[float]]
    history: bool
    history_modes: Optional[Sequence[tuple[int, int, str]]]
    history_points: Optional[Sequence[tuple[float, float, str]]]
    tolerance: Optional[float]
    max_iterations: Optional[int]
    refine: Optional[int]
    out: Optional[str | os.PathLike[str]]
    threads: Optional[int]


class GreenOptions(TypedDict, total=False):
    """Arguments of `green` beside the body and the wave vector along x."""

    dim: Optional[int]
    qy: Optional[float]
    z: Optional[float]
    depth: Optional[float]


class EstimateOptions(TypedDict, total=False):
    """Arguments of `estimate` beside the load."""

    stress_unit: Optional[str]
    hardness: Optional[Quantity]


class PronyOptions(TypedDict, total=False):
    """Arguments of `prony` beside the measured moduli."""

    wlf: Optional[tuple[float, float, float]]
    stress_unit: Optional[str]
    branches: Optional[int]
    times: Optional[npt.ArrayLike]
    long_term: Optional[float]


class SweepOptions(TypedDict, total=False):
    """Arguments of `kappa_sweep` beside the configuration."""

    out: Optional[str | os.PathLike[str]]
    resume: bool
    threads: Optional[int]


class StudyOptions(TypedDict, total=False):
    """Arguments of `study` beside the configuration."""

    out: Optional[str | os.PathLike[str]]
    resume: bool
    threads: Optional[int]
