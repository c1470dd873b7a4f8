"""Types of the options that functions take as keyword arguments; None is the default.

Made from the flags of crates/cli/src by `GFMD_DOCS=write cargo test -p gfmd-cli -- options`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, Optional, TypedDict

import numpy.typing as npt

from ._check import Quantity

if TYPE_CHECKING:
    from ._body import Law
    from ._contact import Contact
    from ._surface import Surface


class ContactOptions(TypedDict, total=False):
    """Arguments of `contact` beside the load."""

    stress_unit: Optional[str]
    base_displacement: Optional[npt.ArrayLike]
    base_traction: Optional[npt.ArrayLike]
    lower_surface: Optional[Surface | npt.ArrayLike]
    boundary: Optional[Literal["periodic", "free"]]
    components: Optional[Literal["normal", "all", "held"]]
    hardness: Optional[Quantity | npt.ArrayLike]
    finite_slope: bool
    solver: Optional[
        Literal[
            "auto",
            "cg",
            "projected-cg",
            "preconditioned-cg",
            "verlet",
            "verlet-critical",
            "verlet-modes",
            "fire",
            "fire2",
            "augmented-lagrangian",
            "newton",
        ]
    ]
    tolerance: Optional[float]
    max_iterations: Optional[int]
    stiffness_tolerance: Optional[float]
    dt: Optional[float]
    damping: Optional[float | Sequence[float]]
    law: Optional[Law | str]
    coarse: bool
    grid_error: Optional[Literal["none", "estimate", "refine"]]
    accuracy: Optional[float | str]
    range_continuation: bool
    threads: Optional[int]
    start: Optional[Contact]


class PathOptions(TypedDict, total=False):
    """Arguments of `path` beside those of `friction` and `wear`."""

    stress_unit: Optional[str]
    lower_surface: Optional[Surface | npt.ArrayLike]
    cells: Optional[str | Sequence[Quantity]]
    coarsening: Optional[Sequence[int]]
    kept_strain: Optional[Literal["last", "waypoints"]]
    law: Optional[Law | str]
    coarse: bool
    friction_of: Optional[Literal["repulsion", "net"]]
    boundary: Optional[Literal["periodic", "free"]]
    components: Optional[Literal["normal", "all", "held"]]
    base_displacement: Optional[npt.ArrayLike]
    base_traction: Optional[npt.ArrayLike]
    grid_error: Optional[Literal["none", "estimate", "refine"]]
    statistics: bool
    conductor_height: Optional[Quantity]
    conductivity: Optional[Sequence[Quantity]]
    flow: bool
    fluid: Optional[str]
    viscosity: Optional[Quantity]
    pressure_drop: Optional[Quantity]
    gas: Optional[Literal["air", "nitrogen", "argon", "helium", "hydrogen"]]
    gas_temperature: Optional[Quantity]
    gas_pressure: Optional[Quantity]
    gas_accommodation: Optional[Sequence[float]]
    gas_conductivity: Optional[Quantity]
    gas_jump: Optional[Quantity]
    hardness: Optional[Quantity | npt.ArrayLike]
    time: Optional[Quantity | npt.ArrayLike]
    direction: Optional[float]
    steps: Optional[int | Sequence[int]]
    tolerance: Optional[float]
    max_iterations: Optional[int]
    out: Optional[str | os.PathLike[str]]
    stiffness_tolerance: Optional[float]
    energy_tolerance: Optional[float]
    energy_solves: Optional[int]
    threads: Optional[int]


class SlideOptions(TypedDict, total=False):
    """Arguments of `slide` beside load and velocity."""

    stress_unit: Optional[str]
    friction: Optional[float]
    hardness: Optional[Quantity | npt.ArrayLike]
    heat: Optional[Sequence[Quantity]]
    direction: Optional[float]
    tolerance: Optional[float]
    max_iterations: Optional[int]
    grid_error: Optional[Literal["none", "refine"]]
    out: Optional[str | os.PathLike[str]]
    threads: Optional[int]
