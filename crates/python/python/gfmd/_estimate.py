"""Estimates of contacts from the surface's spectrum and highest points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np
import numpy.typing as npt

from . import _command, _show
from ._body import Body, as_body
from ._check import Array, frozen, quantities
from ._errors import InputError
from ._given import taking
from ._measured import Measured
from ._options_inside import EstimateOptions
from ._record import LINES, Record, reason_of, table
from ._surface import Surface, as_surface
from ._units import Units

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Estimate(Measured):
    """Numbers of contacts estimated from the surface's spectrum and highest points.

    Each has an error: 95 % of solved contacts deviate by less. An unknown estimate is NaN.

    Attributes:
        p_star, mean_pressure: loads [load], dimensionless and stress.
        area_fraction, area_fraction_error: contact area fraction [load], dimensionless.
        mean_gap, mean_gap_error: mean gap [load], length.
        stiffness, stiffness_error: slope of mean pressure against approach [load], stress/length.
        rms_pressure, rms_pressure_error: rms pressure at points in contact [load], stress.
        max_pressure, max_pressure_error: largest pressure [load], stress.
        percolation_distance, percolation_distance_error: area fraction at percolation minus area fraction [load].
        percolation_area_fraction, percolation_area_fraction_error: area fraction at which contacts percolate.
        measured: surfaces whose computed contacts give the errors; absent if none is like this surface.
        plasticity_index: E* times the rms gradient, divided by the hardness; with `hardness` only.
        hurst, eps_f_inv: Hurst exponent and wavelength ratio of the closest self-affine spectrum; NaN if there is none.
        rms_height, rms_gradient, e_star: rms height, length, rms gradient, dimensionless, and contact modulus, stress.
        undefined: reasons why numbers are NaN, by name; present only if there are any.
        unit, stress_unit: units of lengths and stresses, if known.
        warnings: a Record for each warning: `code`, `text`.

    Example:
        >>> e = gfmd.estimate(gfmd.self_affine(n=256, hurst=0.8), gfmd.Body(), p_star=[0.01, 0.1])
        >>> bool(abs(e.area_fraction[1] / 0.19 - 1) < 0.1), e.mean_gap.shape
        (True, (2,))
    """

    p_star: Array
    mean_pressure: Array
    area_fraction: Array
    area_fraction_error: Array
    mean_gap: Array
    mean_gap_error: Array
    stiffness: Array
    stiffness_error: Array
    rms_pressure: Array
    rms_pressure_error: Array
    max_pressure: Array
    max_pressure_error: Array
    percolation_distance: Array
    percolation_distance_error: Array
    percolation_area_fraction: float
    percolation_area_fraction_error: float
    measured: str
    plasticity_index: float
    hurst: float
    eps_f_inv: float
    rms_height: float
    rms_gradient: float
    e_star: float
    undefined: dict[str, str]
    unit: str
    stress_unit: str
    warnings: list[Record]

    @property
    def units(self) -> Units:
        """Length unit and stress unit of all numbers, None if unknown."""
        return self.get("unit"), self.get("stress_unit")

    def reason(self, name: str) -> Optional[str]:
        """Returns why a number is NaN, at the last load where it is; None if it has values.

        Args:
            name: name of a number.

        Raises:
            InputError: no such number.

        Example:
            >>> e = gfmd.estimate(gfmd.self_affine(n=64, hurst=0.8), gfmd.Body(), p_star=[0.1, 9.0])
            >>> e.reason("area_fraction"), e.reason("p_star")
            ('the errors are known from p* = 0.0001 to 1', None)
        """
        return reason_of(self, name)

    def _at_loads(self) -> Record:
        """Returns the arrays [load] by name."""
        return Record({name: value for name, value in self.items() if isinstance(value, np.ndarray)})

    def to_dataframe(self) -> Any:
        """Returns the numbers as a pandas.DataFrame with one row per load; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> e = gfmd.estimate(gfmd.self_affine(n=64, hurst=0.8), gfmd.Body(), p_star=[0.01, 0.1])
            >>> len(e.to_dataframe())  # doctest: +SKIP
            2
        """
        return _show.table_frame(self, self._at_loads())

    def to_xarray(self) -> Any:
        """Returns the numbers [load] as an xarray.Dataset.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> e = gfmd.estimate(gfmd.self_affine(n=64, hurst=0.8), gfmd.Body(), p_star=[0.01, 0.1])
            >>> e.to_xarray().area_fraction.dims
            ('load',)
        """
        columns = {name: ("load", values, _show.described(self, name)) for name, values in self._at_loads().items()}
        loads = ("load", np.arange(len(self.p_star)), {"long_name": "load step"})
        return _show.needed("xarray", "to_xarray").Dataset(columns, {"load": loads})

    def plot(self, y: str = "area_fraction", ax: Any = None) -> Any:
        """Draws a number with its error against the mean pressure with matplotlib. Returns the axes.

        Args:
            y: name of an array [load].
            ax: axes to draw into; new ones by default.

        Raises:
            InputError: an unknown name. Error: matplotlib is not installed.

        Example:
            >>> e = gfmd.estimate(gfmd.self_affine(n=64, hurst=0.8), gfmd.Body(), p_star=[0.01, 0.1])
            >>> ax = e.plot("mean_gap")
        """
        table = self._at_loads()
        name, values = _show.column(table, y)
        along, x_label = _show.caption("mean_pressure", self.mean_pressure, self.units)
        factor, y_label = _show.caption(name, values, self.units)
        error = table.get(f"{name}_error", np.zeros(len(values)))
        ax = _show.axes(ax)
        ax.errorbar(self.mean_pressure * along, values * factor, error * factor, fmt="o-", ms=4, capsize=2)
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
        return ax

    def __repr__(self) -> str:
        names = ("p_star", "mean_pressure", "area_fraction", "mean_gap", "stiffness", "rms_pressure", "max_pressure")
        columns = {}
        for name in names:
            errors = self.get(f"{name}_error")
            cells = [f"{value:.4g}" for value in self[name]]
            if errors is not None:
                cells = [f"{cell} ± {error:.1g}" for cell, error in zip(cells, errors)]
            columns[name] = cells
        return f"Estimate of {len(self.p_star)} contacts{table(columns, LINES - 1)}"


@taking(EstimateOptions)
def estimate(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    pressure: Any = None,
    p_star: Any = None,
    force: Any = None,
    **options: Unpack[EstimateOptions],
) -> Estimate:
    """Estimates contacts from the surface's spectrum and highest points, without a solution, as `gfmd estimate` does.

    Args:
        surface: as in `contact`; periodic, not a profile.
        body: an elastic half-space.
        pressure, p_star, force: loads by one of the three, a number or a sequence (stress, 1, stress * length^2), or
            strings with a unit, such as "10MPa", if the surface has one; by default reduced pressures from 0.001 to 1.
        hardness: largest pressure, stress, for the plasticity index.
        stress_unit: unit of stresses given without one, as in `contact`.

    Raises:
        InputError: invalid arguments, a profile, a flat surface, or a body that is not a half-space.

    Example:
        >>> scan = gfmd.self_affine(n=128, hurst=0.8, size="50 um", unit="um")
        >>> e = gfmd.estimate(scan, gfmd.Body(young="70 GPa"), pressure="10 MPa", hardness="1 GPa")
        >>> round(e.plasticity_index, 2), bool(e.area_fraction_error[0] < e.area_fraction[0])
        (7.0, True)
    """
    made, elastic = as_surface(surface), as_body(body, of_moduli=True)
    loads = {"pressure": pressure, "p_star": p_star, "force": force}
    given = {name: quantities(name, value) for name, value in loads.items() if value is not None}
    if len(given) > 1:
        raise InputError(f"the load is given by {', '.join(given)}; it must be given by one of pressure, p_star, force")
    problem = dict(unit=made.unit, size=list(made.size), **given, **_command.body_keys(elastic), **options)
    values, *_ = _command.solve("estimate", problem, {"surface": made.heights})
    rows = values.pop("loads")
    undefined = {name: reason for row in rows for reason, names in row.pop("undefined", {}).items() for name in names}
    columns = {name: [np.nan if row[name] is None else row[name] for row in rows] for name in rows[0]}
    values = {name: value for name, value in values.items() if name not in _OF_SURFACE}
    kept = {name: np.nan if value is None else _command.records(value) for name, value in values.items()}
    found = {**kept, **{name: frozen(np.array(column)) for name, column in columns.items()}}
    return Estimate({**found, "undefined": undefined} if undefined else found, (made.unit, values.get("stress_unit")))


# Keys of the report that the surface has.
_OF_SURFACE = ("n", "size", "surface")
