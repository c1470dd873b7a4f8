"""Contacts at rest, single and in sequence."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _gfmd, _hints, _leak, _show
from ._below import FieldsBelow, interior
from ._body import Body, Law
from ._check import CONDUCTIVITY, Array, Quantity, array, frozen, in_units, number, shown, word
from ._columns import Fields, LowerFace, Numbers, Patches
from ._errors import InputError
from ._load import Residual, of_load, residual_of_all
from ._measured import Measured
from ._record import LINES, Record, json_of, reason_of, same, table, without_null
from ._result import Result
from ._surface import Surface
from ._units import Units, known, label, metre

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options_inside import InteriorOptions


class Settings(NamedTuple):
    """Options of a contact, besides surface, body and law."""

    # Options by their keys in a file, and the values that are arrays.
    description: dict[str, Any]
    arrays: dict[str, Array]
    lower_surface: Optional[Surface] = None
    # Key and value of the prescribed quantity.
    load: Optional[tuple[str, float]] = None


class Flow(Measured):
    """Flow of a fluid through the gap of a contact, from `Contact.flow`.

    Attributes:
        conductivity: [[xx, xy], [yx, yy]], dimensionless: mean flux along x and y (rows) under a pressure gradient
            along x and y (columns), divided by the flux through a uniform gap of height `mean_gap`. NaN if the gap is
            closed.
        percolates: True if the gap is open to flow along x, along y.
        residual: upper minus lower bound of the conductivity, divided by the conductivity; larger of x and y.
        transmissivity: conductivity times mean_gap³/12, length³; zero if the gap is closed.
        conductivity_limit, conductivity_limit_error, conductivity_grid_error: estimate on an infinitely fine grid, its
            error and the grid error, on the diagonal; NaN if unknown. Absent with `grid_error="none"`.

    Example:
        >>> c.flow().conductivity.shape
        (2, 2)
    """

    conductivity: Array
    percolates: list[bool]
    residual: float
    transmissivity: Array
    conductivity_limit: Array
    conductivity_limit_error: Array
    conductivity_grid_error: Array
    _main = ("conductivity", "percolates", "transmissivity", "residual")

    def _text(self, name: str, value: Any) -> str:
        if name != "conductivity" or "conductivity_limit" not in self:
            return super()._text(name, value)
        limits, errors = (self[f"{name}_{part}"].tolist() for part in ("limit", "limit_error"))
        cells = [
            [
                _gfmd.with_limit(entry, limits[i][j], errors[i][j]) if i == j else f"{entry:.3g}"
                for j, entry in enumerate(row)
            ]
            for i, row in enumerate(value.tolist())
        ]
        return f"[[{', '.join(cells[0])}], [{', '.join(cells[1])}]]"

    def _rest(self, count: int) -> str:
        return "grid errors: dict(r)"


class Adhesion(Measured):
    """Adhesion numbers of a law on the surface and grid of a contact, from `Contact.adhesion` (docs/laws/adhesion.md).

    Attributes:
        work: work of adhesion, stress * length.
        range, process_zone: range of the law and width of its process zone, length.
        process_zone_points, process_zone_needed: width of the process zone in grid steps, and the smallest width
            solved without `coarse`; dimensionless.
        wang_zhou_muser, tabor, pastewka_robbins: dimensionless numbers of adhesion.

    Example:
        >>> law = gfmd.law("morse", gamma=1e-4, range=5e-3)
        >>> gfmd.contact(s, gfmd.Body(), approach=0.001, law=law).adhesion().work
        0.0001
    """

    work: float
    range: float
    process_zone: float
    process_zone_points: float
    process_zone_needed: float
    wang_zhou_muser: float
    tabor: float
    pastewka_robbins: float


class Gradient(Measured):
    """Derivatives of a scalar L of a contact with respect to its inputs, from `Contact.vjp`.

    Attributes:
        heights: dL/d(height) at each point [x, y], unit of L divided by length; read-only.
        load: dL/d(mean pressure), or dL/d(approach) if the approach is `fixed`.
        modulus: dL/dE*, E* in stress, with all moduli of the body scaled together.
        hardness: dL/d(hardness), a number, or an array [x, y] if the hardness is one; with a hardness only.
        fixed: the prescribed load, "pressure" or "approach".
        error: relative error of the linear problem, at most 1e-8.

    Example:
        >>> c.vjp(elastic_energy=1.0).load > 0
        True
    """

    heights: Array
    load: float
    modulus: float
    hardness: Union[float, Array]
    fixed: str
    error: float


class Contact(Result, Numbers, Fields):
    """A contact at rest under one load. It is immutable and can be pickled.

    Numbers and fields are properties, defined in their docstrings; numbers are also keys of a mapping. An undefined
    number is NaN, with the reason in `undefined`. Lengths and stresses have the units of surface and body. With a law,
    `pressure` and `mean_pressure` include the attraction. With a lower surface, numbers and fields belong to the upper
    face.

    Attributes:
        surface, body, law: the arguments.
        undefined: reasons why numbers are NaN, by name; present only if there are any.

    Example:
        >>> c = gfmd.contact(s, gfmd.Body(), p_star=0.05)
        >>> c.pressure.shape, c.converged
        ((64, 64), True)
    """

    surface: Surface
    body: Body
    law: Law
    undefined: dict[str, str]
    _main = (
        "mean_pressure",
        "p_star",
        "approach",
        "area_fraction",
        "kappa",
        "mean_gap",
        "max_pressure",
        "stiffness",
        "elastic_energy",
        "plastic_fraction",
        "residual",
        "converged",
    )
    _settings: Settings
    _state: Any

    def __init__(
        self,
        values: dict[str, Any],
        parts: tuple[Surface, Body, Law],
        fields: dict[str, Array],
        settings: Settings,
        state: Any = None,
    ) -> None:
        super().__init__(values)
        names = ("surface", "body", "law", "_fields", "_settings", "_state")
        for name, value in zip(
            names, (*parts, {name: frozen(field) for name, field in fields.items()}, settings, state)
        ):
            object.__setattr__(self, name, value)
        if "lower" in values:
            self._values["lower"] = LowerFace(values["lower"], self.units)

    def __reduce__(self) -> tuple[Any, ...]:
        return Contact, (self._values, (self.surface, self.body, self.law), self._fields, self._settings)

    @property
    def boundary(self) -> str:
        """Boundary condition at the edges of the surface by name, "periodic" or "free"."""
        return str(self._settings.description["boundary"])

    @property
    def hardness(self) -> Union[float, Array, None]:
        """Hardness, the largest pressure (stress), a number or an array [x, y]; None without one."""
        return self._settings.arrays.get("hardness", self._settings.description.get("hardness"))

    @property
    def components(self) -> str:
        """Displacement components solved for, by name ("normal", "all", "held")."""
        return str(self._settings.description.get("components", "normal"))

    @property
    def finite_slope(self) -> bool:
        """True if finite slopes were allowed, so that points of the body met the height where displaced."""
        return bool(self._settings.description.get("finite_slope"))

    @property
    def lower_surface(self) -> Optional[Surface]:
        """Second rigid surface, below the slab, on the same points; None without one."""
        return self._settings.lower_surface

    @property
    def repulsion(self) -> Array:
        """Repulsive part of the pressure [x, y], stress. Read-only.

        With a law, it is the wall pressure or, without a wall, the pressure above the equilibrium residual. Without a
        law, it is the pressure.
        """
        own = self._fields.get("repulsion")
        return frozen(np.maximum(self.pressure, 0.0)) if own is None else own

    def adhesion(self) -> Optional[Adhesion]:
        """Returns the adhesion numbers on this surface and grid, by name; None without attraction.

        Example:
            >>> c.adhesion() is None
            True
        """
        if self.law.name == "hard-wall":
            return None
        problem, arrays = self._settings[:2]
        found = json.loads(_gfmd.adhesion(problem, {**arrays, "surface": self.surface.heights}))
        return None if found is None else Adhesion(without_null(found), self.units)

    @property
    def touching(self) -> npt.NDArray[np.bool_]:
        """True at points in contact [x, y], where the surfaces repel; `area_fraction` is their share."""
        found: npt.NDArray[np.bool_] = np.asarray(self.repulsion > 0.0)
        found.flags.writeable = False
        return found

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if (
            not isinstance(other, Contact)
            or self.surface != other.surface
            or self._fields.keys() != other._fields.keys()
        ):
            return False
        return (
            (self.body, self.law) == (other.body, other.law)
            and same(self, other)
            and all(np.array_equal(field, other._fields[name]) for name, field in self._fields.items())
        )

    def __hash__(self) -> int:
        return hash((self.surface.n, self.body, self.iterations))

    @property
    def units(self) -> Units:
        """Length unit and stress unit of all numbers, None if unknown."""
        return known(self.surface.unit, self._settings.description.get("stress_unit"))

    def _units_shown(self) -> Units:
        return self.units

    def reason(self, name: str) -> Optional[str]:
        """Returns why a number is NaN; None if it has a value.

        Args:
            name: name of a number.

        Raises:
            InputError: no such number.

        Example:
            >>> gfmd.contact(s, gfmd.Body(), p_star=10.0).reason("stiffness")[:8]
            'infinite'
        """
        return reason_of(self, name)

    def _title(self) -> str:
        law = "" if self.law.name == "hard-wall" else f", law {self.law.name}"
        nx, ny = self.surface.n
        return f"Contact of {nx} x {ny} points{law}; value(error of the last digits), ~ if not known"

    def _rest(self, count: int) -> str:
        return f"{count} more numbers: dict(c); fields: {', '.join(self._fields)}"

    def _posed(self) -> tuple[Any, Any]:
        """Sets up the problem again. Returns it with the state."""
        settings = self._settings
        problem = _gfmd.Problem(
            {**settings.description, "unit": self.surface.unit}, {**settings.arrays, "surface": self.surface.heights}, 0
        )
        return problem, problem.recall(self._fields, self.approach) if self._state is None else self._state

    def _measured(self, **options: Any) -> tuple[dict[str, Any], dict[str, tuple[Array, Array]]]:
        """Measures statistics and flow. Returns the numbers, and the statistics arrays with their axes by path."""
        problem, state = self._posed()
        record, arrays = problem.measure(state, options)
        found = {
            entry["path"]: (frozen(np.array(entry["values"])), frozen(np.array(entry["axis"]))) for entry in arrays
        }
        return of_load(record), found

    def patches(self) -> Patches:
        """Measures the contact patches, as `gfmd contact --statistics` does. Returns a `Record` of arrays [patch].

        Raises:
            InputError: a contact with a lower surface (two faces).

        Example:
            >>> c.patches().area.sum() < 1.0
            np.True_
        """
        arrays = self._measured(statistics=True)[1]
        names = {path.split("/")[2]: values for path, (values, _) in arrays.items() if path.startswith("/patches/")}
        return Patches({name: values for name, values in names.items() if name != "load"})

    def distributions(self) -> Record:
        """Measures distributions and spectra, as `gfmd contact --statistics` does. Returns a `Record` of arrays.

        Probability densities over the whole surface: `pressure` (1/stress) against `pressure_at` (stress), `gap`
        (1/length) against `gap_at` (length). Periodic boundaries add `pressure_spectrum` (stress² length²) against
        `wavenumber` (rad/length), and the pressure autocorrelation, `autocorrelation_x` and `autocorrelation_y`,
        against `lag_x` and `lag_y` (length).

        Raises:
            InputError: a contact with a lower surface (two faces).

        Example:
            >>> d = c.distributions()
            >>> d.pressure.shape == d.pressure_at.shape
            True
        """
        found = {}
        axes = {
            "/spectra/pressure": "wavenumber",
            "/spectra/autocorrelation_x": "lag_x",
            "/spectra/autocorrelation_y": "lag_y",
        }
        for path, (values, axis) in self._measured(statistics=True)[1].items():
            name = path.split("/")[2]
            if path in axes and len(values):
                found[axes[path]] = axis
                found["pressure_spectrum" if name == "pressure" else name] = values
            elif path.startswith("/distributions/"):
                found[name] = values
        return Record(found)

    @_hints.hinted
    def flow(self) -> Flow:
        """Computes fluid flow through the gap by Reynolds' equation, as `gfmd contact --flow` does.

        Returns:
            Conductivity, percolation and transmissivity as a `Flow`. See `leak_rate` for the volume per time.

        Raises:
            InputError: a profile, a lower surface.

        Example:
            >>> flow = c.flow()
            >>> flow.percolates, flow.transmissivity.shape
            ([True, True], (2, 2))
        """
        found = dict(self._measured(flow=True)[0]["flow"])
        for name in ("conductivity", *(f"conductivity_{part}" for part in ("limit", "limit_error", "grid_error"))):
            if name in found:
                found[name] = frozen(np.array(found[name], dtype=np.float64))
        through = _leak.transmissivity(
            found["conductivity"], np.array(found["percolates"])[:, np.newaxis], self.mean_gap
        )
        found["transmissivity"] = frozen(through)
        return Flow(found, self.units)

    @_hints.hinted
    def leak_rate(
        self, *, viscosity: Optional[Quantity] = None, pressure_drop: Quantity, fluid: Optional[str] = None
    ) -> Array:
        """Returns the leak rate (volume per time) through the gap of the whole cell along x and along y, [2].

        Args:
            viscosity: fluid viscosity, Pa s, or a string with a unit, such as "1 mPa*s"; in stress * time if the length
                unit is unknown.
            pressure_drop: pressure drop over the length of the cell along the flow, Pa, or a string with a unit, such
                as "1 bar"; in stress if the length unit is unknown.
            fluid: fluid name, such as "water", in place of `viscosity`; `gfmd materials` lists them.

        Returns:
            Leak rates in m³/s; 1e-6 m³/s is 1 ml/s (length³/time if the length unit is unknown). Zero if the gap is
            closed.

        Raises:
            InputError: a profile, a lower surface; arguments that are not positive; an unknown fluid.

        Example:
            >>> c.leak_rate(viscosity=1e-3, pressure_drop=1e5).shape
            (2,)
        """
        along = np.diag(self.flow().transmissivity)
        of = (fluid, viscosity)
        return frozen(_leak.rate(along, self.surface.size, metre(self.surface.unit), of, pressure_drop))

    def conductance(
        self, k1: Optional[Quantity] = None, k2: Optional[Quantity] = None, *, conductor_height: Quantity = float("inf")
    ) -> float:
        """Returns the conductance per area of the points in contact, for heat or current, 1 / length.

        Given the conductivities of both conductors, it returns the contact conductance: W/(m² K) for heat, S/m² for
        current.

        Without them it is the column `conductance` of `gfmd contact --statistics`: divided by the sum of both
        resistivities, it is the contact conductance per area. It excludes the bulk resistance; with free boundaries it
        is the total current divided by the patch area and the total potential difference. It is valid for any elastic
        body, hardness and law. Infinite if all points of a periodic surface touch. NaN for a profile with free
        boundaries on infinite conductors, with finite slopes, and with a lower surface.

        Args:
            k1, k2: conductivities of both conductors, W/(m K) or S/m, or strings with a unit ("0.2 W/(m K)"); both or
                neither. Per unit length of the surface if the length unit is unknown.
            conductor_height: electrode depth in both conductors below the surface, length, or a string with a unit;
                infinite by default.

        Raises:
            InputError: a depth that is not positive; with free boundaries, an electrode that is not deep enough.

        Example:
            >>> c.conductance() < c.conductance(conductor_height=0.1)
            True
        """
        height = in_units("conductor_height", conductor_height, None, self.surface.unit, None)
        found = _gfmd.conductance(self.touching, self.surface.size, self.boundary, height)
        if self.finite_slope or self.lower_surface is not None:
            return math.nan
        if k1 is None and k2 is None:
            return found
        first, second = in_units("k1", k1, CONDUCTIVITY), in_units("k2", k2, CONDUCTIVITY)
        if not (0.0 < first < math.inf and 0.0 < second < math.inf):
            raise InputError(f"k1 and k2 are {k1!r}, {k2!r}; they must be positive and finite")
        return found / (1.0 / first + 1.0 / second) / metre(self.surface.unit)

    @_hints.hinted
    def gas_conductance(
        self,
        gas: Optional[Literal["air", "nitrogen", "argon", "helium", "hydrogen"] | str] = None,
        *,
        temperature: Optional[Quantity] = None,
        pressure: Optional[Quantity] = None,
        accommodation: Optional[float | Sequence[float]] = None,
        conductivity: Optional[Quantity] = None,
        jump: Optional[Quantity] = None,
    ) -> float:
        """Returns the conductance per area of the gas in the gap, W/(m² K), as `gfmd contact --gas` does.

        It is the mean of k/(g + M) over all points, with gas conductivity k, gap g and temperature-jump length M;
        points in contact contribute nothing. It excludes radiation. A joint in a gas conducts this plus
        `conductance(k1, k2)`.

        Args:
            gas: gas name; the surface must have a length unit.
            temperature: gas temperature, 200 to 1000 K, or a string with a unit; 300 K by default.
            pressure: gas pressure, Pa, at most 1 MPa, or a string with a unit ("10 kPa"); 101325 Pa by default.
            accommodation: thermal accommodation coefficients of both surfaces, or one number for both; by default
                for engineering surfaces: air 0.86, nitrogen 0.85, argon 0.85, helium 0.37, hydrogen 0.29.
            conductivity: conductivity of a gas defined by numbers, W/(m K), or a string with a unit.
            jump: temperature-jump length of that gas, in units of the surface, or a string with a unit.

        Raises:
            InputError: a lower surface (two gaps); finite slopes; a gas state without known properties; numbers that
                are not positive; a gas defined twice or not at all.

        Example:
            >>> c.gas_conductance(conductivity=0.026, jump=1e-4) > 0.0
            True
        """
        if self.finite_slope or self.lower_surface is not None:
            raise InputError("with finite slopes or a lower surface, the gap is not one layer of gas")
        unit = self.surface.unit
        state = (temperature, pressure, accommodation)
        if gas is not None:
            if conductivity is not None or jump is not None:
                raise InputError("gas is given; it must be left out with conductivity and jump")
            if unit is None:
                raise InputError(
                    f"gas is {gas!r}; it needs the length unit of the surface, or conductivity and jump in its place"
                )
            kelvin = None if temperature is None else in_units("temperature", temperature, "temperature")
            pascal = None if pressure is None else in_units("pressure", pressure, "stress")
            both = None if accommodation is None else [*np.broadcast_to(accommodation, 2).astype(float)]
            k, m = _gfmd.gas_in_gap(gas, kelvin, pascal, None if both is None else (both[0], both[1]))
            m /= metre(unit)
        else:
            if conductivity is None or jump is None:
                raise InputError("gas is missing; it must be a name, or conductivity and jump in its place")
            if any(number is not None for number in state):
                raise InputError("temperature, pressure and accommodation must be left out without gas")
            k = in_units("conductivity", conductivity, CONDUCTIVITY)
            m = in_units("jump", jump, "length", unit, None)
            if not (0.0 < k < math.inf and 0.0 < m < math.inf):
                raise InputError(
                    f"conductivity and jump are {conductivity!r}, {jump!r}; they must be positive and finite"
                )
        return _gfmd.gas_conductance(self.touching, self.gap, k, m) / metre(unit)

    def vjp(
        self,
        *,
        pressure: Optional[npt.ArrayLike] = None,
        gap: Optional[npt.ArrayLike] = None,
        approach: float = 0.0,
        mean_pressure: float = 0.0,
        mean_gap: float = 0.0,
        elastic_energy: float = 0.0,
        plastic_depth: Optional[npt.ArrayLike] = None,
        fixed: Optional[Literal["pressure", "approach"] | str] = None,
    ) -> Gradient:
        """Returns the derivatives of a scalar L of this contact with respect to heights, load and modulus.

        The arguments are the derivatives of L with respect to fields and numbers of the contact; the result is the
        vector-Jacobian product of reverse-mode differentiation. It takes one linear solve for any number of heights.
        The points in contact, and those at the hardness, are fixed, which is exact for almost all surfaces and loads;
        areas and point counts have no derivatives. `gfmd.torch` and `gfmd.jax` wrap the contact as a differentiable
        function.

        Args:
            pressure: dL/d(pressure) at each point [x, y], unit of L divided by stress; 0 by default, like all others.
            gap: dL/d(gap) at each point [x, y]; ignored at points pressed by a wall.
            approach: dL/d(approach).
            mean_pressure: dL/d(mean pressure).
            mean_gap: dL/d(mean gap).
            elastic_energy: dL/d(elastic energy per area).
            plastic_depth: dL/d(plastic depth) at each point [x, y]; with a hardness.
            fixed: load kept constant while heights and modulus change, "pressure" or "approach"; by default the
                prescribed load of the contact ("pressure" for `p_star`).

        Raises:
            InputError: arrays of the wrong shape; a contact with finite slopes, all components, a lower surface or a
                base that moves (not implemented); full contact under an approach that does not determine
                the pressure; a state of a law in which a small change causes a jump.

        Example:
            >>> round(c.vjp(approach=1.0).load * c.stiffness, 4)  # d(approach)/d(mean pressure)
            1.0
            >>> c.vjp(mean_gap=1.0).heights.shape
            (64, 64)
        """
        driven = self._settings.load is not None and self._settings.load[0] == "approach"
        how = ("approach" if driven else "pressure") if fixed is None else word("fixed", fixed)
        if how not in ("pressure", "approach"):
            raise InputError(f"fixed is {how!r}; it must be 'pressure' or 'approach'")
        numbers = {
            "approach": approach,
            "mean_pressure": mean_pressure,
            "mean_gap": mean_gap,
            "elastic_energy": elastic_energy,
        }
        given = {"pressure": pressure, "gap": gap, "plastic_depth": plastic_depth}
        shape = self.pressure.shape
        fields = {}
        for name, value in given.items():
            if value is not None:
                found = array(name, value)
                fields[name] = (
                    found.reshape(shape) if found.ndim == 1 and found.shape == shape[:1] and shape[1] == 1 else found
                )
                if fields[name].shape != shape:
                    raise InputError(
                        f"{name} has the shape {list(found.shape)}; it must be {list(shape)}, the shape of the contact"
                    )
        problem, state = self._posed()
        heights, load, modulus, hardness, error = problem.vjp(
            state, how == "approach", fields, {name: number(name, value) for name, value in numbers.items()}
        )
        values = {"heights": frozen(heights), "load": load, "modulus": modulus, "fixed": how, "error": error}
        if hardness is not None:
            values["hardness"] = frozen(hardness) if isinstance(self.hardness, np.ndarray) else float(hardness.sum())
        return Gradient(values)

    def interior(self, depths: Optional[Sequence[Quantity]] = None, **options: Unpack[InteriorOptions]) -> FieldsBelow:
        """Returns displacement, strain and stress below the surface; see `gfmd.interior`.

        Args:
            depths: depths below the surface, length.
            options: further arguments of `gfmd.interior`.

        Raises:
            InputError: as in `gfmd.interior`.

        Example:
            >>> c.interior(depths=[0.01, 0.02]).von_mises.shape
            (2, 64, 64)
        """
        return interior(self, depths, **options)

    def to_dataframe(self) -> Any:
        """Returns the numbers as a pandas.DataFrame with one row; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> c.to_dataframe().shape[0]  # doctest: +SKIP
            1
        """
        return _show.frame([self])

    def _write(self, path: str) -> None:
        _save(path, [self])

    def _loading(self) -> tuple[dict[str, Any], Any]:
        shear = {f"mean_shear_{axis}": np.array(value) for axis, value in zip("xy", self.get("mean_shear", ()))}
        units = {"unit": self.surface.unit} if self.surface.unit else {}
        return {"size": list(self.surface.size)}, ({**_config([self]), **units}, {**self._fields, **shear})

    def to_xarray(self) -> Any:
        """Returns the fields [y, x] and scalars as an xarray.Dataset, with coordinates and units.

        In xarray's `.plot()`, x points to the right and y up.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> c.to_xarray().pressure.sel(x=0.5, method="nearest").shape
            (64,)
        """
        return _show.dataset([self]).isel(load=0)

    def to_pyvista(self) -> Any:
        """Returns a pyvista.ImageData with the height and the contact fields [x, y] as point data.

        Raises:
            Error: pyvista is not installed.

        Example:
            >>> c.to_pyvista().save("c.vti")  # doctest: +SKIP
        """
        return _show.grid(self.surface, {"height": self.surface.heights, **self._fields})

    def plot(self, field: str = "pressure", ax: Any = None) -> Any:
        """Draws a map of a field (a curve for a line contact) with matplotlib. Returns the axes.

        Args:
            field: "pressure", "gap", "displacement_z", or another field of the contact.
            ax: axes to draw into; new ones by default.

        Raises:
            InputError: an unknown field. Error: matplotlib is not installed.

        Example:
            >>> ax = c.plot("gap")
        """
        fields = self._fields
        if not isinstance(field, str) or field not in fields:
            raise InputError(f"field is {shown(field)}; it must be one of {', '.join(map(repr, fields))}")
        contact = self.touching if field == "gap" else None
        return _show.field(fields[field], self.surface, field, ax, self.units, contact)

    def _repr_html_(self) -> str:
        return self._pictures(self.pressure.size) + super()._repr_html_()


class Contacts(Result, Sequence[Contact]):
    """A sequence of `Contact`, one per load.

    Numbers become arrays [load], in the same units: `cs.area_fraction`, `cs.mean_pressure`. Each part of `residual` is
    an array, `lower` is a Record of arrays. Fields, such as `pressure`, `gap` and `displacement_z`, become arrays
    [load, x, y].

    Example:
        >>> cs = gfmd.contacts(s, gfmd.Body(), p_star=[0.01, 0.05])
        >>> cs.area_fraction.shape, cs.pressure.shape, cs[-1].p_star > cs[0].p_star
        ((2,), (2, 64, 64), True)
    """

    __slots__ = ("_contacts",)
    _contacts: tuple[Contact, ...]

    def __init__(self, contacts: Sequence[Contact]) -> None:
        object.__setattr__(self, "_contacts", tuple(contacts))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("Contacts cannot be changed")

    def __reduce__(self) -> tuple[Any, ...]:
        return Contacts, (self._contacts,)

    @overload
    def __getitem__(self, index: int) -> Contact: ...

    @overload
    def __getitem__(self, index: slice) -> Contacts: ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Contact, Contacts]:
        if isinstance(index, slice):
            return Contacts(self._contacts[index])
        return self._contacts[index]

    def __len__(self) -> int:
        return len(self._contacts)

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_") and self._contacts:
            if name in self._contacts[0]._fields:
                return frozen(np.stack([getattr(contact, name) for contact in self._contacts]))
            if name == "residual":
                return residual_of_all([contact.residual for contact in self._contacts])
            if name == "lower" and name in self._contacts[0]:
                faces = [contact.lower for contact in self._contacts]
                numbers = {
                    key: frozen(np.array([float(face[key]) for face in faces])) for key in faces[0] if key != "residual"
                }
                return Record({**numbers, "residual": residual_of_all([face.residual for face in faces])}, self.units)
            if name == "approach" or name in self._contacts[0]:
                return frozen(np.array([getattr(contact, name) for contact in self._contacts]))
        hint = "" if name.startswith("_") else _hints.attribute(name, dir(self))
        raise AttributeError(f"Contacts has no {name}{hint}")

    def __dir__(self) -> list[str]:
        first = self._contacts[:1]
        return [*super().__dir__(), "approach", *(name for contact in first for name in (*contact._fields, *contact))]

    def _write(self, path: str) -> None:
        _save(path, self._contacts)

    @property
    def units(self) -> Units:
        """Length unit and stress unit of all numbers, None if unknown."""
        return self._contacts[0].units if self._contacts else (None, None)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Contacts) and self._contacts == other._contacts

    def __hash__(self) -> int:
        return hash(self._contacts)

    def to_dataframe(self) -> Any:
        """Returns the numbers as a pandas.DataFrame with one row per load; units in `attrs["units"]`.

        Raises:
            InputError: an empty sequence. Error: pandas is not installed.

        Example:
            >>> cs.to_dataframe().kappa.shape  # doctest: +SKIP
            (2,)
        """
        self._check_some()
        return _show.frame(self._contacts)

    def to_xarray(self) -> Any:
        """Returns an xarray.Dataset: fields [load, y, x], scalars [load], with units.

        Raises:
            InputError: an empty sequence. Error: xarray is not installed.

        Example:
            >>> cs.to_xarray().area_fraction.dims
            ('load',)
        """
        self._check_some()
        return _show.dataset(self._contacts)

    def plot(self, ax: Any = None) -> Any:
        """Draws contact area against reduced pressure with matplotlib. Returns the axes.

        Args:
            ax: axes to draw into; new ones by default.

        Raises:
            InputError: an empty sequence. Error: matplotlib is not installed.

        Example:
            >>> ax = cs.plot()
        """
        self._check_some()
        return _show.area(self._contacts, ax)

    def _check_some(self) -> None:
        if not self._contacts:
            raise InputError("there are no contacts here")

    def _columns(self) -> dict[str, list[str]]:
        """Returns the cells of the table by heading."""
        found = {}
        for head, name in _HEADS.items():
            factor, shown = label(head, name, [contact[name] for contact in self._contacts], self.units)
            found[shown] = [_cell(contact, name, factor) for contact in self._contacts]
        found["residual"] = [f"{float(contact.residual):.1e}" for contact in self._contacts]
        return found

    def __repr__(self) -> str:
        return f"{len(self)} contacts{table(self._columns(), LINES - 2)}"

    def _repr_html_(self) -> str:
        pictures = self._pictures(sum(contact.pressure.size for contact in self._contacts))
        columns = self._columns()
        rows = [list(row) for row in zip(*columns.values())]
        return f"<b>{len(self)} contacts</b>{pictures}{_show.table_html(list(columns), rows)}"


# Columns of the table of contacts: heading and name.
_HEADS = {
    "pressure": "mean_pressure",
    "p_star": "p_star",
    "approach": "approach",
    "area": "area_fraction",
    "kappa": "kappa",
    "mean gap": "mean_gap",
    "iterations": "iterations",
}


def _cell(contact: Contact, name: str, factor: float) -> str:
    """Formats a number times a factor, to the digits that its grid error leaves certain, if it has a limit."""
    limit, error = contact.get(f"{name}_limit"), contact.get(f"{name}_limit_error", math.nan)
    if limit is None:
        return f"{contact[name] * factor:.6g}"
    return _gfmd.with_limit(contact[name] * factor, limit * factor, error * factor)


def _asked(contacts: Sequence[Contact]) -> dict[str, list[float]]:
    """Returns the prescribed loads, or the mean pressures if different quantities were prescribed."""
    given = [contact._settings.load for contact in contacts]
    if None not in given and len({load[0] for load in given if load}) == 1:
        return {given[0][0]: [load[1] for load in given if load]}  # type: ignore[index]
    return {"pressure": [contact["mean_pressure"] for contact in contacts]}


def _config(contacts: Sequence[Contact]) -> dict[str, Any]:
    """Returns the configuration of contacts of one surface, as a file stores it."""
    return {**contacts[0]._settings.description, **_asked(contacts)}


def _save(path: str, contacts: Sequence[Contact]) -> None:
    """Writes contacts of one surface to a file."""
    if not contacts:
        raise InputError("there are no contacts to write")
    first = contacts[0]
    problem, arrays, lower, _ = first._settings
    loads = [(json_of(contact._values), list(contact._fields.values())) for contact in contacts]
    words = [(surface.unit, surface.description) for surface in (first.surface, lower) if surface is not None]
    _gfmd.save(path, problem, {**arrays, "surface": first.surface.heights}, words, loads, _config(contacts))
