"""Studies of many contacts in one file."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _command, _show
from ._check import Array, flag, frozen, path, shown
from ._errors import InputError, Interrupted, NotConverged
from ._given import taking
from ._kappa import given
from ._options_inside import StudyOptions
from ._progress import hidden
from ._record import LINES, Record, cut, table
from ._result import Computed, Contents

if TYPE_CHECKING:
    from typing_extensions import Unpack

# Numbers in the table of a study.
_SHOWN = ("area_fraction", "mean_gap", "friction", "mean_pressure")

# Standard error divided by the mean below which it is rounding.
_ROUNDING = 1e-12


class Study(Computed):
    """Contacts of all surfaces, seeds and bodies of a study under all loads, with file, page and figures.

    Attributes:
        command: command of the contacts: "contact", "path" or "slide".
        dimensions: axis names of all numbers: surface, seed, body, then load, step or load and velocity.
        coordinates: a Record of the coordinates by dimension: surface and body names, seeds, loads.
        numbers: a Record of arrays [surface, seed, body, load] by name, as in `Contact`; NaN without a value. Lengths
            and stresses have the units `unit` and `stress_unit`.
        definitions: a Record of `units` and `long_name` of each number and each load, step or velocity.
        status: "solved" or "failed", an array of texts [surface, seed, body].
        error: reasons why contacts failed, an array of texts [surface, seed, body]; empty for the others.
        means: a Record for each surface, body and load: the coordinates, and `numbers` with `mean`, `standard_error`
            and `count` over the seeds.
        unit, stress_unit: units of length and stress, None if unknown.
        member_warnings: warnings of each contact, an array of texts [surface, seed, body].
        seconds: wall time.
        warnings: a Record for each warning of the study itself: `code`, `text`.

    Example:
        >>> many.numbers.area_fraction.shape, many.dimensions
        ((1, 3, 1, 2), ['surface', 'seed', 'body', 'load'])
    """

    command: str
    dimensions: list[str]
    coordinates: Record
    numbers: Record
    definitions: Record
    status: Array
    error: Array
    means: list[Record]
    unit: Optional[str]
    stress_unit: Optional[str]
    member_warnings: Array
    seconds: float
    warnings: list[Record]

    def _column(self, name: Any) -> Array:
        if name not in self.numbers:
            raise InputError(f"{shown(name)} is no number of the study; it must be one of {', '.join(self.numbers)}")
        found: Array = self.numbers[name]
        return found

    def to_xarray(self) -> Any:
        """Returns all numbers [surface, seed, body, load] as an xarray.Dataset, with `status` and `error`.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> many.to_xarray().area_fraction.mean("seed").dims
            ('surface', 'body', 'load')
        """
        described = {name: dict(words) for name, words in self.definitions.items()}
        numbers = {name: (self.dimensions, values, described[name]) for name, values in self.numbers.items()}
        members = {name: (self.dimensions[:3], self[name]) for name in ("status", "error")}
        axes = {name: (name, values, described.get(name, {})) for name, values in self.coordinates.items()}
        return _show.needed("xarray", "to_xarray").Dataset({**numbers, **members}, axes)

    def to_dataframe(self) -> Any:
        """Returns the numbers as a pandas.DataFrame with one row per surface, seed, body and load.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> len(many.to_dataframe())  # doctest: +SKIP
            6
        """
        places = np.meshgrid(*self.coordinates.values(), indexing="ij")
        columns = {name: values.ravel() for name, values in zip(self.dimensions, places)}
        columns.update({name: values.ravel() for name, values in self.numbers.items() if name not in columns})
        return _show.framed(columns, dict(zip(columns, columns)), self.units)

    def plot(self, y: str = "area_fraction", ax: Any = None) -> Any:
        """Draws the seed average of a number against load, step or velocity with matplotlib.

        Each surface and body has a curve with its standard error. Returns the axes.

        Args:
            y: name of an array in `numbers`.
            ax: axes to draw into; new ones by default.

        Raises:
            InputError: an unknown name. Error: matplotlib is not installed.

        Example:
            >>> ax = many.plot("mean_gap")
        """
        values, x = self._column(y), self.coordinates[self.dimensions[-1]]
        with np.errstate(all="ignore"):
            count = np.isfinite(values).sum(axis=1)
            mean = np.where(count > 0, np.nansum(values, axis=1) / count, np.nan)
            squares = np.nansum((values - mean[:, None]) ** 2, axis=1)
            error = np.where(count > 1, np.sqrt(squares / (count - 1) / count), 0.0)
        ax = _show.axes(ax)
        for place in np.ndindex(mean.shape[:-1]):
            names = [self.coordinates[name][k] for name, k in zip(["surface", *self.dimensions[2:]], place)]
            ax.errorbar(x, mean[place], error[place], marker="o", label=", ".join(map(str, names)))
        if len(x) > 1 and min(x) > 0 and max(x) > 10 * min(x):
            ax.set_xscale("log")
        units = self.definitions[y].units
        ax.set(xlabel=self.dimensions[-1], ylabel=y.replace("_", " ") + ("" if units == "1" else f" / ({units})"))
        ax.legend()
        return ax

    def __repr__(self) -> str:
        failed = int((self.status == "failed").sum())
        sizes = ", ".join(f"{len(values)} {name}" for name, values in self.coordinates.items())
        names = [name for name in _SHOWN if any(name in row.numbers for row in self.means)]

        def number(row: Record, name: str) -> str:
            found = row.numbers.get(name)
            if found is None:
                return "-"
            error = found.standard_error
            is_known = error is not None and error > _ROUNDING * abs(found.mean)
            return f"{found.mean:.5g}" + (f" +- {error:.1g}" if is_known else "")

        axes = ["surface", "body", *self.dimensions[3:]]
        columns = {name: [cut(str(row[name]), 20) for row in self.means] for name in axes}
        columns.update({name: [number(row, name) for row in self.means] for name in names})
        title = cut(f"Study of {self.command}: {sizes}; {self.status.size} members, {failed} failed")
        rest = cut(f"{len(self.numbers)} numbers: dict(r.numbers); the rest: dict(r)")
        return f"{title}{table(columns, LINES - 3)}\n  {rest}"


@taking(StudyOptions)
def study(
    config: Union[str, "os.PathLike[str]", Mapping[str, Any]], *, progress: bool = True, **options: Unpack[StudyOptions]
) -> Study:
    """Computes the contacts of all combinations of surfaces, seeds, bodies and loads of a study.

    Args:
        config: path of a TOML file, or a dict of its contents: `command` ("contact", "path" or "slide"), a dict of
            that name with options of the command, and `study` with lists `surface`, `seed` and `body`, whose product is
            computed (docs/studies.md).
        out: HDF5 file to write; nothing is written by default.
        resume: continue an interrupted study to `out`.
        progress: show a progress bar, according to `gfmd.progress`; False shows none.
        threads: number of threads; all cores by default.

    Raises:
        InputError: an invalid study; nothing was computed.
        NotConverged: contacts failed; `.state` is the Study with all others.
        Interrupted: finished contacts are kept in a journal next to `out`; `.state.out` is the file to resume to, in a
            new folder without `out`.

    Example:
        >>> many = gfmd.study({
        ...     "command": "contact",
        ...     "contact": {"n": 32, "eps_f_inv": 4, "p_star": [0.02, 0.1]},
        ...     "study": {"seed": "1:3"},
        ... })
        >>> [round(mean.numbers.area_fraction.mean, 2) for mean in many.means]
        [0.06, 0.25]
    """
    folder = tempfile.mkdtemp(prefix="gfmd-")
    file = os.path.join(folder, "study.h5")
    kept = None
    try:
        file = os.fspath(options.get("out") or file)
        described = given(config) if isinstance(config, Mapping) else {"config": path("config", config)}
        problem = {**described, "out": file, "resume": options.get("resume", False)}
        with hidden(not flag("progress", progress)):
            values, failure, *_ = _command.solve("study", problem, threads=options.get("threads"))
        return _command.ended(made_of(values, Contents(Path(file).read_bytes())), failure)
    except KeyboardInterrupt as error:
        if isinstance(error, Interrupted) and isinstance(error.state, Study):
            raise
        reported = str(error).split("; finished members are in ")[0] or "interrupted"
        if Path(f"{file}.journal").exists():
            kept = file
            reported += f"; finished members are kept: gfmd.study(..., out={kept!r}, resume=True) continues"
        raise Interrupted(reported, Record({"out": kept})) from error
    finally:
        if kept is None or "out" in options:
            shutil.rmtree(folder, ignore_errors=True)


def made_of(values: dict[str, Any], contents: Contents) -> Study:
    """Makes a study from the report of the command."""
    axes = values.pop("axes")
    members = [values.pop(name) for name in ("surface", "seed", "body")]
    coordinates = {name: frozen(np.array(found)) for name, found in zip(("surface", "seed", "body"), members)}
    about: dict[str, dict[str, str]] = {}
    for axis in axes:
        found = axis["values"]
        coordinates[axis["name"]] = frozen(np.arange(axis["length"]) if found is None else np.array(found, float))
        about[axis["name"]] = {"units": axis["units"], "long_name": axis["long_name"]}
    shape = [len(found) for found in coordinates.values()]
    numbers = {}
    for name, number in values.pop("numbers").items():
        numbers[name] = frozen(np.array(number["values"], float).reshape(shape))
        about[name] = {key: number[key] for key in ("units", "long_name")}
    texts = {
        name: frozen(np.array(values.pop(name), object).reshape(shape[:3]))
        for name in ("status", "error", "member_warnings")
    }
    return Study(
        {
            "command": values["command"],
            "dimensions": list(coordinates),
            "coordinates": Record(coordinates),
            "numbers": Record(numbers),
            "definitions": Record({name: Record(words) for name, words in about.items()}),
            **texts,
            "means": _command.records(values["means"]),
            "unit": values.get("unit"),
            "stress_unit": values.get("stress_unit"),
            "seconds": values["seconds"],
            "warnings": _command.records(values["warnings"]),
        },
        contents,
    )
