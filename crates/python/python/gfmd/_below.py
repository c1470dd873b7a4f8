"""Flat punches, fields below a surface, and the elasticity of one wave vector."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from . import _command, _show
from ._body import Body, as_body
from ._check import Array, Quantity, array, integer, number, shown, word
from ._check import quantities as lengths
from ._columns import PunchNumbers
from ._errors import InputError
from ._given import TABLES, taking
from ._options_inside import GreenOptions, InteriorOptions, PunchOptions
from ._measured import Measured
from ._record import LINES, Record, table
from ._result import Computed, Contents, File
from ._types import Loaded
from ._units import attributes, known, label

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Punch(Computed, PunchNumbers):
    """A flat punch on a body, with `components` x, y, z (x, z for a strip).

    Attributes:
        displacement, traction: fields on the elastic surface [x, y, component], length and stress; [x, 1, component]
            for a strip.
        under_punch: 1 under the punch, else 0 [x, y].
        height: height of the body, length; infinite for a half-space.
        n, size, young, poisson, contact, nodes, dim, components: problem parameters.
        warnings: a Record for each warning of the computation: `code`, `text`.
        refinement: `n`, `mean_pressure`, `order`, `extrapolated`, `uncertainty`, with refine= only.
        history: every step, with history= only: arrays `iteration`, `residual`, `energy` and, if requested, lists
            `modes` and `points` of Records with `mode` or `point`, `component`, and `re` and `im` or `u` (length).

    Example:
        >>> punch.displacement.shape, punch.components
        ((32, 32, 3), ['x', 'y', 'z'])
    """

    displacement: Array
    traction: Array
    under_punch: Array
    height: float
    n: list[int]
    size: list[float]
    young: float
    poisson: float
    contact: str
    nodes: str
    dim: int
    components: list[str]
    warnings: list[Record]
    _main = (
        "mean_pressure",
        "max_pressure",
        "depth",
        "punch_width",
        "mean_traction",
        "elastic_energy",
        "refinement",
        "contact",
        "nodes",
        "n",
        "size",
        "residual",
        "converged",
    )

    def to_dataframe(self) -> Any:
        """Returns the numbers as a pandas.DataFrame with one row; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> punch.to_dataframe().shape[0]  # doctest: +SKIP
            1
        """
        columns = {name: [self[name]] for name in self._numbers()}
        return _show.framed(columns, dict(zip(columns, columns)), self.units)

    def to_xarray(self) -> Any:
        """Returns numbers and fields [y, x, component] as an xarray.Dataset.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> punch.to_xarray().traction.sel(component="z").dims
            ('y', 'x')
        """
        words = _show.described
        found: dict[str, Any] = {name: ((), self[name], words(self, name)) for name in self._numbers()}
        found["mean_traction"] = ("component", np.array(self["mean_traction"]), words(self, "mean_traction"))
        for name in ("displacement", "traction", "under_punch"):
            field = np.swapaxes(self[name], 0, 1)
            found[name] = (("y", "x", "component")[: field.ndim], field, words(self, name))
        places = {**_show.places(self.size, self.n, None), "component": ("component", self.components)}
        return _show.needed("xarray", "to_xarray").Dataset(found, places)

    def plot(self, field: str = "traction", component: str = "z", ax: Any = None) -> Any:
        """Draws a map of a field (a curve for a strip) with matplotlib. Returns the axes.

        Args:
            field: "traction", "displacement", or "under_punch", which has no components.
            component: a name in `components`.
            ax: axes to draw into; new ones by default.

        Raises:
            InputError: an unknown field or component. Error: matplotlib is not installed.

        Example:
            >>> ax = punch.plot("displacement", "x")
        """
        if field not in ("traction", "displacement", "under_punch"):
            raise InputError(f"field is {shown(field)}; it must be 'traction', 'displacement' or 'under_punch'")
        if field == "under_punch":
            return _show.map_of(self[field], self.size, field, None, self.units, ax)
        values = self[field][..., _place("component", component, self.components)]
        return _show.map_of(values, self.size, field, component, self.units, ax)

    def _numbers(self) -> list[str]:
        return [name for name, value in self.items() if name in self._declared() and np.ndim(value) == 0]

    def interior(self, depths: Optional[Sequence[Quantity]] = None, **options: Unpack[InteriorOptions]) -> FieldsBelow:
        """Returns displacement, strain and stress below the punch; see `gfmd.interior`.

        Args:
            depths: depths below the surface, length.
            options: further arguments of `gfmd.interior`.

        Raises:
            InputError: as in `gfmd.interior`.

        Example:
            >>> punch.interior(depths=[0.1]).stress.shape
            (1, 32, 32, 6)
        """
        return interior(self, depths, **options)

    def _loading(self) -> tuple[dict[str, Any], Any]:
        # Summed in the same order as in the program.
        columns = self.traction.reshape(-1, self.traction.shape[-1]).T
        mean_traction = [float(np.cumsum(column)[-1] / column.size) for column in columns]
        keys = {"size": [self.size[0]], "mean_traction": mean_traction}
        return {**keys, **_elastic(self, self.get("layer", ()))}, self.displacement


class FieldsBelow(Computed):
    """Fields below a surface; only the requested ones are present.

    Attributes:
        displacement: [depth, x, y, component], length.
        strain, stress: [depth, x, y, tensor] with xx, yy, zz, yz, xz, xy (xx, yy, zz, xz below a line); engineering
            shear strains, dimensionless; stress.
        von_mises: [depth, x, y], stress.
        energy_density: [depth, x, y], stress.
        levels: a Record for each depth: `depth`, `max_displacement`, `max_von_mises`, `mean_energy_density`.
        mean_traction: stress by component: the mean of xz, yz, zz (xz, zz below a line) on the surface and at every
            depth.
        n, size: points and lengths along x and y.
        warnings: a Record for each warning of the computation: `code`, `text`.

    If the contact surface has units, `unit` and `stress_unit` are their names. A slice (along=) has no axis across it;
    fields below a line have no y axis.

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
    size: list[float]
    warnings: list[Record]
    _main = ("displacement", "strain", "stress", "von_mises", "energy_density", "mean_traction")

    def __repr__(self) -> str:
        names = [name for name in self._main if name in self]
        fields = [f"{name:<14} {self._text(name, self[name])}" for name in names]
        columns = {}
        for name, values in self._numbers().items():
            factor, head = label(name, name, values, self.units)
            columns[head] = [f"{value * factor:.6g}" for value in values]
        rows = table(columns, LINES - 2 - len(fields))
        title = f"{type(self).__name__} at {len(self.levels)} depth{'s' if len(self.levels) != 1 else ''}"
        return title + rows + "".join(f"\n  {line}" for line in fields)

    def to_dataframe(self) -> Any:
        """Returns the numbers as a pandas.DataFrame with one row per depth; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> len(c.interior(depths=[0.01, 0.02]).to_dataframe())  # doctest: +SKIP
            2
        """
        columns = self._numbers()
        return _show.framed(columns, dict(zip(columns, columns)), self.units)

    def to_xarray(self) -> Any:
        """Returns fields [depth, y, x], with a component axis, and numbers [depth] as an xarray.Dataset.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> c.interior(depths=[0.01, 0.02]).to_xarray().stress.sel(tensor="zz").dims
            ('depth', 'y', 'x')
        """
        units = self.units
        planar = ("depth", *reversed(self._axes()))
        found: dict[str, Any] = {}
        for name in ("displacement", "strain", "stress", "von_mises", "energy_density"):
            if name in self:
                values = np.swapaxes(self[name], 1, 2) if len(planar) == 3 else self[name]
                last = {"displacement": "component", "strain": "tensor", "stress": "tensor"}.get(name, "")
                found[name] = ((*planar, last)[: values.ndim], values, attributes(name, units))
        numbers_of = self._numbers()
        depth = numbers_of.pop("depth")
        for name, values in numbers_of.items():
            found[name] = ("depth", values, attributes(name, units))
        found["mean_traction"] = ("component", self.mean_traction, attributes("mean_traction", units))
        cell = _show.places(self.size, self.n, units[0])
        places = {
            **{axis: cell[axis] for axis in self._axes()},
            "depth": ("depth", depth, attributes("depth", units)),
            "component": ("component", self._vector()),
            "tensor": ("tensor", self._tensor()),
        }
        used = {dimension for dimensions, *_ in found.values() for dimension in np.atleast_1d(dimensions)}
        return _show.needed("xarray", "to_xarray").Dataset(
            found, {name: place for name, place in places.items() if name in used}
        )

    def plot(
        self, field: Optional[str] = None, component: Optional[str] = None, level: Optional[int] = None, ax: Any = None
    ) -> Any:
        """Draws a field with matplotlib: a map at one depth; below a line or in a slice, a curve. Returns the axes.

        Args:
            field: "von_mises", "energy_density", "displacement", "strain" or "stress"; by default the first of these
                that was requested.
            component: "x", "y", "z" of the displacement, "xx", "zz", "xz" ... of strain and stress; along z by default.
            level: depth index; by default the depth with the largest value.
            ax: axes to draw into; new ones by default.

        Raises:
            InputError: an unknown field, component or level. Error: matplotlib is not installed.

        Example:
            >>> ax = c.interior(depths=[0.01, 0.02]).plot("stress", "xz", level=0)
        """
        there = [name for name in ("von_mises", "energy_density", "displacement", "strain", "stress") if name in self]
        field = there[0] if field is None else field
        if field not in there:
            raise InputError(f"field is {shown(field)}; it must be one of {', '.join(there)}")
        values = self[field]
        if field in ("displacement", "strain", "stress"):
            vector = field == "displacement"
            component = component or ("z" if vector else "zz")
            names = self._vector() if vector else self._tensor()
            values = values[..., _place("component", component, names)]
        elif component is not None:
            raise InputError(f"component is {shown(component)}; it must be left out for {field}")
        if level is None:
            level = int(np.argmax(np.abs(values).reshape(len(values), -1).max(axis=1)))
        index = integer("level", level, 0, len(values) - 1)
        axes = self._axes()
        size = [dict(zip("xy", self.size))[axis] for axis in axes]
        plane = values[index] if len(axes) == 2 else values[index][:, np.newaxis]
        ax = _show.map_of(plane, size, field, component, self.units, ax, axes[0])
        ax.set_title(f"depth {self.levels[index]._text('depth', self.levels[index].depth)}")
        return ax

    def _numbers(self) -> dict[str, list[float]]:
        """Returns the numbers per depth by name, without fields that were not requested."""
        return {
            name: [level[name] for level in self.levels] for name in self.levels[0] if self.levels[0][name] is not None
        }

    def _axes(self) -> list[str]:
        """Returns the axes of the points, without an axis across a slice or a y axis below a line."""
        across = self["slice"][0] if "slice" in self else "y" if self.n[1] == 1 else ""
        return [axis for axis in "xy" if axis != across]

    def _vector(self) -> list[str]:
        """Returns the names of the components of displacement and traction."""
        return list("xyz" if len(self.mean_traction) == 3 else "xz")

    def _tensor(self) -> list[str]:
        """Returns the names of the components of strain and stress."""
        return ["xx", "yy", "zz", "yz", "xz", "xy"] if len(self.mean_traction) == 3 else ["xx", "yy", "zz", "xz"]


