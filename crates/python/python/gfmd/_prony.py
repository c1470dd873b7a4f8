"""Prony series from storage and loss moduli."""

from __future__ import annotations

import json
import os
import tempfile
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _check, _command, _gfmd, _show
from ._check import numbers, shown
from ._errors import InputError
from ._given import taking
from ._measured import Measured
from ._options_inside import PronyOptions
from ._record import Record, json_of
from ._units import Units

if TYPE_CHECKING:
    from typing_extensions import Unpack


class PronyFit(Measured):
    """A Prony series fitted to measured moduli.

    Attributes:
        young_long_term: fully relaxed Young's modulus, stress.
        young_long_term_error: its standard error, stress; NaN if the modulus was given, or without spare data.
        young_instantaneous: instantaneous Young's modulus, stress.
        prony: pairs of relaxation time, s, and fraction of the instantaneous modulus.
        branches: a Record for each branch: `time`, s, `modulus` and its standard error `modulus_error`, stress (None
            without spare data), `fraction`.
        storage_misfit, loss_misfit: rms relative misfits of storage and loss modulus.
        options: program options for a body with this series.
        tried: a Record for each series tried: number of `branches`, and `misfit` of both moduli.
        points: a Record for each measured point: `frequency`, Hz, shifted by `log_a_t`, `storage`, `loss`,
            `fitted_storage`, `fitted_loss`, stress, and `temperature`, if any.
        stress_unit: unit of the moduli, if any.
        reference_temperature: reference temperature T0 of the shift, with `wlf` only.
        warnings: a Record for each warning of the fit: `code`, `text`.

    Example:
        >>> fit = gfmd.prony(frequency=[0.1, 1, 10], storage=[2.0, 2.5, 3.0], loss=[0.1, 0.5, 0.1], branches=1)
        >>> len(fit.branches)
        1
    """

    young_long_term: float
    young_long_term_error: float
    young_instantaneous: float
    prony: list[list[float]]
    branches: list[Record]
    storage_misfit: float
    loss_misfit: float
    options: str
    tried: list[Record]
    points: list[Record]
    stress_unit: str
    reference_temperature: float
    warnings: list[Record]
    _main = ("young_long_term", "young_instantaneous", "prony", "storage_misfit", "loss_misfit", "options")

    @property
    def units(self) -> Units:
        """Length unit, which is None, and stress unit of all numbers, None if unknown."""
        return None, self.get("stress_unit")

    @property
    def series(self) -> list[tuple[float, float]]:
        """Series for `prony` of a body, pairs of relaxation time, s, and fraction without unit.

        Example:
            >>> fit = gfmd.prony(frequency=[0.1, 1, 10], storage=[2.0, 2.5, 3.0], loss=[0.1, 0.5, 0.1], branches=1)
            >>> gfmd.Body(prony=fit, poisson=0.5) == gfmd.Body(young=fit.young, poisson=0.5, prony=fit.series)
            True
        """
        return [(time, fraction) for time, fraction in self.prony]

    @property
    def young(self) -> Union[float, str]:
        """Fully relaxed Young's modulus for `young` of a body, stress, a text with its unit or a number without one.

        Example:
            >>> curves = dict(frequency=[0.1, 1, 10], storage=[2.0, 2.5, 3.0], loss=[0.1, 0.5, 0.1])
            >>> gfmd.prony(**curves, branches=1, long_term=1.5, stress_unit="MPa").young
            '1.5 MPa'
        """
        unit = self.get("stress_unit")
        return self.young_long_term if unit is None else f"{self.young_long_term!r} {unit}"

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the JSON that `gfmd prony --json` prints, for `gfmd.load`.

        Args:
            path: file name.

        Raises:
            InputError: a file that cannot be written. An existing file is then kept.

        Example:
            >>> fit = gfmd.prony(frequency=[0.1, 1, 10], storage=[2.0, 2.5, 3.0], loss=[0.1, 0.5, 0.1], branches=1)
            >>> fit.save("fit.json")
            >>> gfmd.load("fit.json") == fit
            True
        """
        _gfmd.write_file(_check.path("path", path), (json_of(self) + "\n").encode())

    def to_dataframe(self) -> Any:
        """Returns the branches as a pandas.DataFrame with one row per branch; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> fit = gfmd.prony(frequency=[0.1, 1, 10], storage=[2.0, 2.5, 3.0], loss=[0.1, 0.5, 0.1], branches=1)
            >>> len(fit.to_dataframe())  # doctest: +SKIP
            1
        """
        names = ("time", "modulus", "modulus_error", "fraction")
        columns = {name: np.array([branch[name] for branch in self.branches], dtype=np.float64) for name in names}
        made = _show.needed("pandas", "to_dataframe").DataFrame(columns)
        unit = self.get("stress_unit")
        stress = {} if unit is None else {"modulus": unit, "modulus_error": unit}
        made.attrs["units"] = {"time": "s", **stress, "fraction": "1"}
        return made

    def plot(self, ax: Any = None) -> Any:
        """Draws measured and fitted moduli against frequency with matplotlib. Returns the axes.

        Args:
            ax: axes to draw into; new ones by default.

        Raises:
            Error: matplotlib is not installed.

        Example:
            >>> fit = gfmd.prony(frequency=[0.1, 1, 10], storage=[2.0, 2.5, 3.0], loss=[0.1, 0.5, 0.1], branches=1)
            >>> ax = fit.plot()
        """
        ax = _show.axes(ax)
        measured = np.array([point.frequency for point in self.points])
        frequency = np.geomspace(measured.min() / 10, measured.max() * 10, 300)
        y = 2j * np.pi * frequency[:, np.newaxis] * [branch.time for branch in self.branches]
        fitted = self.young_long_term + y / (1 + y) @ [branch.modulus for branch in self.branches]
        for name, color, values in (("storage", "C0", fitted.real), ("loss", "C1", fitted.imag)):
            ax.plot(measured, [point[name] for point in self.points], "o", ms=4, color=color, label=name)
            ax.plot(frequency, values, color=color, label=f"{name}, fit")
        ax.set_xscale("log")
        ax.set_yscale("log")
        is_shifted = any(point.log_a_t != 0.0 for point in self.points)
        ax.set_xlabel("reduced frequency / Hz" if is_shifted else "frequency / Hz")
        unit = self.get("stress_unit")
        ax.set_ylabel("modulus" if unit is None else f"modulus / {unit}")
        ax.legend()
        return ax


def _table(columns: dict[str, Any]) -> str:
    """Returns a table of columns of equal length, with all digits."""
    found = {name: numbers(name, values) for name, values in columns.items() if values is not None}
    for name in ("frequency", "storage", "loss"):
        if name not in found:
            raise InputError(f"{name} is missing; it is needed without the file dma")
    count = len(found["frequency"])
    for name, values in found.items():
        if len(values) != count:
            raise InputError(f"{name} has {len(values)} numbers; it must have as many as frequency, {count}")
    rows = (",".join(map(repr, row)) for row in zip(*found.values()))
    return "\n".join([",".join(found), *rows, ""])


@taking(PronyOptions)
def prony(
    dma: Union[str, os.PathLike[str], None] = None,
    *,
    frequency: Optional[npt.ArrayLike] = None,
    storage: Optional[npt.ArrayLike] = None,
    loss: Optional[npt.ArrayLike] = None,
    temperature: Optional[npt.ArrayLike] = None,
    log_a_t: Optional[npt.ArrayLike] = None,
    **options: Unpack[PronyOptions],
) -> PronyFit:
    """Fits a Prony series to storage and loss moduli, as `gfmd prony` does.

    Args:
        dma: file with the columns frequency, storage and loss, and temperature or log_a_t; or the columns as arrays:
        frequency, storage, loss: frequencies, Hz, and moduli, stress.
        temperature: temperature of each point, with `wlf`.
        log_a_t: decimal logarithm of the shift factor of each point.
        wlf: C1, C2 and reference temperature T0 of the Williams-Landel-Ferry equation, in the temperature unit.
        stress_unit: unit of moduli without one.
        branches: number of relaxation times; by default the fewest that fit well.
        times: relaxation times, s.
        long_term: fully relaxed modulus from another test, stress; fitted by default.

    Raises:
        InputError: data or arguments that give no series.

    Example:
        >>> omega = 2 * np.pi * np.geomspace(0.01, 10, 31)
        >>> moduli = 3 + 60 * 1j * omega / (1 + 1j * omega)
        >>> fit = gfmd.prony(frequency=omega / 2 / np.pi, storage=moduli.real, loss=moduli.imag, times=[1.0])
        >>> round(fit.young, 6), [(time, round(fraction, 6)) for time, fraction in fit.series]
        (3.0, [(1.0, 0.952381)])
    """
    columns = dict(frequency=frequency, storage=storage, loss=loss, temperature=temperature, log_a_t=log_a_t)
    given = [name for name, values in columns.items() if values is not None]
    if dma is not None and given:
        raise InputError(f"{given[0]} is given beside the file {shown(dma)}; give one of the two")
    problem = {name: numbers(name, value) if name in ("wlf", "times") else value for name, value in options.items()}
    if dma is not None:
        return _fitted(_check.path("dma", dma), problem)
    table = _table(columns)
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "arrays.csv")
        with open(file, "w", encoding="utf-8") as stream:
            stream.write(table)
        try:
            return _fitted(file, problem)
        except InputError as error:
            # A line of the table is the row above it.
            text = str(error).replace(f"dma: {file}: ", "the arrays: ").replace(file, "the arrays")
            raise InputError(text) from None


def _fitted(file: str, problem: dict[str, Any]) -> PronyFit:
    values, *_ = _command.solve("prony", dict(problem, dma=file))
    return _made_of(values)


def _made_of(values: dict[str, Any]) -> PronyFit:
    """Returns the fit in a report of the program."""
    values = {name: value for name, value in values.items() if name not in ("dma", "plots")}
    if values["young_long_term_error"] is None:
        values["young_long_term_error"] = float("nan")
    found = {name: _command.records(value) for name, value in values.items()}
    return PronyFit(found, (None, values.get("stress_unit")))


# Keys that every report has, and the types of their values.
_KEYS: dict[str, Any] = {
    "young_long_term": float,
    "young_long_term_error": (float, type(None)),
    "young_instantaneous": float,
    "prony": list,
    "branches": list,
    "storage_misfit": float,
    "loss_misfit": float,
    "options": str,
    "tried": list,
    "points": list,
    "warnings": list,
}


def _is_branch(given: Any) -> bool:
    return isinstance(given, list) and len(given) == 2 and all(isinstance(value, float) for value in given)


def loaded(name: str) -> PronyFit:
    """Reads a fit from a file of JSON."""
    try:
        with open(name, encoding="utf-8") as stream:
            values = json.load(stream)
    except ValueError as error:
        raise InputError(f"{name}: it is no JSON: {error}") from None
    wrong = [key for key, kind in _KEYS.items() if not isinstance(values.get(key, _KEYS), kind)]
    if "prony" not in wrong and not all(_is_branch(branch) for branch in values["prony"]):
        wrong.insert(0, "prony")
    if wrong:
        raise InputError(f"{name}: it has no {wrong[0]} of a Prony series; gfmd prony --json and save write it")
    return _made_of(values)
