"""Results that cannot be changed: values by name, as the JSON keys of docs/interface.md."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Iterator, Mapping
from typing import Any


def _short(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Residual):
        return f"{float(value):.1e}, the largest of {', '.join(value)}"
    if isinstance(value, Record):
        return f"{type(value).__name__} of {', '.join(value)}"
    if isinstance(value, list) and value and isinstance(value[0], Record):
        return f"{len(value)} records"
    if hasattr(value, "shape"):
        return f"array {list(value.shape)}"
    text = str(value)
    return text if len(text) <= 100 else text[:97] + "..."


class Record(Mapping[str, Any]):
    """Named values that cannot be changed, as attributes and as a mapping: `r.kappa`, `r["kappa"]`, `dict(r)`.

    Example:
        >>> r = gfmd.self_affine(n=64).statistics()
        >>> r.n == r["n"], "hurst" in r
        (True, True)
    """

    _values: dict[str, Any]

    def __init__(self, values: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_values", dict(values))

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_"):
            values = self.__dict__.get("_values", {})
            if name in values:
                return values[name]
        raise AttributeError(f"{type(self).__name__} has no {name}")

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
        return [*super().__dir__(), *self._values]

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._values,)

    def __eq__(self, other: object) -> bool:
        return self is other

    __hash__ = object.__hash__

    def _text(self, name: str, value: Any) -> str:
        """A value as it is shown."""
        return _short(value)

    def __repr__(self) -> str:
        rows = "".join(f"\n  {name:<30} {self._text(name, value)}" for name, value in self._values.items())
        return f"{type(self).__name__}{rows}"

    def _repr_html_(self) -> str:
        cells = (f"<tr><td>{html.escape(name)}</td><td>{html.escape(self._text(name, value))}</td></tr>" for name, value in self._values.items())
        return f"<b>{type(self).__name__}</b><table>{''.join(cells)}</table>"


class Residual(Record):
    """The parts of the residual by name, all without unit. `float(residual)` is the largest.

    Attributes:
        complementarity: sum(p gap) over sum(p) times the rms height.
        penetration: largest overlap over the rms height.
        negative_pressure: largest tension over the mean pressure.
        load: mean pressure less the asked one, over the asked one.
        saturation: with a hardness only, largest gap over the rms height where the pressure is the hardness.
        lateral_traction: with all components only, largest lateral traction that the dynamics left over the largest pressure.
        lateral_displacement: with finite slopes only, last change of the lateral displacement over the rms height.

    Example:
        >>> float(c.residual) <= 1e-8, c.residual.load <= 1e-8
        (True, True)
    """

    complementarity: float
    penetration: float
    negative_pressure: float
    load: float
    saturation: float
    lateral_traction: float
    lateral_displacement: float

    def __float__(self) -> float:
        parts = [float(part) for part in self._values.values()]
        return math.nan if any(math.isnan(part) for part in parts) else max(parts)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mapping) and self._values == dict(other)

    def __hash__(self) -> int:
        return hash(tuple(self._values.items()))


def parsed(text: str) -> dict[str, Any]:
    """A JSON object."""
    found = json.loads(text)
    assert isinstance(found, dict)
    return found


def without_null(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values with NaN in place of null."""

    def reported(value: Any) -> Any:
        if isinstance(value, list):
            return [reported(entry) for entry in value]
        return math.nan if value is None else value

    return {name: reported(value) for name, value in values.items()}


def of_load(record: str) -> dict[str, Any]:
    """The numbers of a load, from its JSON: parts as Records, NaN in place of null."""

    def part(name: str, value: Any) -> Any:
        if not isinstance(value, dict) or name == "undefined":
            return value
        kind = Residual if name == "residual" else Record
        return kind(without_null({key: part(key, entry) for key, entry in value.items()}))

    return without_null({name: part(name, value) for name, value in parsed(record).items()})


def json_of(values: Mapping[str, Any]) -> str:
    """The numbers of a load as JSON, which has no NaN."""

    def reported(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {name: reported(entry) for name, entry in value.items()}
        if isinstance(value, (list, tuple)):
            return [reported(entry) for entry in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps(reported(values))
