"""Immutable results: values by name, with the JSON keys of docs/interface.md."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Optional

import numpy as np

from . import _hints, _units
from ._check import shown
from ._errors import InputError
from ._units import Units

# Size of the largest array shown in full, number of lines of a representation, and largest length of a line.
_FEW, LINES, _WIDTH = 6, 15, 118


def table(columns: Mapping[str, Sequence[str]], most: int) -> str:
    """Formats columns of equal length below their names, in at most this number of further lines."""
    count = max((len(cells) for cells in columns.values()), default=0)
    first, last = (count, 0) if count < most else (most // 2 - 1, most - most // 2 - 1)
    rows = [["", *columns]]
    for index in [*range(first), *range(count - last, count)]:
        if index == count - last and last:
            rows.append(["...", *("" for _ in columns)])
        rows.append([str(index), *(cells[index] for cells in columns.values())])
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    return "".join("\n" + "  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths)).rstrip() for row in rows)


def cut(text: str, width: int = _WIDTH) -> str:
    """Returns a text as one line of at most this length."""
    line = " ".join(text.split())
    return line if len(line) <= width else line[: width - 3] + "..."


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Record):
        return value._short()
    if isinstance(value, list) and value and isinstance(value[0], Record):
        return "; ".join(_short(entry) for entry in value)
    if isinstance(value, np.ndarray):
        return _of_array(value)
    if isinstance(value, list):
        return f"[{', '.join(_short(entry) for entry in value)}]"
    return str(value)


def _of_array(values: Any) -> str:
    """Formats an array: all of it, the first and last values of a row, or shape and range."""
    if values.dtype.kind not in "fiub" or values.size == 0:
        return f"array {list(values.shape)}"
    if values.size <= _FEW:
        return _short(values.tolist())
    if values.ndim == 1:
        ends = [", ".join(_short(value) for value in part.tolist()) for part in (values[:2], values[-2:])]
        return f"[{ends[0]}, ..., {ends[1]}] ({values.size})"
    there = values[np.isfinite(values)]
    span = f", {_short(there.min().item())} to {_short(there.max().item())}" if there.size else ""
    return f"array {list(values.shape)}{span}"


def same(one: Any, other: Any) -> bool:
    """Returns True if two result values are equal apart from wall times; NaN equals NaN."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        if not (isinstance(one, np.ndarray) and isinstance(other, np.ndarray)) or one.dtype.kind != other.dtype.kind:
            return False
        return np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        names = [set(values) - {"seconds"} for values in (one, other)]
        return names[0] == names[1] and all(same(one[name], other[name]) for name in names[0])
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(same(*pair) for pair in zip(one, other))
    return bool(one == other) or (
        isinstance(one, float) and isinstance(other, float) and math.isnan(one) and math.isnan(other)
    )


class Record(Mapping[str, Any]):
    """Immutable named values, as attributes and as a mapping: `r.kappa`, `r["kappa"]`, `dict(r)`.

    Records are equal if their values are equal, apart from wall times (`seconds`). A representation has at most 15
    lines; `dict(r)` has everything.

    Example:
        >>> r = gfmd.self_affine(n=64).statistics()
        >>> r.n == r["n"], "hurst" in r
        (True, True)
    """

    # Names of values to show first.
    _main: tuple[str, ...] = ()
    _values: dict[str, Any]
    _known: Units

    def __init__(self, values: Mapping[str, Any], units: Units = (None, None)) -> None:
        object.__setattr__(self, "_values", dict(values))
        object.__setattr__(self, "_known", units)

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
        """Returns the possible value names of this class, from the generated classes."""
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
        return type(self), (self._values, self._known)

    def __eq__(self, other: object) -> bool:
        return self is other or (type(self) is type(other) and isinstance(other, Record) and same(self, other))

    def __hash__(self) -> int:
        return hash((type(self).__name__, frozenset(name for name in self._values if name != "seconds")))

    def _units_shown(self) -> Units:
        """Returns the length unit and stress unit of the values, None if unknown."""
        return self._known

    def _short(self) -> str:
        """Formats the record as a value in another one."""
        return ", ".join(f"{name} {self._text(name, value)}" for name, value in self._values.items())

    def _text(self, name: str, value: Any) -> str:
        """Formats a value; a number with its unit, to the digits that its grid error leaves certain."""
        if isinstance(value, float):
            limit, error = self.get(f"{name}_limit"), self.get(f"{name}_limit_error", math.nan)
            return _units.text(name, value, self._units_shown(), limit, error)
        if isinstance(value, list) and value and all(isinstance(entry, float) for entry in value):
            value = np.array(value)
        if isinstance(value, np.ndarray) and value.dtype.kind == "f" and name in _units.KINDS:
            factor, unit = _units.label("", name, value, self._units_shown())
            return _short(value * factor) + unit.replace(" /", "")
        return _short(value)

    def _title(self) -> str:
        """Returns the first line of the representation."""
        return type(self).__name__

    def _rest(self, count: int) -> str:
        """Returns the last line of the representation, about omitted values."""
        return f"{count} more values: dict(r)"

    def __repr__(self) -> str:
        names = [name for name in self._main if name in self] or list(self)
        names = names if len(names) == len(self) < LINES else names[: LINES - 2]
        width = max(map(len, names), default=0)
        rows = [f"{name:<{width}} {cut(self._text(name, self[name]), _WIDTH - width - 3)}" for name in names]
        if len(names) < len(self):
            rows.append(self._rest(len(self) - len(names)))
        return "\n".join([self._title(), *(f"  {row}" for row in rows)])

    def _repr_html_(self) -> str:
        cells = (
            f"<tr><td>{html.escape(name)}</td><td>{html.escape(cut(self._text(name, value)))}</td></tr>"
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


def reason_of(values: Mapping[str, Any], name: str) -> Optional[str]:
    """Returns why a number of a result is NaN; None if it has a value."""
    if name not in values:
        raise InputError(f"name is {shown(name)}; it must be one of {', '.join(values)}")
    found: Optional[str] = values.get("undefined", {}).get(name)
    return found


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
