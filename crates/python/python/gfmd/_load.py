"""Records of loads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ._columns import LowerFace, Residuals
from ._record import Record, by_name, parsed, without_null


class Residual(Residuals):
    """Parts of the residual by name, all without unit. `float(residual)` is the largest part.

    Example:
        >>> float(c.residual) <= 1e-8, c.residual.load <= 1e-8
        (True, True)
    """

    def _short(self) -> str:
        return f"{float(self):.1e}, the largest of {', '.join(self)}"

    def __float__(self) -> float:
        parts = [float(part) for part in self._values.values()]
        return math.nan if any(math.isnan(part) for part in parts) else max(parts)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mapping) and self._values == dict(other)

    def __hash__(self) -> int:
        return hash(tuple(self._values.items()))


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
