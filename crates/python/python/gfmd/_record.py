"""Immutable results: values by name, with the JSON keys of docs/interface.md."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from . import _hints

# Size of the largest array shown in full.
_FEW = 6

# Number of rows shown; of a longer table, the first and the last ones.
_ROWS = 12


def table(columns: Mapping[str, Any]) -> str:
    """Formats columns of equal length below their names: all lines, or the first and the last ones."""
    count = max((len(values) for values in columns.values()), default=0)
    half = _ROWS // 2
    shown = list(range(count)) if count <= _ROWS else [*range(half), *range(count - half, count)]
    rows = [["", *columns]]
    for index in shown:
        if index == count - half and count > _ROWS:
            rows.append(["...", *("" for _ in columns)])
        rows.append([str(index), *(_short(values[index].item()) for values in columns.values())])
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    return "".join("\n" + "  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths)).rstrip() for row in rows)


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Record):
        return value._short()
    if isinstance(value, list) and value and isinstance(value[0], Record):
        return f"{len(value)} records"
    if isinstance(value, np.ndarray):
        few = value.size <= _FEW and value.dtype.kind in "fiub"
        shown = np.array2string(value, precision=6, separator=", ").replace("\n", "") if few else ""
        return shown or f"array {list(value.shape)}"
    text = str(value)
    return text if len(text) <= 100 else text[:97] + "..."


class Record(Mapping[str, Any]):
    """Immutable named values, as attributes and as a mapping: `r.kappa`, `r["kappa"]`, `dict(r)`.

    Example:
        >>> r = gfmd.self_affine(n=64).statistics()
        >>> r.n == r["n"], "hurst" in r
        (True, True)
    """

    _values: dict[str, Any]

    def __init__(self, values: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_values", dict(values))

    def __getattr__(self, name: str) -> Any:
        return self._value(name)

    def _value(self, name: str) -> Any:
        """Returns the value of an attribute."""
        if not name.startswith("_"):
            values = self.__dict__.get("_values", {})
            if name in values:
                return values[name]
        hint = "" if name.startswith("_") else _hints.attribute(name, dir(self))
        raise AttributeError(f"{type(self).__name__} has no {name}{hint}")

    @classmethod
    def _declared(cls) -> list[str]:
        """Returns the names of the values that records of this class may have, from the generated classes."""
        made = [
            kind for kind in cls.__mro__ if kind.__module__ == f"{__package__}._columns" and issubclass(kind, Record)
        ]
        return [name for kind in made for name, value in vars(kind).items() if isinstance(value, property)]

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a {type(self).__name__} cannot be changed")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a {type(self).__name__} cannot be changed")

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __dir__(self) -> list[str]:
        return [*(set(super().__dir__()) - set(self._declared())), *self._values]

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._values,)

    def __eq__(self, other: object) -> bool:
        return self is other

    __hash__ = object.__hash__

    def _short(self) -> str:
        """Formats the record as a value in another one."""
        return f"{type(self).__name__} of {', '.join(self)}"

    def _text(self, name: str, value: Any) -> str:
        """Formats a value."""
        return _short(value)

    def __repr__(self) -> str:
        rows = "".join(f"\n  {name:<30} {self._text(name, value)}" for name, value in self._values.items())
        return f"{type(self).__name__}{rows}"

    def _repr_html_(self) -> str:
        cells = (
            f"<tr><td>{html.escape(name)}</td><td>{html.escape(self._text(name, value))}</td></tr>"
            for name, value in self._values.items()
        )
        return f"<b>{type(self).__name__}</b><table>{''.join(cells)}</table>"


def parsed(text: str) -> dict[str, Any]:
    """Parses a JSON object."""
    found = json.loads(text)
    assert isinstance(found, dict)
    return found


def by_name(reasons: Mapping[str, list[str]]) -> dict[str, str]:
    """Returns the reasons for missing values by name; JSON has a list of names for each reason."""
    return {name: reason for reason, names in reasons.items() for name in names}


def without_null(values: Mapping[str, Any]) -> dict[str, Any]:
    """Replaces null by NaN."""

    def reported(value: Any) -> Any:
        if isinstance(value, list):
            return [reported(entry) for entry in value]
        return math.nan if value is None else value

    return {name: reported(value) for name, value in values.items()}


def json_of(values: Mapping[str, Any]) -> str:
    """Writes the numbers of a load as JSON, with null in place of NaN."""

    def reported(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {name: reported(entry) for name, entry in value.items()}
        if isinstance(value, (list, tuple)):
            return [reported(entry) for entry in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps(reported(values))
