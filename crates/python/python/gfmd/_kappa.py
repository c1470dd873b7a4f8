"""Kappa sweeps."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from . import _command, _show
from ._check import path
from ._errors import InputError, Interrupted, NotConverged
from ._given import taking
from ._options_inside import SweepOptions
from ._record import LINES, Record, table
from ._result import Computed, Contents
from ._units import attributes

if TYPE_CHECKING:
    from typing_extensions import Unpack


class KappaSweep(Computed):
    """A kappa sweep, with the file, page and figures of `gfmd report kappa.h5`.

    Sweeps are equal if all their numbers except the times are equal.

    Attributes:
        points: a Record for each discretisation and load: `dim`, `hurst`, `eps_t_inv`, `eps_f_inv`, `eps_c_inv`, `n`,
            `p_star`, `realisations`, `kappa`, `kappa_sem`, `kappa_corrected`, `kappa_corrected_sem`; all dimensionless.
        fit: extrapolation: `kappa_tfc`, `ci95` (statistical), `total_ci95` (with the fit form error), `terms`
            (`axis`, `coefficient`, `exponent` ...) and so on.
        fits: fits for all Hurst exponents, loads and area counts.
        theory: theoretical limits: `persson`, `bush_gibson_thomas`.
        seconds: wall time.
        warnings: a Record for each warning of the computation: `code`, `text`.

    Example:
        >>> k.points[0].kappa > k.theory.persson
        True
    """

    points: list[Record]
    fit: Record
    fits: list[Record]
    theory: Record
    seconds: float
    warnings: list[Record]

    def to_xarray(self) -> Any:
        """Returns the points [point] as an xarray.Dataset.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> k.to_xarray().kappa.dims
            ('point',)
        """
        columns = {name: ("point", values, attributes(name, self.units)) for name, values in self._columns().items()}
        point = {"point": ("point", np.arange(len(self.points)), {"long_name": "discretisation and load"})}
        return _show.needed("xarray", "to_xarray").Dataset(columns, point)

    def to_dataframe(self) -> Any:
        """Returns the points as a pandas.DataFrame with one row per discretisation and load; all dimensionless.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> k.to_dataframe().kappa.shape == (len(k.points),)  # doctest: +SKIP
            True
        """
        columns = self._columns()
        return _show.framed(columns, dict(zip(columns, columns)), self.units)

    def _columns(self) -> dict[str, list[Any]]:
        """Returns the point numbers by name, with NaN in place of None."""
        names = dict.fromkeys(name for point in self.points for name in point)
        return {name: [np.nan if point.get(name) is None else point[name] for point in self.points] for name in names}

    def plot(self, ax: Any = None) -> Any:
        """Draws kappa at the load of the fit against points per side, and its limit, with matplotlib. Returns the axes.

        Args:
            ax: axes to draw into; new ones by default.

        Raises:
            Error: matplotlib is not installed.

        Example:
            >>> ax = k.plot()
        """
        return _show.kappa(self.points, self.fit, ax)

    def __repr__(self) -> str:
        def number(value: Any) -> str:
            return "-" if value is None else f"{value:.4f}"

        columns = {
            "H": [f"{p.hurst:g}" for p in self.points],
            "1/eps_t": [f"{p.eps_t_inv:g}" for p in self.points],
            "1/eps_f": [f"{p.eps_f_inv:g}" for p in self.points],
            "1/eps_c": [f"{p.eps_c_inv:g}" for p in self.points],
            "n": [f"{p.n}" for p in self.points],
            "p_star": [f"{p.p_star:g}" for p in self.points],
            "kappa": [number(p.kappa) for p in self.points],
            "+-": [number(p.kappa_sem) for p in self.points],
        }
        total = self.fit.total_ci95
        interval = "" if total is None else " (95 %, with the error of the form: {:.4f} to {:.4f})".format(*total)
        head = f"KappaSweep of {len(self.points)} points{table(columns, LINES - 3)}"
        return f"{head}\nkappa_tfc = {self.fit.kappa_tfc:.4f}{interval}"


@taking(SweepOptions)
def kappa_sweep(
    config: Union[str, "os.PathLike[str]", Mapping[str, Any]] = "default", **options: Unpack[SweepOptions]
) -> KappaSweep:
    """Extrapolates kappa from many contacts to the thermodynamic, fractal and continuum limit, with uncertainty.

    Args:
        config: preset name ("smoke", "default" ...), path of a TOML file, or a dict of its contents.
            Moduli of the body may be strings with a unit ("70GPa"); all other values are dimensionless ratios.
        out: HDF5 file to write, with figures next to it; nothing is written by default.
        resume: continue an interrupted sweep to `out`.
        threads: number of threads; all cores by default.

    Raises:
        InputError: an invalid configuration; nothing was computed.
        NotConverged: a contact of the sweep did not converge.
        Interrupted: finished runs are kept in a journal next to `out`; `.state.out` is the file to resume to, in a new
            folder without `out`, and `.state.runs` the number of finished runs.

    Example:
        >>> k = gfmd.kappa_sweep("smoke")
        >>> round(k.fit.kappa_tfc, 2), len(k.fit.ci95)
        (1.86, 2)
    """
    folder = tempfile.mkdtemp(prefix="gfmd-")
    file = os.path.join(folder, "kappa.h5")
    kept = None
    try:
        file = os.fspath(options.get("out") or file)
        problem = {**given(config), "out": file, "resume": options.get("resume", False)}
        values, failure, *_ = _command.solve("kappa-sweep", problem, threads=options.get("threads"))
        return _command.ended(made_of(values, Contents(Path(file).read_bytes())), failure)
    except (KeyboardInterrupt, NotConverged) as error:
        if isinstance(getattr(error, "state", None), KappaSweep):
            raise
        journal = Path(f"{file}.journal")
        runs = max(len(journal.read_text().splitlines()) - 1, 0) if journal.exists() else 0
        kept = file if runs else None
        reported = str(error).split("; finished runs are in ")[0] or "interrupted"
        if runs:
            reported += f"; {runs} finished runs are kept: gfmd.kappa_sweep(..., out={kept!r}, resume=True) continues"
        kind = NotConverged if isinstance(error, NotConverged) else Interrupted
        raise kind(reported, Record({"out": kept, "runs": runs})) from error
    finally:
        if kept is None or "out" in options:
            shutil.rmtree(folder, ignore_errors=True)


def made_of(values: dict[str, Any], contents: Contents) -> KappaSweep:
    """Makes a sweep from the report of the command and the file."""
    return KappaSweep({name: _command.records(value) for name, value in values.items()}, contents)


def given(config: Any) -> dict[str, Any]:
    """Returns the keys of a configuration."""
    if isinstance(config, Mapping):
        try:
            return {"config": json.loads(json.dumps(dict(config), default=_plain))}
        except (TypeError, ValueError, RecursionError) as error:
            raise InputError(f"config has a value that TOML has not: {error}") from error
    if isinstance(config, str) and not config.endswith(".toml"):
        return {"preset": config}
    return {"config": path("config", config)}


def _plain(value: Any) -> Any:
    """Converts NumPy numbers and arrays to Python numbers and lists."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__}")
