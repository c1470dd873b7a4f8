"""Results with file, page and figures of the program."""

from __future__ import annotations

import base64
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Optional

import numpy as np

from . import _check, _gfmd, _units
from ._check import Array
from ._errors import Error, InputError
from ._record import Record, LINES, cut, table
from ._surface import Surface
from ._units import Units

# Limits for figures in a notebook: points of the grid, bytes, number of figures.
_MOST_POINTS, _MOST_BYTES, _MOST_PICTURES = 1 << 20, 100_000, 2


class Result:
    """A result, with the file, page and figures of the program, tables and a plot.

    `Contact`, `Contacts`, `Path`, `Slide`, `Punch`, `FieldsBelow`, `KappaSweep` and `Study` are results; `gfmd.load`
    reads them from their files.

    Example:
        >>> isinstance(c, gfmd.Result)
        True
    """

    __slots__ = ()

    @property
    def units(self) -> Units:
        """Length unit and stress unit of all numbers, None if unknown."""
        raise NotImplementedError

    def to_dataframe(self) -> Any:
        """Returns the numbers as a pandas.DataFrame with one row per load, step or depth; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> len(loop.to_dataframe())  # doctest: +SKIP
            9
        """
        raise NotImplementedError

    def to_xarray(self) -> Any:
        """Returns numbers and fields as an xarray.Dataset, with `units` and `long_name` of each.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> cs.to_xarray()["load"].long_name, cs.to_xarray().area_fraction.units
            ('load step', '1')
        """
        raise NotImplementedError

    def _write(self, path: str) -> None:
        raise NotImplementedError

    @contextmanager
    def _stored(self) -> Iterator[str]:
        """Writes a temporary file of the result for the duration of the block."""
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "result.h5")
            self._write(file)
            yield file

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the same HDF5 file as the command with `--out`, for `gfmd check`, `gfmd report` and others.

        Args:
            path: file name.

        Raises:
            InputError, Error: a file that cannot be written, or the input file of the surface. An existing file is then
                kept.

        Example:
            >>> loop.save("loop.h5")
        """
        target, surface = _check.path("path", path), getattr(self, "surface", None)
        if isinstance(surface, Surface):
            surface._keeps("path", target)
        self._write(target)

    def report(self, path: str | os.PathLike[str]) -> None:
        """Writes the HTML page of `gfmd report`.

        Args:
            path: page name.

        Raises:
            InputError, Error: a page that cannot be written; an existing file that is not a report is not replaced.

        Example:
            >>> c.report("contact.html")
            >>> loop.report("loop.html")
        """
        page = _check.path("path", path)
        with self._stored() as file:
            _gfmd.write_page(file, page)

    def figures(self) -> dict[str, str]:
        """Returns the figures of the page as SVG by name, in page order. Notebooks show them.

        Raises:
            InputError, Error: a result without a state, or without a file.

        Example:
            >>> "gap" in c.figures()
            True
        """
        with self._stored() as file:
            return Figures(_gfmd.figures(file))

    def _pictures(self, points: int) -> str:
        """Returns the first two figures of the page for a notebook, if they are quick to draw."""
        if points > _MOST_POINTS:
            return ""
        try:
            figures = self.figures()
        except Error:
            return ""  # a result without a state
        kept, bytes_left = Figures(), _MOST_BYTES
        for name, svg in figures.items():
            if len(kept) < _MOST_PICTURES and 4 * len(svg.encode()) <= 3 * bytes_left:  # base64
                bytes_left -= 4 * len(svg.encode()) // 3
                kept[name] = svg
        return kept._repr_html_()

    def save_figures(self, folder: str | os.PathLike[str]) -> list[str]:
        """Writes the `figures` as NAME.svg to a folder, created if missing. Returns their paths.

        Args:
            folder: folder name.

        Raises:
            InputError, Error: as in `figures`; a folder or a file that cannot be written.

        Example:
            >>> len(punch.save_figures("figures")) == len(punch.figures())
            True
        """
        place, paths = _check.path("folder", folder), []
        figures = self.figures()
        try:
            os.makedirs(place, exist_ok=True)
        except OSError as error:
            raise InputError(f"folder: {error}") from error
        for name, svg in figures.items():
            paths.append(os.path.join(place, f"{name}.svg"))
            _gfmd.write_file(paths[-1], svg.encode())
        return paths


class Figures(dict[str, str]):
    """Figures as SVG by name, shown in notebooks."""

    def _repr_html_(self) -> str:
        # As images, since identifiers of different figures may collide in one page.
        def image(name: str, svg: str) -> str:
            return f'<img alt="{name}" src="data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode()}">'

        return "".join(image(name, svg) for name, svg in self.items())


class File:
    """File of a result, written when needed: its fields and the rest."""

    def __init__(self, draft: Optional[_gfmd.FileDraft], fields: dict[str, Array]) -> None:
        self.draft, self.fields = draft, fields

    def write(self, path: str) -> None:
        if self.draft is None:
            raise Error("the result has no file: it was interrupted before the first state")
        self.draft.write(path, self.fields)

    def __reduce__(self) -> tuple[Any, ...]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "result.h5")
            self.write(str(path))
            return Contents, (path.read_bytes(),)


class Contents:
    """Bytes of a file."""

    def __init__(self, contents: bytes) -> None:
        self.contents = contents

    def write(self, path: str) -> None:
        _gfmd.write_file(path, self.contents)

    def __reduce__(self) -> tuple[Any, ...]:
        return Contents, (self.contents,)


class Computed(Result, Record):
    """Result of a command, with its file."""

    _file: File | Contents

    def __init__(self, values: Mapping[str, Any], file: File | Contents) -> None:
        super().__init__(values)
        object.__setattr__(self, "_file", file)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._values, self._file)

    def _write(self, path: str) -> None:
        self._file.write(path)

    @property
    def units(self) -> Units:
        """Length unit and stress unit of all numbers, None if unknown."""
        return _units.known(self.get("unit"), self.get("stress_unit"))

    def _units_shown(self) -> Units:
        return self.units

    def _answer(self, steps: str, names: tuple[str, ...], others: tuple[str, ...]) -> str:
        """Formats the main numbers: `names` of `steps` in a table, `others` below, and where to find the rest."""
        of, units = self[steps], self.units
        columns: dict[str, list[str]] = {}
        for name in names:
            values = of.get(name)
            if not isinstance(values, np.ndarray) or not np.isfinite(values).any():
                continue
            factor, head = _units.label(name, name, values, units)
            if values.ndim == 2:
                parts = [(f"{name}_{axis}", values[:, k]) for k, axis in enumerate("xy") if np.any(values[:, k])]
                columns.update((part + head[len(name) :], _cells(found, factor)) for part, found in parts)
            else:
                limit = (of.get(f"{name}_limit"), of.get(f"{name}_limit_error"))
                columns[head] = _cells(values, factor, *limit)
        count = len(next(iter(of.values()))) if len(of) else 0
        below = [f"{name} {self._text(name, self[name])}" for name in others if self.get(name) not in (None, [])]
        fields = [name for name, value in self.items() if isinstance(value, np.ndarray) and value.ndim > 2]
        rest = [f"{len(of)} numbers: dict(r.{steps}); fields: {', '.join(fields)}; the rest: dict(r)"] if count else []
        rows = "".join(f"\n  {cut(line)}" for line in (*below, *rest))
        title = f"{type(self).__name__}: {count} {steps if count != 1 else steps[:-1]}"
        return title + table(columns, LINES - 3 - len(below)) + rows

    def _repr_html_(self) -> str:
        fields = [
            value.size // len(value)
            for value in self._values.values()
            if isinstance(value, np.ndarray) and value.ndim > 1 and len(value)
        ]
        return self._pictures(max(fields, default=0)) + super()._repr_html_()


def _cells(values: Array, factor: float, limits: Optional[Array] = None, errors: Optional[Array] = None) -> list[str]:
    """Formats the cells of a column to the digits that their grid errors leave certain, if they have limits."""
    if limits is None or errors is None:
        return [f"{value * factor:.6g}" for value in values.tolist()]
    return [_gfmd.with_limit(*(number * factor for number in row)) for row in zip(values, limits, errors)]
