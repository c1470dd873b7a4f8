"""Protocols of objects that other modules need."""

from __future__ import annotations

from collections.abc import ItemsView
from typing import Any, Optional, Protocol, Union, runtime_checkable

from ._check import Array
from ._units import Units


class Cell(Protocol):
    """Heights in a cell: a `Surface`."""

    @property
    def heights(self) -> Array: ...

    @property
    def n(self) -> tuple[int, int]: ...

    @property
    def size(self) -> tuple[float, float]: ...

    @property
    def unit(self) -> Optional[str]: ...


@runtime_checkable
class Fitted(Protocol):
    """A fitted Prony series: a `PronyFit`."""

    @property
    def series(self) -> list[tuple[float, float]]: ...

    @property
    def young(self) -> Union[float, str]: ...


class Pressed(Protocol):
    """Numbers and fields on the points of a surface: a `Contact`."""

    @property
    def surface(self) -> Cell: ...

    @property
    def units(self) -> Units: ...

    @property
    def _fields(self) -> dict[str, Array]: ...

    def __getitem__(self, name: str) -> Any: ...

    def items(self) -> ItemsView[str, Any]: ...


@runtime_checkable
class Loaded(Protocol):
    """A loaded body, with fields below its surface: a `Contact` or a `Punch`."""

    def _loading(self) -> tuple[dict[str, Any], Any]:
        """Returns the configuration keys of the body and the cell, and the surface displacement."""
