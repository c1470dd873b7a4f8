"""Parts of a contact beside body and law."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

from ._check import Quantity, in_units, quantity, shown, word
from ._errors import InputError

_BY = ("distance", "slip")


@dataclass(frozen=True)
class Wear:
    """Wear of both surfaces together by Archard's law, a part of a `path`.

    Args:
        coefficient: wear coefficient divided by the hardness, 1/stress: depth lost per repulsive pressure and sliding
            distance. It may be a string with a unit, such as "1e-15/Pa" or "1e-6 mm^3/N/m", if the surface has one.
        by: sliding that causes wear: "distance", the distance given to the path, or "slip", the slip of each point,
            with friction.

    Raises:
        InputError: a coefficient that is not positive and finite, an unknown name.

    Example:
        >>> gfmd.Wear("1e-15/Pa", by="slip")
        Wear(coefficient='1e-15/Pa', by='slip')
    """

    coefficient: Quantity
    by: Literal["distance", "slip"] = "distance"

    def __post_init__(self) -> None:
        found = in_units("coefficient", quantity("coefficient", self.coefficient))
        if not (0.0 < found < math.inf):
            allowed = "positive and finite"
            text = f"coefficient is {shown(self.coefficient)}; it must be {allowed}"
            raise InputError(text, "coefficient", shown(self.coefficient), allowed)
        if word("by", self.by) not in _BY:
            allowed = "'distance' or 'slip'"
            raise InputError(f"by is {self.by!r}; it must be {allowed}", "by", repr(self.by), allowed)
        if not isinstance(self.coefficient, str):
            object.__setattr__(self, "coefficient", found)

    def _keys(self) -> dict[str, Any]:
        """Returns the configuration keys."""
        return {"coefficient": self.coefficient, "wear_by": self.by}


def wear_keys(wear: object) -> dict[str, Any]:
    """Returns the configuration keys of the wear; empty without it."""
    if wear is None:
        return {}
    if not isinstance(wear, Wear):
        raise InputError(f"wear is {shown(wear)}; it must be a gfmd.Wear, such as gfmd.Wear(coefficient=1e-15)")
    return wear._keys()
