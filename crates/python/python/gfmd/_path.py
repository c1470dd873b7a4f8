"""Contacts along a path: loading and unloading, adhesion, friction, wear, relaxation."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _command, _gfmd, _show
from ._body import Body, Law, as_body, as_law
from ._check import Array, Quantity, array, conductivities, frozen, integer, is_sequence, number, quantities, quantity
from ._columns import MEASURED, StepFields, Steps
from ._contact import Adhesion
from ._errors import Error, InputError
from ._given import taking
from ._hints import hinted
from ._leak import Leaks
from ._load import Residual, residual_of
from ._options import PathOptions
from ._parts import Wear, wear_keys
from ._progress import Progress
from ._measured import Measured
from ._record import Record, by_name, without_null
from ._result import Computed, Contents, File
from ._surface import Surface, as_hardness, as_lower, as_surface
from ._units import known

if TYPE_CHECKING:
    from typing_extensions import Unpack


# Largest difference between a path and the same path followed again, relative to the largest of its values: with single
# solves, and with divided steps, whose increments are solved less exactly in the path.
_ALIKE = 1e-6
_ALIKE_DIVIDED = 1e-4

# Reason why a path not followed in this session has no derivatives.
_READ = "the path was read from a file; it must be a result of gfmd.path, for derivatives"


class PathGradient(Measured):
    """Derivatives of a scalar L of a path with respect to its inputs, from `Path.vjp`.

    Attributes:
        heights: dL/d(height) at each point [x, y], unit of L divided by length; read-only.
        loads: dL/d(mean pressure) prescribed at each step [step], or dL/d(approach); read-only.
        modulus: dL/dE*, E* in stress, with all moduli of the body scaled together.
        lateral: dL/d(lateral displacement) of the rigid surface at each step along x and y [step, 2]; read-only.
        friction, shear_strength: dL/d(friction coefficient) and dL/d(shear strength); 0 without them.
        hardness: dL/d(hardness), a number, or an array [x, y] if the hardness is one; with a hardness only.
        wear_by_distance, wear_by_slip: dL/d(wear coefficient), stress; 0 without wear of this kind.
        error: largest relative error of the linear problems, at most 1e-8.

    Example:
        >>> rubber = gfmd.Body(prony=[(1.0, 0.5)])
        >>> creep = gfmd.path(gfmd.self_affine(n=16), rubber, pressure=0.01, time=[0, 1], steps=1)
        >>> creep.vjp(elastic_energy=[0.0, 1.0]).loads.shape
        (2,)
    """

    heights: Array
    loads: Array
    lateral: Array
    modulus: float
    friction: float
    shear_strength: float
    hardness: Union[float, Array]
    wear_by_distance: float
    wear_by_slip: float
    error: float


class Path(Leaks, Computed, StepFields):
    """A contact along a path.

    Attributes:
        steps: step numbers, a `Record` of arrays [step]. Fields are given at the waypoints; NaN at waypoints that were
            not reached.
        hardness: given hardness, stress, a number or an array [x, y]; with a hardness only.
        lower_surface: given second surface, a `Surface`, and
        lower: its description, rms gradient and rms height; with one only.
        wear: given wear, a `Wear`; with wear only, as are
        coefficient: its coefficient as a number, 1/stress, and
        wear_volume: mean depth lost at the end, length, at the upper face of a slab between two surfaces; None if no
            step was solved.
        wear_volume_error: its estimated error, from a path with half as many increments; None if that was not followed
            (`energy_solves` below 3).
        adhesion: adhesion numbers on this grid before the solve, an `Adhesion`; with an attraction only.
        dissipated, dissipated_error: energy lost along the path per area, stress * length, and the sum of the step
            errors; None if unknown. The error is also None if one of its terms is unknown. With several causes, `steps`
            has the part of each: `lost_friction`, `lost_wear` and so on.
        work_imbalance: sum of the work and energy imbalances of the steps, stress * length; present if `steps` has
            them. It excludes a first step of zero duration and distance.
        sliding: stiffness and friction of each leg with lateral motion: `leg`, `tangential_stiffness` (stress/length),
            `friction_coefficient`.
        lowest_mean_pressure: lowest mean pressure, stress; negative under tension.
        grid_error: how the discretisation error was estimated: `mode`, `n`, `assumes`, `orders`.
        lowest_mean_pressure_limit, dissipated_limit, each with `_limit_error` and `_grid_error`: with
            `grid_error="refine"`, their values on an infinitely fine grid, from the difference between two grids.
            `steps` has the same for its numbers.
        parted_at: step at which the surfaces parted under their load, or None.
        undefined: reasons why arrays of `steps` are NaN at some steps, by name.
        warnings: a Record for each warning of the computation: `code`, `text`.
        prony, moduli, relaxes, young_long_term, young_instantaneous: relaxation of a viscoelastic body.
        yield_stress, hardening, hardening_curve, kinematic_hardening: yield stress and hardening of a yielding body,
            as numbers.
        cells, coarsening: thickness, length, of each cell of a yielding body, from the surface down, and its grid step
            divided by the surface grid step.
        kept_strain: "waypoints" if `plastic_strain` knows all waypoints; absent otherwise.
        surface, n, size, unit, rms_gradient, rms_height, e_star, law, direction, extra_solves: problem parameters, and
            the number of additional solves.

    Example:
        >>> loop.steps.mean_pressure.shape, loop.pressure.shape
        ((9,), (3, 32, 32))
    """

    steps: Steps
    hardness: Union[float, Array]
    lower_surface: Surface
    lower: Record
    wear: Wear
    coefficient: float
    wear_volume: Optional[float]
    wear_volume_error: Optional[float]
    adhesion: Adhesion
    dissipated: Optional[float]
    dissipated_error: Optional[float]
    work_imbalance: Optional[float]
    prony: list[list[float]]
    moduli: str
    relaxes: str
    young_long_term: float
    young_instantaneous: float
    yield_stress: float
    hardening: float
    hardening_curve: list[list[float]]
    kinematic_hardening: float
    cells: list[float]
    coarsening: list[int]
    kept_strain: str
    sliding: list[Record]
    lowest_mean_pressure: float
    grid_error: Record
    parted_at: Optional[int]
    surface: Surface
    n: list[int]
    size: list[float]
    unit: Optional[str]
    rms_gradient: float
    rms_height: float
    e_star: float
    law: str
    direction: list[float]
    extra_solves: int
    undefined: dict[str, str]
    warnings: list[Record]
    _again: Union[str, tuple[dict[str, Any], dict[str, Any]]]

    def __init__(
        self,
        values: Mapping[str, Any],
        file: File | Contents,
        again: Union[str, tuple[dict[str, Any], dict[str, Any]]] = _READ,
    ) -> None:
        super().__init__(values, file)
        object.__setattr__(self, "_again", again)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._values, self._file, self._again)

    def vjp(
        self,
        *,
        pressure: Optional[npt.ArrayLike] = None,
        gap: Optional[npt.ArrayLike] = None,
        approach: npt.ArrayLike = 0.0,
        mean_pressure: npt.ArrayLike = 0.0,
        mean_gap: npt.ArrayLike = 0.0,
        elastic_energy: npt.ArrayLike = 0.0,
        plastic_depth: Optional[npt.ArrayLike] = None,
        shear_x: Optional[npt.ArrayLike] = None,
        shear_y: Optional[npt.ArrayLike] = None,
        mean_shear_x: npt.ArrayLike = 0.0,
        mean_shear_y: npt.ArrayLike = 0.0,
        threads: Optional[int] = None,
    ) -> PathGradient:
        """Returns the derivatives of a scalar L of this path with respect to heights, loads and parameters.

        The arguments are the derivatives of L with respect to the fields at the waypoints and the numbers of the steps;
        the result is the vector-Jacobian product of reverse-mode differentiation. The path is followed again, with one
        linear problem per step, from the last to the first: relaxation, wear, plastic depths and the places where
        points stick pass the derivatives back to earlier steps. The points of each step in contact, at the hardness,
        sticking and slipping are fixed, as in `Contact.vjp`, and so are times and sliding distances.

        Args:
            pressure: dL/d(pressure) at each point [waypoint, x, y]; 0 by default, like all others.
            gap: dL/d(gap) at each point [waypoint, x, y]; ignored at points pressed by a wall.
            approach: dL/d(approach) of each step [step], or one number for all steps, like
            mean_pressure: dL/d(mean pressure),
            mean_gap: dL/d(mean gap), and
            elastic_energy: dL/d(elastic energy per area).
            plastic_depth: dL/d(plastic depth) at each point [waypoint, x, y]; with a hardness.
            shear_x: dL/d(shear traction along x) at each point [waypoint, x, y]; with friction or a shear strength.
            shear_y: the same along y.
            mean_shear_x: dL/d(mean shear traction along x) of each step, or one number for all steps.
            mean_shear_y: the same along y.
            threads: number of threads; all cores by default.

        Raises:
            InputError: arrays of the wrong shape, or of fields that the path does not have; a path with a yielding
                body, all components, a lower surface or a base that moves (not implemented); full contact under an
                approach that does not determine the pressure; a state of a law in which a small change causes a jump;
                a path that is incomplete, or was read from a file. Error: the path followed again jumps differently.

        Example:
            >>> rubber = gfmd.Body(prony=[(1.0, 0.5)])
            >>> rough = gfmd.self_affine(n=16)
            >>> creep = gfmd.path(rough, rubber, pressure=0.01, time=[0, 1, 100], steps=1)
            >>> found = creep.vjp(mean_gap=[0.0, 0.0, 1.0])  # of the last mean gap
            >>> found.heights.shape, found.loads.shape
            ((16, 16), (3,))
            >>> pushed = gfmd.path(rough, gfmd.Body(), friction=0.3, pressure=0.01, lateral=[0, 1e-4], steps=1)
            >>> by = pushed.vjp(mean_shear_x=[0.0, 1.0])  # of the last friction force
            >>> by.friction != 0.0, by.lateral.shape
            (True, (2, 2))
        """
        if isinstance(self._again, str):
            raise InputError(self._again)
        problem, arrays = self._again
        waypoints, count = self.pressure.shape, len(self.steps.mean_pressure)
        fields = {}
        given_fields = {
            "pressure": pressure,
            "gap": gap,
            "plastic_depth": plastic_depth,
            "shear_x": shear_x,
            "shear_y": shear_y,
        }
        for name, value in given_fields.items():
            if value is None:
                continue
            found = array(name, value)
            fields[name] = found[..., np.newaxis] if found.ndim == 2 and waypoints[2] == 1 else found
            if fields[name].shape != waypoints:
                raise InputError(
                    f"{name} has the shape {list(found.shape)}; it must be {list(waypoints)}, the shape of the path"
                )
        given = {
            "approach": approach,
            "mean_pressure": mean_pressure,
            "mean_gap": mean_gap,
            "elastic_energy": elastic_energy,
            "mean_shear_x": mean_shear_x,
            "mean_shear_y": mean_shear_y,
        }
        by_step = {}
        for name, value in given.items():
            found = array(name, value)
            if found.shape not in ((), (count,)):
                shape = list(found.shape)
                raise InputError(f"{name} has the shape {shape}; it must be a number or [{count}], the steps")
            by_step[name] = [number(name, entry) for entry in np.broadcast_to(found, count).tolist()]
        used = 0 if threads is None else integer("threads", threads, 0, 4096)
        with Progress("path") as progress:
            derivatives = _gfmd.path_vjp(problem, arrays, fields, by_step, used, progress.tick)
        is_divided = np.any(np.asarray(self.steps.get("increments", 0)) > 1)
        alike = _ALIKE_DIVIDED if is_divided else _ALIKE
        for reached, name in zip(np.transpose(derivatives.pop("reached")), ("mean_pressure", "approach")):
            known = self.steps.get(name)
            if known is not None and not np.allclose(reached, known, rtol=0.0, atol=alike * np.abs(known).max()):
                raise Error(f"the {name} of the path followed again differs from this path, which passes a jump")
        hardness = derivatives.pop("hardness")
        if hardness is not None:
            derivatives["hardness"] = (
                frozen(hardness) if isinstance(self.hardness, np.ndarray) else float(hardness.sum())
            )
        for name in ("heights", "loads", "lateral"):
            derivatives[name] = frozen(np.array(derivatives[name]))
        return PathGradient(derivatives)

    @property
    def residual(self) -> Residual:
        """Parts of the residual by name, arrays [step], without unit; `residual.largest` is the largest part."""
        return residual_of(self.steps)

    @property
    def plastic_displacement(self) -> Array:
        """Normal displacement due to plastic strain [waypoint, x, y], length; unloaded, the residual topography."""
        field: Array = self.plastic_displacement_z
        return field

    def plastic_strain(self, waypoint: int = -1) -> Array:
        """Returns the equivalent plastic strain below the surface, interpolated to the surface grid.

        Args:
            waypoint: -1 for the state after the last step; others need `kept_strain="waypoints"`.

        Returns:
            Strain, shape [cell, x, y]; NaN at a waypoint that was not reached.

        Raises:
            InputError: a waypoint whose strain is not kept, or a body that does not yield. Error: the file cannot be
                written.

        Example:
            >>> steel = gfmd.Body(poisson=0.3, yield_stress=0.01)
            >>> pressed = gfmd.path(gfmd.self_affine(n=16), steel, p_star=[0.02, 0.04], steps=2)
            >>> strain = pressed.plastic_strain()
            >>> strain.shape == (len(pressed.cells), 16, 16), bool(strain.max() == pressed.steps.max_plastic_strain[-1])
            (True, True)
            >>> pressed = gfmd.path(gfmd.self_affine(n=16), steel, p_star=[0.02, 0.04], kept_strain="waypoints")
            >>> bool(pressed.plastic_strain(0).max() < pressed.plastic_strain(1).max())
            True
        """
        if "cells" not in self:
            raise InputError("the body does not yield; it must, for a plastic strain")
        waypoints = len(self.pressure)
        is_kept = self.get("kept_strain") == "waypoints"
        if is_kept and not -waypoints <= waypoint < waypoints:
            raise InputError(f"waypoint is {waypoint}; it must be from {-waypoints} to {waypoints - 1}")
        if not is_kept and waypoint not in (-1, waypoints - 1):
            raise InputError(f'waypoint is {waypoint}; it must be -1 without kept_strain="waypoints"')
        group = "plastic" if waypoint == -1 or not is_kept else "plastic_at_waypoints"
        with self._stored() as name:
            file = _gfmd.StoredFile(name)
            fields = [file.array(f"/{group}/equivalent_{cell}") for cell in range(len(self.cells))]
        if group != "plastic":
            fields = [field[waypoint] for field in fields]
        return np.stack([_spread(field, self.n) for field in fields])

    def __repr__(self) -> str:
        drives = ("mean_pressure", "p_star", "approach", "lateral", "time", "distance")
        names = (*drives, "area_fraction", "mean_gap", "wear_volume")
        answers = ("wear_volume", "dissipated", "lowest_mean_pressure", "sliding", "parted_at")
        return self._answer("steps", names, answers)

    def to_dataframe(self) -> Any:
        """Returns the step numbers as a pandas.DataFrame with one row per step; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> loop.to_dataframe().shape[0]  # doctest: +SKIP
            9
        """
        return _show.table_frame(self, self.steps)

    def plot(self, x: Optional[str] = None, y: Optional[str] = None, ax: Any = None) -> Any:
        """Draws one step number against another with matplotlib: filled where `x` rises, hollow where it falls.
        Returns the axes.

        By default it draws mean depth lost against distance for wear by distance, shear against lateral displacement
        for lateral motion, contact area against time for a viscoelastic body, and otherwise mean pressure against
        approach.

        Args:
            x, y: names of arrays in `steps`; for a vector, such as `lateral` or `mean_shear`, the component along
                `direction`. `x="step"` is the step number. `y="losses"` draws the energy lost so far by each cause, and
                the sum.
            ax: axes to draw into; new ones by default.

        Raises:
            InputError: an unknown name. Error: matplotlib is not installed.

        Example:
            >>> ax = loop.plot("approach", "area_fraction")
        """
        default = self._axes()
        if x is None:
            x = "step" if y is not None and default[0] == "approach" else default[0]
        along = self._column(x)
        if y == "losses":
            return _show.losses(along, self._losses(), self.units, ax)
        return _show.loop(along, self._column(default[1] if y is None else y), self.units, ax)

    def _axes(self) -> tuple[str, str]:
        """Returns the names of the two numbers drawn by default."""
        steps = self.steps

        def varies(name: str) -> bool:
            return name in steps and bool(np.any(steps[name] != steps[name][0]))

        if varies("distance"):
            return "distance", "wear_volume"
        if varies("lateral") and "mean_shear" in steps:
            return "lateral", "mean_shear"
        if varies("time"):
            return "time", "area_fraction"
        return ("approach", "mean_pressure") if "approach" in steps else ("step", "mean_pressure")

    def _column(self, name: Any) -> tuple[str, Array]:
        """Returns the name and values of a step number; for a vector, its component along the direction."""
        if name == "step" and "step" not in self.steps:
            return name, np.arange(float(len(self.steps.mean_pressure)))
        if isinstance(name, str) and name in self.steps and np.shape(self.steps[name])[1:] == (2,):
            return name, self.steps[name] @ np.asarray(self.direction)
        return _show.column(self.steps, name)

    def _losses(self) -> dict[str, Array]:
        """Returns the energy lost so far by each cause, and in total."""
        causes = [name for name in self.steps if name.startswith("lost_") and self.steps[name].ndim == 1]
        causes = [name for name in causes if not name.endswith(("_limit", "_error"))]
        return {name: np.nancumsum(self.steps[name]) for name in [*causes, "dissipated"]}

    def to_xarray(self) -> Any:
        """Returns the scalars [step] and fields [waypoint, y, x] as an xarray.Dataset.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> loop.to_xarray().mean_pressure.dims
            ('step',)
        """
        return _show.table_dataset(self, self.steps, "step", "waypoint")


def _spread(field: Array, points: list[int]) -> Array:
    """Interpolates a periodic field linearly to a finer grid."""
    for axis, (coarse, fine) in enumerate(zip(field.shape, points)):
        times = fine // coarse
        next_one = np.roll(field, -1, axis)
        parts = [field + k / times * (next_one - field) for k in range(times)]
        field = np.stack(parts, axis + 1).reshape([*field.shape[:axis], fine, *field.shape[axis + 1 :]])
    return field


def _column(values: list[Any]) -> Any:
    """Returns a column of the steps as an array, with NaN for missing values and components; groups as a Record."""
    if any(isinstance(value, dict) for value in values):
        names = dict.fromkeys(name for value in values if value for name in value)
        return Record({name: _column([value and value.get(name) for value in values]) for name in names})
    made = np.array([np.nan if value is None else value for value in values])
    return frozen(made.astype(float) if made.dtype == object else made)


def drive_keys(said: str, drive: dict[str, Any]) -> dict[str, Any]:
    """Returns the configuration keys of the load, given in one of four ways; `said` starts the error message."""
    found = {name: quantities(name, value) for name, value in drive.items() if value is not None}
    if len(found) != 1:
        given = ", ".join(found) or "none"
        raise InputError(f"{said} given by {given}; it must be given by one of pressure, p_star, force, approach")
    return found


def _measured(step: dict[str, Any]) -> dict[str, Any]:
    """Takes patches and flow out of a step. Returns their numbers by column name."""
    places = {name: place.split(".") for name, place in MEASURED.items()}
    found = {measured: step.pop(measured) for measured in {place[0] for place in places.values()} & step.keys()}
    there = {name: place for name, place in places.items() if place[1] in found.get(place[0], {})}
    return {
        name: reduce(lambda part, key: part[int(key)], keys, found[measured][first])
        for name, (measured, first, *keys) in there.items()
    }


# Report keys named as in `Body`.
_OF_BODY = {"yield": "yield_stress", "kinematic": "kinematic_hardening"}


def gathered(values: dict[str, Any]) -> dict[str, Any]:
    """Converts the report of a path: the numbers of its steps become arrays."""
    parts = [{f"residual_{part}": value for part, value in step.pop("residual").items()} for step in values["steps"]]
    undefined: dict[str, str] = {}
    for step in values["steps"]:
        undefined |= by_name(step.pop("undefined", {}))
    measured = [_measured(step) for step in values["steps"]]
    rows = [{**step, **found, **part} for step, found, part in zip(values["steps"], measured, parts)]
    names = dict.fromkeys(name for row in rows for name in row)
    columns = {name: _column([row.get(name) for row in rows]) for name in names}
    reported = {_OF_BODY.get(name, name): _command.records(value) for name, value in values.items()}
    units = known(values.get("unit"), values.get("stress_unit"))
    if values.get("adhesion") is not None:
        reported["adhesion"] = Adhesion(without_null(values["adhesion"]), units)
    if "sliding" in values:
        reported["sliding"] = [Record(leg, units) for leg in values["sliding"]]
    return {**reported, "steps": Steps(columns), "undefined": undefined}


def _lateral_keys(value: Any) -> dict[str, Any]:
    """Returns the configuration keys of lateral displacements: values along the direction, or a pair (along,
    perpendicular), each possibly None.
    """
    parts = list(value) if is_sequence(value) else []
    if not any(is_sequence(part) for part in parts):
        return {} if value is None else {"lateral": quantities("lateral", value)}
    if len(parts) != 2:
        raise InputError(
            f"lateral has {len(parts)} entries with lists among them; it must have two, the values along the direction"
            " and those at a right angle to it"
        )
    named = zip(("lateral", "lateral_y"), parts)
    return {name: quantities("lateral", part) for name, part in named if part is not None}


def _check_distance(wear: Optional[Wear], distance: Any) -> None:
    """Checks that a path has distances if, and only if, it wears by distance."""
    if wear is not None and wear.by == "distance":
        if distance is None:
            raise InputError("distance is missing; it is needed with wear by distance", "distance")
    elif distance is not None:
        unless = "without wear" if wear is None else "with wear by slip"
        raise InputError(f"distance is given; it must be left out {unless}", "distance", "given", f"left out {unless}")


@taking(PathOptions)
def path(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    pressure: Any = None,
    p_star: Any = None,
    force: Any = None,
    approach: Any = None,
    lateral: Any = None,
    distance: Any = None,
    friction: Optional[float] = None,
    shear_strength: Optional[Quantity] = None,
    wear: Optional[Wear] = None,
    **options: Unpack[PathOptions],
) -> Path:
    """Follows a contact along a path of loads, approaches and lateral displacements, each step from the last.

    Args:
        surface, body: as in `contact`.
        pressure, p_star, force, approach: waypoints of one of the four (stress, 1, stress * length^2, length), a
            number or a sequence; negative for tension or separation. All may be strings with a unit, such as "1MPa",
            "5N", if the surface has one.
        lateral: lateral displacements of the rigid surface at the waypoints, length: values along `direction`, or a
            pair `(along, across)`, along `direction` and perpendicular to it. With friction or a law that shears.
        time: durations of the legs, with a viscoelastic body (`Body(prony=...)`): a number or a sequence. Each leg ends
            at a waypoint. "2 h", "1 d" are in seconds if the lengths have a unit. The first leg begins at first touch;
            a leg of zero duration is a jump.
        distance: sliding distances of the legs, length, as in `wear`; with `wear=gfmd.Wear(..., by="distance")`.
        direction: direction of the lateral displacements, degrees from x.
        law: as in `contact`.
        friction: friction coefficient (Coulomb).
        shear_strength: interface strength (Tresca), stress: shear limit of all points in contact. With `friction` too,
            the smaller limit holds at each point.
        friction_of: pressure to which friction is proportional beside a law: "repulsion", the pressure between
            touching points, or "net", the repulsion minus the attraction.
        wear: wear of both surfaces, a `Wear`, by the given `distance` or by their own slip.
        hardness: largest pressure, stress, as in `contact`; the plastic depth is kept. Beside a law it limits the
            pressure on the body, the repulsion minus the attraction.
        lower_surface: second rigid surface below a slab, as in `contact`; law, hardness and wear act at both faces,
            and wear by distance only.
        cells: cells below the surface of a yielding body (`Body(yield_stress=...)`), with plastic strain constant in
            depth: "graded:0.5,1.12,3" by default (first thickness in grid steps, thickness divided by the thickness
            above, depth divided by the grid step of the cell), "uniform:N,DEPTH", or the thickness of each, length.
        coarsening: grid step of each cell divided by the surface grid step, powers of two, if `cells` has the
            thickness of each; 1 by default.
        kept_strain: states whose plastic strain `Path.plastic_strain` returns: "last", after the last step, or
            "waypoints", also at every waypoint: six numbers for each point of each cell.
        boundary: "periodic", or "free" as in `contact`.
        stress_unit: unit of stresses given without one, as in `contact`.
        coarse: also solve a law with a process zone narrower than a tenth of a grid step.
        grid_error: as in `contact`; "refine" also follows the path on a grid with twice as many points along each side.
        components: displacement components to solve for, "normal", or "held" as in `contact`.
        base_displacement, base_traction: displacement of the base, or traction on it, as in `contact`.
        statistics: measure patches and conductance of every step: `patches`, `largest_patch_fraction`, `conductance`
            and so on in `steps`; in files also distributions and spectra at the waypoints.
        conductor_height, conductivity: electrode depth in both conductors, length, and their conductivities, W/(m K)
            or strings with a unit, for `steps.contact_conductance`; with `statistics`.
        flow: compute fluid flow through the gap after every step: `flow_xx`, `flow_percolates_x` and so on in `steps`,
            and `leak_rate`.
        steps: number of steps between waypoints, or a sequence with a number for each leg. A leg of zero duration and
            distance is one step.
        tolerance, max_iterations: limits for each step, as in `contact`.
        energy_tolerance, energy_solves: accuracy of the dissipated energy, and of the shear with friction; see
            docs/interface.md.
        stiffness_tolerance: largest relative error of `steps.stiffness` of a hard wall, as in `contact`.
        threads: number of threads; all cores by default.
        out: HDF5 file to write, as with `gfmd path --out`. Unlike `save`, it checks the name before the first step.

    Raises:
        InputError: invalid arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Path so far.

    Example:
        >>> adhesion = gfmd.law("exponential", gamma=1e-4, range=1.2e-3)
        >>> rough = gfmd.self_affine(n=32, eps_f_inv=4)
        >>> loop = gfmd.path(rough, gfmd.Body(), law=adhesion, approach=[-0.004, 0.004, -0.007], steps=4)
        >>> loop.lowest_mean_pressure < 0
        True
        >>> rubber = gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)])
        >>> creep = gfmd.path(rough, rubber, pressure=0.01, time=[0, 1, 100], steps=1)
        >>> bool(creep.steps.area_fraction[-1] > creep.steps.area_fraction[0])
        True
        >>> steel = gfmd.Body(poisson=0.3, yield_stress=0.01, hardening=0.02)
        >>> dented = gfmd.path(rough, steel, p_star=[0.02, 0.05, 0.001], steps=2)
        >>> bool(dented.plastic_displacement[-1].min() < 0.0)
        True
        >>> slip = dict(friction=0.5, lateral=[0, 0.002, -0.002], wear=gfmd.Wear(10.0, by="slip"))
        >>> fretted = gfmd.path(rough, gfmd.Body(), pressure=0.01, steps=2, tolerance=1e-6, **slip)
        >>> bool(fretted.steps.wear_volume[-1] > 0.0)
        True
    """
    made, elastic = as_surface(surface), as_body(body, in_time=True, yields=True)
    law, time, cells = options.pop("law", None), options.pop("time", None), options.pop("cells", None)
    given = as_law(law)
    threads, out = options.pop("threads", None), options.pop("out", None)
    bound = as_hardness(options.pop("hardness", None), made)
    lower = as_lower(options.pop("lower_surface", None), made)
    drive = drive_keys("the path is", {"pressure": pressure, "p_star": p_star, "force": force, "approach": approach})
    worn = wear_keys(wear)
    _check_distance(wear, distance)
    if options.get("conductivity") is not None:
        options["conductivity"] = conductivities(options["conductivity"], made.unit)
    problem: dict[str, Any] = dict(
        unit=made.unit,
        **drive,
        **_lateral_keys(lateral),
        time=None if time is None else quantities("time", time),
        distance=None if distance is None else quantities("distance", distance),
        friction=None if friction is None else number("friction", friction),
        shear_strength=None if shear_strength is None else quantity("shear_strength", shear_strength),
        cells=None if cells is None else cells if isinstance(cells, str) else quantities("cells", cells),
        **worn,
        **options,
    )
    if law is not None:
        problem.update(_command.law_keys(given))
    arrays: dict[str, Any] = {"surface": made.heights}
    for name in ("base_displacement", "base_traction"):
        if isinstance(problem.get(name), np.ndarray):
            arrays[name] = problem.pop(name)
    (problem if isinstance(bound, (float, str)) else arrays)["hardness"] = bound
    if lower is not None:
        arrays["lower_surface"] = lower.heights
    problem.update(size=list(made.size), **_command.body_keys(elastic), **_command.relaxation_keys(elastic))
    problem.update(_command.plasticity_keys(elastic))
    values, failure, fields, file = _command.solve("path", problem, arrays, threads, out, made)
    reported = gathered(values)
    if isinstance(bound, np.ndarray):
        reported["hardness"] = bound
    if wear is not None:
        reported["wear"] = wear
    if lower is not None:
        reported["lower_surface"] = lower
    again = (problem, arrays) if failure is None else "the path is not complete; it must be, for derivatives"
    result = Path({**reported, "unit": made.unit, "surface": made, **fields}, file, again)
    return _command.ended(result, failure)


@hinted
def friction(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    coefficient: Optional[float] = None,
    shear_strength: Optional[Quantity] = None,
    pressure: Any = None,
    p_star: Any = None,
    force: Any = None,
    approach: Any = None,
    lateral: Any = (0.0,),
    distance: Any = None,
    wear: Optional[Wear] = None,
    **options: Unpack[PathOptions],
) -> Path:
    """Pushes a contact with friction sideways: a `path` with all displacement components.

    Args:
        surface, body: as in `contact`.
        coefficient: friction coefficient (Coulomb), or
        shear_strength: interface strength (Tresca), stress; or both, as in `path`.
        pressure, p_star, force, approach: waypoints, as in `path`.
        lateral: lateral displacements of the rigid surface at the waypoints, length, as in `path`.
        distance, wear: sliding distances and wear, as in `path`.
        options: further arguments of `path`.

    Raises:
        InputError: invalid arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Path so far.

    Example:
        >>> rough = gfmd.self_affine(n=32)
        >>> pushed = gfmd.friction(rough, gfmd.Body(), coefficient=0.3, p_star=0.05, lateral=[0, 0.01], steps=4)
        >>> round(pushed.sliding[0].friction_coefficient, 2)
        0.3
    """
    if coefficient is None and shear_strength is None:
        raise InputError("friction is missing; it must be given by coefficient, shear_strength or both")
    loads = {"pressure": pressure, "p_star": p_star, "force": force, "approach": approach}
    further = {"distance": distance, "wear": wear, **options}
    return path(surface, body, friction=coefficient, shear_strength=shear_strength, lateral=lateral, **loads, **further)


@hinted
def wear(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    coefficient: Quantity,
    distance: Any,
    pressure: Any = None,
    p_star: Any = None,
    force: Any = None,
    approach: Any = None,
    **options: Unpack[PathOptions],
) -> Path:
    """Wears two sliding surfaces by Archard's law: running-in, shape, volume. It is a `path` with a `Wear`.

    Args:
        surface, body: as in `path`.
        coefficient: wear coefficient of both surfaces together, divided by the hardness, 1/stress, as in `Wear`.
        distance: sliding distances of the legs, length: a number or a sequence. Each leg ends at a waypoint. The first
            leg begins at first touch; a leg of zero distance is one step.
        pressure, p_star, force, approach: waypoints, as in `path`.
        options: further arguments of `path`.

    Raises:
        InputError: invalid arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Path so far.

    Example:
        >>> surface = gfmd.self_affine(n=32, eps_f_inv=4)
        >>> worn = gfmd.wear(surface, gfmd.Body(), coefficient=1.0, distance=[0, 100.0], p_star=0.05, steps=20)
        >>> float(worn.steps.area_fraction[0]) < 0.2, float(worn.steps.area_fraction[-1])
        (True, 1.0)
        >>> worn.steps.distance.shape, worn.wear_depth.shape
        ((21,), (2, 32, 32))
    """
    loads = {"pressure": pressure, "p_star": p_star, "force": force, "approach": approach}
    return path(surface, body, wear=Wear(coefficient), distance=distance, **loads, **options)
