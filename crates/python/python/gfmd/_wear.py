"""Surfaces that wear as they slide."""

from __future__ import annotations

import os
from typing import Any, Literal, Optional

import numpy.typing as npt

from . import _command, _show
from ._body import Body, as_body
from ._check import Quantity, flag, integer, number, quantities, quantity, word
from ._columns import Steps, WearFields
from ._hints import hinted
from ._leak import Leaks
from ._load import Residual, residual_of
from ._path import drive_keys, gathered
from ._record import Record
from ._result import Computed
from ._surface import Surface, as_surface


class WearPath(Leaks, Computed, WearFields):
    """A surface that slides on an elastic body while both wear by Archard's law.

    Attributes:
        steps: numbers of the steps, a `Record` of arrays [step]. Fields are given at the ends of the legs; NaN at legs
            that were not reached.
        coefficient: wear depth per sliding distance, divided by the pressure, 1/stress.
        dissipated: work of the pressure on the wear depth along the path, per area, stress * length.
        dissipated_error: None, unless the sliding distance is zero; compare with halved steps instead.
        work_imbalance: sum of the imbalances of work and energy of the steps, stress * length.
        wear_volume: mean wear depth at the end, length.
        grid_error: how the grid error was found: `mode`, `n`, `assumes`, `orders`.
        undefined: reasons why arrays of `steps` are NaN at some steps, by name.
        warnings: a Record for each warning of the computation: `code`, `text`.
        surface, n, size, unit, rms_gradient, rms_height, e_star, law: parameters of the problem.

    Example:
        >>> surface = gfmd.self_affine(n=32, eps_f_inv=4)
        >>> worn = gfmd.wear(surface, gfmd.Body(), coefficient=1.0, distance=[0, 0.1, 1.0], p_star=0.05, steps=2)
        >>> worn.steps.distance.shape, worn.wear_depth.shape
        ((5,), (3, 32, 32))
    """

    steps: Steps
    coefficient: float
    dissipated: Optional[float]
    dissipated_error: Optional[float]
    work_imbalance: Optional[float]
    wear_volume: Optional[float]
    grid_error: Record
    surface: Surface
    n: list[int]
    size: list[float]
    unit: Optional[str]
    rms_gradient: float
    rms_height: float
    e_star: float
    law: str
    undefined: dict[str, str]
    warnings: list[Record]

    @property
    def residual(self) -> Residual:
        """The parts of the residual by name, arrays [step], without unit; `residual.largest` is the largest part."""
        return residual_of(self.steps)

    def __repr__(self) -> str:
        names = ("distance", "mean_pressure", "p_star", "area_fraction", "mean_gap", "wear_volume")
        return self._answer("steps", names, ("coefficient", "wear_volume", "dissipated"))

    def to_dataframe(self) -> Any:
        """Returns the numbers of the steps as a pandas.DataFrame with a row for each step; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> worn.to_dataframe().shape[0]  # doctest: +SKIP
            5
        """
        return _show.table_frame(self, self.steps)

    def plot(self, x: str = "distance", y: str = "area_fraction", ax: Any = None) -> Any:
        """Draws one scalar of the steps against another with matplotlib. Returns the axes.

        Args:
            x, y: names of arrays in `steps`.
            ax: the axes to draw into; new ones by default.

        Raises:
            InputError: an unknown name. Error: matplotlib is not installed.

        Example:
            >>> surface = gfmd.self_affine(n=32, eps_f_inv=4)
            >>> worn = gfmd.wear(surface, gfmd.Body(), coefficient=1.0, distance=1.0, p_star=0.05, steps=2)
            >>> ax = worn.plot("distance", "wear_volume")
        """
        return _show.steps(self, (x, y), ax)

    def to_xarray(self) -> Any:
        """Returns an xarray.Dataset of the scalars [step] and the fields [waypoint, y, x].

        Raises:
            Error: xarray is not installed.

        Example:
            >>> surface = gfmd.self_affine(n=32, eps_f_inv=4)
            >>> worn = gfmd.wear(surface, gfmd.Body(), coefficient=1.0, distance=1.0, p_star=0.05, steps=2)
            >>> worn.to_xarray().wear_depth.dims
            ('waypoint', 'y', 'x')
        """
        return _show.table_dataset(self, self.steps, "step", "waypoint")


@hinted
def wear(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    coefficient: Quantity,
    distance: Any,
    pressure: Any = None,
    p_star: Any = None,
    approach: Any = None,
    boundary: Literal["periodic", "free"] | str = "periodic",
    stress_unit: Optional[str] = None,
    grid_error: str = "estimate",
    flow: bool = False,
    steps: int = 20,
    tolerance: float = 1e-8,
    max_iterations: int = 100_000,
    threads: Optional[int] = None,
    out: str | os.PathLike[str] | None = None,
) -> WearPath:
    """Computes the wear of a surface that slides on an elastic body, by Archard's law: running-in, shape, volume.

    `path` has wear together with friction, a law, a hardness or a viscoelastic body.

    Args:
        surface, body: as in `contact`.
        coefficient: wear coefficient of both surfaces together, divided by the hardness, 1/stress: wear depth per
            sliding distance and pressure. It may be a string with a unit, such as "1e-15 1/Pa" or "1e-6 mm^3/N/m", if
            the surface has one.
        distance: sliding distances of the legs, length: a number or a sequence. Each leg ends at a waypoint. The first
            leg begins at first touch; a leg of zero distance is one step.
        pressure, p_star, approach: waypoints of one of the three (stress, 1, length), a number or a sequence,
            positive; as in `path`.
        boundary: "periodic", or "free" as in `contact`.
        stress_unit: unit of stresses given without one, as in `contact`.
        grid_error: as in `path`.
        flow: as in `path`.
        steps: number of steps of a leg.
        tolerance, max_iterations: limits for each step, as in `contact`.
        threads: number of threads; all cores by default.
        out: HDF5 file to write, as with `gfmd wear --out`. Unlike in `save`, its name is checked before the first step.

    Raises:
        InputError: invalid arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the WearPath so far.

    Example:
        >>> surface = gfmd.self_affine(n=32, eps_f_inv=4)
        >>> worn = gfmd.wear(surface, gfmd.Body(), coefficient=1.0, distance=[0, 100.0], p_star=0.05, steps=20)
        >>> float(worn.steps.area_fraction[0]) < 0.2, float(worn.steps.area_fraction[-1])
        (True, 1.0)
    """
    made, elastic = as_surface(surface), as_body(body)
    problem: dict[str, Any] = dict(
        unit=made.unit,
        stress_unit=None if stress_unit is None else word("stress_unit", stress_unit),
        coefficient=quantity("coefficient", coefficient, "1/stress"),
        distance=quantities("distance", distance, "length"),
        boundary=word("boundary", boundary),
        grid_error=word("grid_error", grid_error),
        flow=flag("flow", flow),
        steps=integer("steps", steps, 1, 2**32 - 1),
        tolerance=number("tolerance", tolerance),
        max_iterations=integer("max_iterations", max_iterations),
        size=list(made.size),
        **drive_keys("the path is", {"pressure": pressure, "p_star": p_star, "approach": approach}),
        **_command.body_keys(elastic),
    )
    values, failure, fields, file = _command.solve("wear", problem, {"surface": made.heights}, threads, out, made)
    return _command.ended(WearPath({**gathered(values), "unit": made.unit, "surface": made, **fields}, file), failure)
