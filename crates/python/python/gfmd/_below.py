"""Flat punches, fields below a surface, and the elasticity of one wave vector."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _command
from ._body import Body, as_body
from ._check import Array, Quantity, array, flag, integer, number, numbers, quantity, shown, texts, word
from ._check import quantities as lengths
from ._columns import PunchNumbers
from ._contact import Contact
from ._errors import InputError
from ._hints import hinted
from ._files import config
from ._record import Record
from ._result import Computed

_QUANTITIES = ("displacement", "strain", "stress", "von-mises", "energy-density")


class Punch(Computed, PunchNumbers):
    """A flat punch on a body. `components` are x, y, z (x, z of a strip).

    Attributes:
        displacement, traction: on the elastic surface [x, y, component], length and stress; a strip has
            [x, 1, component].
        under_punch: 1 under the punch, else 0 [x, y].
        height: of the body, length; infinite for a half-space.
        n, length, young, poisson, contact, nodes, dim, components: the problem.
        warnings: a Record for each warning of the computation: `code`, `text`.
        refinement: `n`, `mean_pressure`, `order`, `extrapolated`, `uncertainty`, with refine= only.
        history: every step, with history= only: arrays `iteration`, `residual`, `energy`, and `modes` and `points` if
            asked for, each a Record with `mode` or `point`, `component`, and `re` and `im` (length) or `u` (length).

    Example:
        >>> punch.displacement.shape, punch.components
        ((32, 32, 3), ['x', 'y', 'z'])
    """

    displacement: Array
    traction: Array
    under_punch: Array
    height: float
    n: list[int]
    length: list[float]
    young: float
    poisson: float
    contact: str
    nodes: str
    dim: int
    components: list[str]
    warnings: list[Record]

    def interior(self, depths: Optional[Sequence[float]] = None, **options: Any) -> FieldsBelow:
        """Returns displacement, strain and stress below the punch; see `gfmd.interior`.

        Args:
            depths: depths below the surface, length.
            options: the rest as of `gfmd.interior`.

        Raises:
            InputError: as `gfmd.interior`.

        Example:
            >>> punch.interior(depths=[0.1]).stress.shape
            (1, 32, 32, 6)
        """
        return interior(self, depths, **options)


class FieldsBelow(Computed):
    """Fields below a surface, those that were asked for.

    Attributes:
        displacement: [depth, x, y, component], length.
        strain, stress: [depth, x, y, tensor] with xx, yy, zz, yz, xz, xy (xx, yy, zz, xz below a line); engineering
            shear strains; stress.
        von_mises: [depth, x, y], stress.
        energy_density: [depth, x, y], stress.
        levels: a Record for each depth: `depth`, `max_displacement`, `max_von_mises`, `mean_energy_density`.
        mean_traction: by component, stress: the mean of xz, yz, zz (xz, zz below a line) on the surface and at every
            depth.
        n, length: points and lengths along x and y.
        warnings: a Record for each warning of the computation: `code`, `text`.

    If the surface of the contact has units, `unit` and `stress_unit` are their names. On a slice (along=), the axis
    across it is missing; below a line, y is.

    Example:
        >>> gfmd.interior(punch, depths=[0.0, 0.1], along="y=0.5", quantities=["von-mises"]).von_mises.shape
        (2, 32)
    """

    displacement: Array
    strain: Array
    stress: Array
    von_mises: Array
    energy_density: Array
    levels: list[Record]
    mean_traction: list[float]
    n: list[int]
    length: list[float]
    warnings: list[Record]


class Green(Record):
    """The elasticity of one wave vector: traction = K u with u = exp(+i q r). Entries that are infinite are NaN.

    Attributes:
        stiffness: complex [component, component], stress/length. compliance: its inverse, length/stress.
        normal_compliance, normal_stiffness: without friction, length/stress and stress/length.
        displacement_transfer: complex [component, component], displacement inside over that of the surface.
        stress_transfer: complex [tensor, component], stress/length. stress_components: the names of its rows.
        warnings: none.
        q: wave vector, rad/length. components: x, y, z, or x, z in 2-D.

    Example:
        >>> gfmd.green(gfmd.Body(), qx=3.0).stiffness.shape
        (3, 3)
    """

    stiffness: np.typing.NDArray[np.complex128]
    compliance: np.typing.NDArray[np.complex128]
    normal_compliance: float
    normal_stiffness: float
    displacement_transfer: np.typing.NDArray[np.complex128]
    stress_transfer: np.typing.NDArray[np.complex128]
    stress_components: list[str]
    q: list[float]
    components: list[str]
    warnings: list[Record]


@hinted
def punch(
    body: Optional[Body] = None,
    *,
    length: float = 1.27,
    n: Optional[int] = None,
    dim: int = 3,
    punch_fraction: Optional[float] = None,
    mask: Optional[npt.ArrayLike] = None,
    depth: float = 0.005,
    contact: str = "sticking",
    nodes: Optional[str] = None,
    shift: Sequence[float] = (),
    traction: Optional[npt.ArrayLike] = None,
    solver: str = "auto",
    dt: Optional[float] = None,
    damping: float | Sequence[float] | None = None,
    history: bool = False,
    history_modes: Sequence[tuple[int, int, str]] = (),
    history_points: Sequence[tuple[float, float, str]] = (),
    tolerance: float = 1e-8,
    max_iterations: int = 100_000,
    refine: int = 1,
    threads: Optional[int] = None,
    out: str | os.PathLike[str] | None = None,
) -> Punch:
    """Presses a flat rigid punch on a body: all components of displacement and traction.

    Args:
        body: the body; by default that of `gfmd punch` (E = 70, Poisson's ratio 0.33, height = length).
        length: side of the cell, length.
        n: points along a side; 128, or those of the mask.
        dim: 3 for a square punch, 2 for a strip.
        punch_fraction: width of the punch over that of the cell, 0.25 by default; or
        mask: the points under a punch of any shape, [n, n], or [n] of a strip: those other than 0.
        depth: depth to which it is pressed, length.
        contact: "sticking" or "frictionless".
        nodes: "strict" (default) leaves out the points on its edge, "inclusive" takes them in.
        shift: lateral displacement (x, y) of a sticking punch, length; (x,) of a strip.
        traction: traction where the punch does not hold, stress, [n, n, 3], or [n, 2] of a strip.
        solver: "auto", "cg", "verlet", "verlet-critical", "verlet-modes" or "fire".
        dt: time step over its stability limit without damping, of "verlet-critical" and "verlet-modes".
        damping: damping of "verlet-critical" over the critical one of the softest mode; or three numbers, that of each
            component over the critical one of its own uniform mode.
        history: record every step, in `history`: arrays `iteration`, `residual` and `energy` (NaN if the method moves
            no displacement).
        history_modes: modes (m, n, component) of the displacement to record, in `history.modes`, as (1, 0, "x").
        history_points: points (x, y, component) whose displacement to record, in `history.points`; lengths.
        tolerance: largest residual, 1e-15 to 0.1.
        max_iterations: iterations after which the search is given up.
        refine: number of grids, each twice as fine, from which the mean pressure is extrapolated.
        threads: number of threads; all cores by default.
        out: name of an HDF5 file for the result, that of `gfmd punch --out`; as `save`, but the name is checked before
            the work begins.

    Raises:
        InputError: unusable arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Punch as far as it came.

    Example:
        >>> punch = gfmd.punch(n=32, nodes="inclusive")
        >>> round(punch.mean_pressure, 3)
        0.115
    """
    for name, value in (("punch_fraction", punch_fraction), ("nodes", nodes)):
        if mask is not None and value is not None:
            raise InputError(f"mask and {name} are both given; give one of the two")
    given = None if body is None else as_body(body, of_moduli=True)
    problem: dict[str, Any] = {} if given is None else _elastic(given, given.layers)
    problem.update(
        length=number("length", length),
        n=None if n is None else integer("n", n),
        dim=integer("dim", dim, 2, 3),
        punch_fraction=None if punch_fraction is None else number("punch_fraction", punch_fraction),
        depth=number("depth", depth),
        contact=word("contact", contact),
        nodes=None if nodes is None else word("nodes", nodes),
        shift=numbers("shift", shift) if len(shift) else None,
        solver=word("solver", solver),
        dt=None if dt is None else number("dt", dt),
        damping=None if damping is None else numbers("damping", damping),
        tol=number("tolerance", tolerance),
        max_iter=integer("max_iterations", max_iterations),
        refine=integer("refine", refine, 1, 8),
        history=flag("history", history),
        history_mode=[],
        history_point=[],
    )
    for first, second, component in _threes("history_modes", history_modes):
        numbers_of = [integer("history_modes", entry, -(2**31), 2**31 - 1) for entry in (first, second)]
        problem["history_mode"].append([*numbers_of, word("history_modes", component)])
    for first, second, component in _threes("history_points", history_points):
        position = [number("history_points", entry) for entry in (first, second)]
        problem["history_point"].append([*position, word("history_points", component)])
    arrays = {
        name: None if value is None else array(name, value) for name, value in (("mask", mask), ("traction", traction))
    }
    values, failure, fields, file = _command.solve("punch", problem, arrays, threads, out)
    if values["height"] == "inf":
        values["height"] = math.inf
    for name in arrays:
        values.pop(name, None)
    if history:
        values["history"] = _history(values["history"])
    reported = {name: _command.records(value) for name, value in values.items()}
    return _command.ended(Punch({**reported, **fields}, file), failure)


def _threes(name: str, rows: Any) -> list[tuple[Any, Any, Any]]:
    try:
        return [(first, second, component) for first, second, component in rows]
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{name} is {shown(rows)}; it must have entries of three: two numbers and a component"
        ) from error


def _history(values: dict[str, Any]) -> dict[str, Any]:
    """The record of a search, with arrays, and NaN in place of null."""

    def reported(name: str, value: Any) -> Any:
        if name in ("modes", "points"):
            return [{name: reported(name, entry) for name, entry in row.items()} for row in value]
        return value if name in ("mode", "point", "component") else np.array(value, dtype=np.float64)

    return {name: reported(name, value) for name, value in values.items()}


def interior(
    source: Union[Contact, Punch],
    depths: Optional[Sequence[Quantity]] = None,
    *,
    levels: Optional[int] = None,
    deepest: Optional[Quantity] = None,
    quantities: Sequence[str] = _QUANTITIES,
    along: Optional[str] = None,
    threads: Optional[int] = None,
    out: str | os.PathLike[str] | None = None,
) -> FieldsBelow:
    """Displacement, strain and stress below the surface of a contact or a punch.

    Args:
        source: a contact (the lateral displacement of a surface without friction is added) or a punch.
        depths: depths below the surface, length, or texts with a unit; or
        levels: number of depths at equal distances, from the surface to the base or to the `deepest`.
        deepest: depth of the lowest level, length.
        quantities: of "displacement", "strain", "stress", "von-mises", "energy-density"; all by default.
        along: "y=Y" or "x=X", the nearest row of points only.
        threads: number of threads; all cores by default.
        out: name of an HDF5 file for the result, that of `gfmd body --out`; as `save`, but the name is checked before
            the work begins.

    Raises:
        InputError: depths outside the body, an unknown quantity.
        Interrupted: nothing is kept.

    Example:
        >>> below = gfmd.interior(punch, depths=[0.1, 0.2])
        >>> below.stress.shape, len(below.levels)
        ((2, 32, 32, 6), 2)
    """
    if (depths is None) == (levels is None):
        raise InputError("the depths must be given by one of depths, levels")
    if depths is not None and deepest is not None:
        raise InputError("depths and deepest are both given; deepest goes with levels")
    problem: dict[str, Any] = dict(
        depths=None if depths is None else lengths("depths", depths, "length"),
        levels=None if levels is None else integer("levels", levels, 1),
        deepest=None if deepest is None else quantity("deepest", deepest, "length"),
        quantities=texts("quantities", quantities),
        slice=None if along is None else word("along", along),
    )
    own, given = _source(source)
    values, failure, fields, file = _command.solve("body", {**problem, **own}, {"surface": given}, threads, out)
    del values["surface"]
    named = {name.replace("-", "_") for name in problem["quantities"]}
    found = {name: field for name, field in fields.items() if name in named}
    reported = {name: _command.records(value) for name, value in values.items()}
    return _command.ended(FieldsBelow({**reported, **found}, file), failure)


def _elastic(values: Any, layers: Sequence[Sequence[Any]]) -> dict[str, Any]:
    """The keys of the body of a record, and of the layers below its top one."""
    given = getattr(values, "_given", (None, 0.0, None, None))
    # A quantity with a unit is refused by its name: the lengths have none.
    young = next((modulus for modulus in (given[0], given[2]) if isinstance(modulus, str)), values.young)
    elastic = {"young": young, "poisson": values.poisson, "height": _command.height_key(values.height)}
    return {**elastic, **_command.other_keys(values, layers)}


def _source(source: Union[Contact, Punch]) -> tuple[dict[str, Any], Any]:
    """The keys of the body and the cell, and the displacement of the surface."""
    if isinstance(source, Contact):
        shear = {f"mean_shear_{axis}": np.array(value) for axis, value in zip("xy", source.get("mean_shear", ()))}
        units = {"unit": source.surface.unit} if source.surface.unit else {}
        return {"length": list(source.surface.size)}, ({**config([source]), **units}, {**source._fields, **shear})
    if isinstance(source, Punch):
        # Summed in the order of the program.
        columns = source.traction.reshape(-1, source.traction.shape[-1]).T
        mean_traction = [float(np.cumsum(column)[-1] / column.size) for column in columns]
        keys = {"length": [source.length[0]], "mean_traction": mean_traction}
        return {**keys, **_elastic(source, source.get("layer", ()))}, source.displacement
    raise InputError(f"source is {type(source).__name__}; it must be a Contact or a Punch")


@hinted
def green(
    body: Body, *, qx: float, qy: float = 0.0, dim: int = 3, z: Optional[float] = None, depth: Optional[float] = None
) -> Green:
    """The elasticity of one wave vector: `stiffness`, `compliance` (complex matrices), `normal_compliance`.

    Args:
        body: the body, on any base.
        qx, qy: wave vector, rad/length.
        dim: 3, or 2 for plane strain.
        z: height above the base, length; or
        depth: depth below the surface, length, at which `displacement_transfer` and `stress_transfer` are wanted.

    Raises:
        InputError: a value out of its range.

    Example:
        >>> gfmd.green(gfmd.Body(), qx=3.0, qy=4.0).normal_compliance
        0.4
        >>> coating = gfmd.Body(height=0.1, base="half-space", base_young=10.0, base_poisson=0.2)
        >>> round(gfmd.green(coating, qx=3.0, depth=0.1).normal_compliance, 4)
        0.1627
    """
    given = as_body(body, of_moduli=True)
    if z is not None and depth is not None:
        raise InputError("z and depth are both given; give one of the two")
    problem = dict(
        **_elastic(given, given.layers),
        qx=number("qx", qx),
        qy=number("qy", qy),
        dim=integer("dim", dim, 2, 3),
        z=None if z is None else number("z", z),
        depth=None if depth is None else number("depth", depth),
    )
    values, *_ = _command.solve("green", problem)
    for name in ("stiffness", "compliance", "displacement_transfer", "stress_transfer"):
        if values.get(name) is not None:
            pairs = np.array(values[name], dtype=np.float64)
            values[name] = pairs[..., 0] + 1j * pairs[..., 1]
            values[name].flags.writeable = False
    return Green({name: math.nan if value is None else value for name, value in values.items()})
