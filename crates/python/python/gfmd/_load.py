"""Records of loads."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ._check import frozen, kind_of
from ._columns import LowerFace, Residuals
from ._record import Record, by_name, parsed, without_null

# Kinds of the loads.
LOADS = {name: kind_of(name) for name in ("pressure", "p_star", "force", "approach")}


class Residual(Residuals):
    """Residual parts by name, all dimensionless; arrays for several loads, steps or states.

    `largest` is the largest part at each; `float(residual)` is the largest of all. NaN if a part is NaN.

    Example:
        >>> float(c.residual) <= 1e-8, c.residual.load <= 1e-8
        (True, True)
        >>> loop.residual.largest.shape, float(loop.residual) == max(loop.residual.largest)
        ((9,), np.True_)
    """

    @property
    def largest(self) -> Any:
        """Largest part, a number or an array [load], [step] or [state]; without unit."""
        parts = [np.asarray(part, dtype=np.float64) for part in self._values.values()]
        found = np.asarray(np.max(parts, axis=0) if parts else math.nan)
        return float(found) if found.ndim == 0 else frozen(found)

    def _title(self) -> str:
        return f"Residual, the largest {float(self):.1e}"

    def _short(self) -> str:
        return f"{float(self):.1e}, the largest of {', '.join(self)}"

    def __float__(self) -> float:
        return float(np.max(self.largest, initial=-math.inf)) if np.size(self.largest) else math.nan


def residual_of(table: Mapping[str, Any]) -> Residual:
    """Returns the residual of steps or states from table columns, `residual_...`."""
    start = "residual_"
    return Residual({name[len(start) :]: values for name, values in table.items() if name.startswith(start)})


def residual_of_all(parts: Sequence[Residual]) -> Residual:
    """Returns the residuals of loads as one residual of arrays [load]."""
    names = dict.fromkeys(name for residual in parts for name in residual)
    return Residual({name: frozen(np.array([float(residual.get(name, 0.0)) for residual in parts])) for name in names})


def of_load(record: str) -> dict[str, Any]:
    """Reads the numbers of a load from JSON, with objects as Records and NaN in place of null."""

    def part(name: str, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        if name == "undefined":
            return by_name(value)
        kind = {"residual": Residual, "lower": LowerFace}.get(name, Record)
        return kind(without_null({key: part(key, entry) for key, entry in value.items()}))

    return without_null({name: part(name, value) for name, value in parsed(record).items()})
