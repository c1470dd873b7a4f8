"""Numbers that belong to a result, such as the flow through a gap."""

from __future__ import annotations

import os
from typing import Any, NoReturn

import numpy as np

from . import _show
from ._errors import Error
from ._record import Record
from ._units import Units

# Names of the parts of small arrays, by shape.
_PARTS = {(): ("",), (2,): ("_x", "_y"), (2, 2): ("_xx", "_xy", "_yx", "_yy")}


class Measured(Record):
    """Numbers with their units, and a table of them, but without a file or fields of their own."""

    @property
    def units(self) -> Units:
        """Length unit and stress unit of all numbers, None if unknown."""
        return self._known

    def to_dataframe(self) -> Any:
        """Returns the numbers as a pandas.DataFrame with one row; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> list(c.flow().to_dataframe())[:2]  # doctest: +SKIP
            ['conductivity_xx', 'conductivity_xy']
        """
        columns, names = {}, {}
        for name, value in self.items():
            found = np.asarray(value) if np.isscalar(value) or isinstance(value, (list, np.ndarray)) else None
            if found is not None and found.dtype.kind in "fiub" and found.shape in _PARTS:
                for part, entry in zip(_PARTS[found.shape], found.ravel().tolist()):
                    columns[name + part], names[name + part] = [entry], name
        return _show.framed(columns, names, self.units)

    def to_xarray(self) -> Any:
        """Refused: these numbers have no fields.

        Raises:
            Error: always.
        """
        self._refuse("fields; to_dataframe() has its numbers, dict(r) all values")

    def plot(self, *arguments: Any, **options: Any) -> Any:
        """Refused: these numbers have no figure.

        Raises:
            Error: always.
        """
        self._refuse("figure; dict(r) has its values")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Refused: these numbers have no file.

        Args:
            path: file name.

        Raises:
            Error: always.
        """
        self._refuse("file; save the result from which it was made, or pickle it")

    def _refuse(self, what: str) -> NoReturn:
        raise Error(f"{type(self).__name__} has no {what}")