class Green(Measured):
    """Elasticity of one wave vector: traction = K u with u = exp(+i q r). Infinite entries are NaN.

    Attributes:
        stiffness: complex [component, component], stress/length. compliance: its inverse, length/stress.
        normal_compliance, normal_stiffness: values without friction, length/stress and stress/length.
        displacement_transfer: complex [component, component], displacement inside divided by surface displacement.
        stress_transfer: complex [tensor, component], stress/length. stress_components: names of its rows.
        warnings: always empty.
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


@taking(PunchOptions)
def punch(body: Optional[Body] = None, **options: Unpack[PunchOptions]) -> Punch:
    """Presses a flat rigid punch into a body. Solves for all displacement and traction components.

    Args:
        body: the body; by default as in `gfmd punch` (E = 70, Poisson's ratio 0.33, height = size).
        size: side of the cell, length.
        n: number of points along a side; by default 128, or the size of the mask.
        dim: 3 for a square punch, 2 for a strip.
        punch_fraction: punch width divided by cell width, 0.25 by default; or
        mask: punch shape, [n, n], or [n] for a strip: nonzero at points under it.
        depth: indentation depth, length.
        contact: contact condition under the punch, "sticking" or "frictionless".
        nodes: "strict" (default) excludes points on the edge of the punch, "inclusive" includes them.
        shift: lateral displacement (x, y) of a sticking punch, length; (x,) for a strip.
        traction: prescribed traction outside the punch, stress, [n, n, 3], or [n, 2] for a strip.
        solver: solution method, "auto", "cg", "verlet", "verlet-critical", "verlet-modes" or "fire".
        dt: time step of "verlet-critical" and "verlet-modes", divided by its stability limit without damping.
        damping: damping of "verlet-critical", divided by the critical damping of the softest mode; or three numbers,
            one for each component, divided by the critical damping of its uniform mode.
        history: record every step in `history`: arrays `iteration`, `residual` and `energy` (NaN if the method moves
            no displacement).
        history_modes: displacement modes (m, n, component) to record in `history.modes`, such as (1, 0, "x").
        history_points: points (x, y, component) whose displacement to record in `history.points`; x, y in length.
        tolerance: largest allowed residual, 1e-15 to 0.1.
        max_iterations: largest number of iterations.
        refine: number of grids, each twice as fine as the one before, from which to extrapolate the mean pressure.
        threads: number of threads; all cores by default.
        out: HDF5 file to write, as with `gfmd punch --out`. Unlike `save`, it checks the name first.

    Raises:
        InputError: invalid arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Punch so far.

    Example:
        >>> punch = gfmd.punch(n=32, nodes="inclusive")
        >>> round(punch.mean_pressure, 3)
        0.115
    """
    for name in ("punch_fraction", "nodes"):
        if "mask" in options and name in options:
            raise InputError(f"mask and {name} are both given; give one of the two")
    given = None if body is None else as_body(body, of_moduli=True)
    modes, points = options.pop("history_modes", ()), options.pop("history_points", ())
    arrays = {"mask": options.pop("mask", None), "traction": options.pop("traction", None)}
    threads, out = options.pop("threads", None), options.pop("out", None)
    problem: dict[str, Any] = {} if given is None else _elastic(given, given.layers)
    problem.update(options, history_mode=[], history_point=[])
    for first, second, component in _threes("history_modes", modes):
        numbers_of = [integer("history_modes", entry, -(2**31), 2**31 - 1) for entry in (first, second)]
        problem["history_mode"].append([*numbers_of, word("history_modes", component)])
    for first, second, component in _threes("history_points", points):
        position = [number("history_points", entry) for entry in (first, second)]
        problem["history_point"].append([*position, word("history_points", component)])
    arrays = {name: None if value is None else array(name, value) for name, value in arrays.items()}
    values, failure, fields, file = _command.solve("punch", problem, arrays, threads, out)
    return _command.ended(punch_of(values, fields, file), failure)


def punch_of(values: dict[str, Any], fields: Mapping[str, Array], file: File | Contents) -> Punch:
    """Makes a punch from the report of the command, its fields and the file."""
    if values["height"] == "inf":
        values["height"] = math.inf
    for name in ("mask", "traction"):
        values.pop(name, None)
    if "history" in values:
        values["history"] = _history(values["history"])
    reported = {name: _command.records(value) for name, value in values.items()}
    return Punch({**reported, **fields}, file)


def _place(name: str, value: object, allowed: Sequence[str]) -> int:
    """Returns the index of a name in a list."""
    if value not in allowed:
        raise InputError(f"{name} is {shown(value)}; it must be one of {', '.join(allowed)}")
    return list(allowed).index(str(value))


def _threes(name: str, rows: Any) -> list[tuple[Any, Any, Any]]:
    try:
        return [(first, second, component) for first, second, component in rows]
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{name} is {shown(rows)}; it must have entries of three: two numbers and a component"
        ) from error


def _history(values: dict[str, Any]) -> dict[str, Any]:
    """Converts a solver history to arrays, with NaN in place of null."""

    def reported(name: str, value: Any) -> Any:
        if name in ("modes", "points"):
            return [{name: reported(name, entry) for name, entry in row.items()} for row in value]
        return value if name in ("mode", "point", "component") else np.array(value, dtype=np.float64)

    return {name: reported(name, value) for name, value in values.items()}


@taking(InteriorOptions)
def interior(
    source: Loaded, depths: Optional[Sequence[Quantity]] = None, **options: Unpack[InteriorOptions]
) -> FieldsBelow:
    """Computes displacement, strain and stress below a contact or punch.

    Args:
        source: a contact (its frictionless lateral surface displacement is added) or a punch.
        depths: depths below the surface, length, or strings with a unit; or
        levels: number of evenly spaced depths from the surface to the base or to `deepest`.
        deepest: depth of the lowest level, length.
        quantities: any of "displacement", "strain", "stress", "von-mises", "energy-density"; all by default.
        along: "y=Y" or "x=X" to compute only the nearest row of points.
        threads: number of threads; all cores by default.
        out: HDF5 file to write, as with `gfmd body --out`. Unlike `save`, it checks the name first.

    Raises:
        InputError: depths outside the body, an unknown quantity.
        Interrupted: no partial result is kept.

    Example:
        >>> below = gfmd.interior(punch, depths=[0.1, 0.2])
        >>> below.stress.shape, len(below.levels)
        ((2, 32, 32, 6), 2)
    """
    if (depths is None) == ("levels" not in options):
        raise InputError("the depths must be given by one of depths, levels")
    if depths is not None and "deepest" in options:
        raise InputError("depths and deepest are both given; deepest goes with levels")
    threads, out, along = options.pop("threads", None), options.pop("out", None), options.pop("along", None)
    quantities = options.pop("quantities", TABLES["InteriorOptions"]["quantities"]["default"])
    problem: dict[str, Any] = dict(
        depths=None if depths is None else lengths("depths", depths), slice=along, quantities=quantities, **options
    )
    if not isinstance(source, Loaded):
        raise InputError(f"source is {type(source).__name__}; it must be a Contact or a Punch")
    own, given = source._loading()
    values, failure, fields, file = _command.solve("body", {**problem, **own}, {"surface": given}, threads, out)
    named = {name.replace("-", "_") for name in problem["quantities"]}
    found = {name: field for name, field in fields.items() if name in named}
    return _command.ended(below_of(values, found, file), failure)


def below_of(values: dict[str, Any], fields: Mapping[str, Array], file: File | Contents) -> FieldsBelow:
    """Makes fields below a surface from the report of the command, the fields and the file."""
    del values["surface"]
    reported = {name: _command.records(value) for name, value in values.items()}
    units = known(values.get("unit"), values.get("stress_unit"))
    reported["levels"] = [Record(level, units) for level in values["levels"]]
    return FieldsBelow({**reported, **fields}, file)


def _elastic(values: Any, layers: Sequence[Sequence[Any]]) -> dict[str, Any]:
    """Returns the configuration keys of a body and the layers below the top one."""
    given = getattr(values, "_given", (None, 0.0, None, None))
    # Keeps a quantity with a unit, so that the error names it: the lengths have no unit.
    young = next((modulus for modulus in (given[0], given[2]) if isinstance(modulus, str)), values.young)
    elastic = {"young": young, "poisson": values.poisson, "height": _command.height_key(values.height)}
    return {**elastic, **_command.other_keys(values, layers)}


@taking(GreenOptions)
def green(body: Body, *, qx: float, **options: Unpack[GreenOptions]) -> Green:
    """Computes the elasticity of one wave vector: `stiffness`, `compliance` (complex matrices), `normal_compliance`.

    Args:
        body: the body, on any base.
        qx, qy: wave vector components, rad/length.
        dim: 3, or 2 for plane strain.
        z: height above the base, length; or
        depth: depth below the surface, length, of `displacement_transfer` and `stress_transfer`.

    Raises:
        InputError: a value out of range.

    Example:
        >>> gfmd.green(gfmd.Body(), qx=3.0, qy=4.0).normal_compliance
        0.4
        >>> coating = gfmd.Body(height=0.1, base="half-space", base_young=10.0, base_poisson=0.2)
        >>> round(gfmd.green(coating, qx=3.0, depth=0.1).normal_compliance, 4)
        0.1627
    """
    given = as_body(body, of_moduli=True)
    if "z" in options and "depth" in options:
        raise InputError("z and depth are both given; give one of the two")
    problem = dict(**_elastic(given, given.layers), qx=number("qx", qx), **options)
    values, *_ = _command.solve("green", problem)
    for name in ("stiffness", "compliance", "displacement_transfer", "stress_transfer"):
        if values.get(name) is not None:
            pairs = np.array(values[name], dtype=np.float64)
            values[name] = pairs[..., 0] + 1j * pairs[..., 1]
            values[name].flags.writeable = False
    return Green({name: math.nan if value is None else value for name, value in values.items()})
