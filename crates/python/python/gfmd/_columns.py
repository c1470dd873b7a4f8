"""Classes of result numbers and fields, defined in `_columns.json` and typed in `_columns.pyi`."""

from __future__ import annotations

from typing import Any, Optional

from ._record import Record
from ._units import DEFINED


def _attribute(name: str, text: str, held_in: Optional[str]) -> property:
    def value(self: Any) -> Any:
        return self._value(name) if held_in is None else getattr(self, held_in).get(name)

    return property(value, doc=text)


def _class(name: str, text: str, held_in: Optional[str], attributes: dict[str, str]) -> type:
    base: tuple[type, ...] = (Record,) if held_in is None else ()
    made = {attribute: _attribute(attribute, meaning, held_in) for attribute, meaning in attributes.items()}
    return type(name, base, {"__doc__": text, "__module__": __name__, **made})


MEASURED: dict[str, str] = DEFINED["measured"]
globals().update({name: _class(name, **found) for name, found in DEFINED["classes"].items()})
