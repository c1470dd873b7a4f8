"""Steady sliding: hysteretic and interface friction, flash temperature."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _command, _show
from ._body import Body, as_body
from ._check import Array, frozen, kind_of, quantities, quantity, several, shown
from ._errors import InputError
from ._columns import StateFields, States
from ._given import taking
from ._load import Residual, residual_of
from ._options import SlideOptions
from ._path import drive_keys
from ._record import Record
from ._result import Computed, Contents, File
from ._surface import Surface, as_hardness, as_surface

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Slide(Computed, StateFields):
    """Steady states of a surface sliding over a body.

    Attributes:
        states: numbers of the states, every load at every velocity, a `Record` of arrays [state], with the residual
            parts as `residual_...`. Fields are NaN at states that were not reached.
        direction: unit vector of the velocity.
        prony, moduli, relaxes, young_long_term, young_instantaneous: relaxation of a viscoelastic body.
        hardness: given hardness, stress, a number or an array [x, y]; with a hardness only.
        grid_error: how the discretisation error was estimated: `mode`, `n`, `assumes`; with `grid_error="refine"` only.
        warnings: a Record for each warning of the computation: `code`, `text`.
        surface, n, size, unit, rms_gradient, rms_height, e_star: problem parameters.

    Example:
        >>> rubber = gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)])
        >>> gfmd.slide(gfmd.self_affine(n=32, eps_f_inv=4), rubber, velocity=[0.01, 1.0], p_star=0.05).pressure.shape
        (2, 32, 32)
    """

    states: States
    direction: list[float]
    prony: list[list[float]]
    moduli: str
    relaxes: str
    young_long_term: float
    young_instantaneous: float
    hardness: Union[float, Array]
    grid_error: Record
    surface: Surface
    n: list[int]
    size: list[float]
    unit: Optional[str]
    rms_gradient: float
    rms_height: float
    e_star: float
    warnings: list[Record]

    @property
    def residual(self) -> Residual:
        """Parts of the residual by name, arrays [state], without unit; `residual.largest` is the largest part."""
        return residual_of(self.states)

    def __repr__(self) -> str:
        theory = ("persson_friction",) if self.get("prony") else ()
        heat = ("heat_max_rise", "heat_mean_rise") if "heat_max_rise" in self.states else ("p_star", "mean_gap")
        names = ("velocity", "mean_pressure", "area_fraction", "friction", *theory, *heat)
        return self._answer("states", names, ())

    def to_dataframe(self) -> Any:
        """Returns the state numbers as a pandas.DataFrame with one row per state; units in `attrs["units"]`.

        Raises:
            Error: pandas is not installed.

        Example:
            >>> sliding.to_dataframe().shape[0]  # doctest: +SKIP
            2
        """
        return _show.table_frame(self, self.states)

    def plot(self, x: str = "velocity", y: str = "friction", ax: Any = None) -> Any:
        """Draws one state number against another with matplotlib, one curve per load. Returns the axes.

        Args:
            x, y: names of arrays in `states`. Velocities spanning more than a decade have a logarithmic axis.
            ax: axes to draw into; new ones by default.

        Raises:
            InputError: an unknown name. Error: matplotlib is not installed.

        Example:
            >>> ax = sliding.plot("velocity", "area_fraction")
        """
        return _show.states(self, (x, y), ax)

    def to_xarray(self) -> Any:
        """Returns the scalars [state], including velocity, and fields [state, y, x] as an xarray.Dataset.

        Raises:
            Error: xarray is not installed.

        Example:
            >>> sliding.to_xarray().pressure.dims, sliding.to_xarray().velocity.dims
            (('state', 'y', 'x'), ('state',))
        """
        return _show.table_dataset(self, self.states, "state", "state")


def _thermal(heat: Any) -> list[Any]:
    """Checks conductivity and diffusivity of one or two bodies."""
    entries = several("heat", heat)
    if entries is None:
        raise InputError(f"heat is {shown(heat)}; it must be two numbers, or four with the two of the surface")
    if len(entries) not in (2, 4):
        raise InputError(f"heat has {len(entries)} numbers; it must have two, or four with the two of the surface")
    return [quantity("heat", entry, kind_of("heat", place)) for place, entry in enumerate(entries)]


@taking(SlideOptions)
def slide(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    velocity: Any,
    pressure: Any = None,
    p_star: Any = None,
    force: Any = None,
    approach: Any = None,
    **options: Unpack[SlideOptions],
) -> Slide:
    """Slides a surface steadily over a body: hysteretic friction, area, gap and flash temperature against velocity.

    Args:
        surface: as in `contact`.
        body: a viscoelastic body, `Body(prony=...)`; with `friction` also an elastic body.
        velocity: velocities of the surface relative to the body, a number or a sequence; length divided by the time
            unit of relaxation times and diffusivity.
        pressure, p_star, force, approach: loads by one of the four (stress, 1, stress * length^2, length), a number or
            a sequence. All may be strings with a unit, such as "1MPa", if the surface has one.
        direction: direction of the velocity, degrees from x.
        heat: conductivity and diffusivity of the body, then of the surface if it shares the heat: two or four numbers,
            or strings with a unit, such as ("0.2W/(m K)", "1e-7m^2/s").
        friction: friction coefficient of the interface, which slides at all points: the shear friction * pressure
            lifts the surface of a compressible body, adds to the friction, and generates the heat friction * pressure *
            velocity; required with `heat`.
        hardness: largest pressure, stress, a number or an array of the shape of the heights, as in `contact`.
        stress_unit: unit of stresses given without one, as in `contact`.
        tolerance, max_iterations: limits for each state, as in `contact`.
        grid_error: "refine" to estimate the discretisation error of areas and frictions by also solving each state with
            twice as many points along each side.
        threads: number of threads; all cores by default.
        out: HDF5 file to write, as with `gfmd slide --out`. Unlike `save`, it checks the name before the first state.

    Raises:
        InputError: invalid arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Slide so far.

    Example:
        >>> rubber = gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)])
        >>> sliding = gfmd.slide(gfmd.self_affine(n=32, eps_f_inv=4), rubber, velocity=[0.001, 0.01], p_star=0.05)
        >>> bool((sliding.states.friction > 0).all())
        True
    """
    made, elastic = as_surface(surface), as_body(body, in_time=True)
    if not elastic.prony and options.get("friction") is None:
        raise InputError("body is elastic; it must be viscoelastic to slide without friction: gfmd.Body(prony=...)")
    if "compliance" in elastic:
        raise InputError("body has a table of compliances; it must have moduli to slide")
    threads, out, heat = options.pop("threads", None), options.pop("out", None), options.pop("heat", None)
    bound = as_hardness(options.pop("hardness", None), made)
    problem: dict[str, Any] = dict(
        unit=made.unit,
        **drive_keys("the load is", {"pressure": pressure, "p_star": p_star, "force": force, "approach": approach}),
        velocity=quantities("velocity", velocity),
        heat=None if heat is None else _thermal(heat),
        size=list(made.size),
        **_command.body_keys(elastic),
        **_command.relaxation_keys(elastic),
        **options,
    )
    arrays: dict[str, Any] = {"surface": made.heights}
    (problem if isinstance(bound, (float, str)) else arrays)["hardness"] = bound
    values, failure, fields, file = _command.solve("slide", problem, arrays, threads, out, made)
    return _command.ended(made_of(values, fields, (made, bound), file), failure)


def made_of(
    values: dict[str, Any], fields: Mapping[str, Array], given: tuple[Surface, Any], file: File | Contents
) -> Slide:
    """Makes a slide from the report of the command, its fields, the surface and the hardness, and the file."""
    made, bound = given
    rows = []
    for state in values.pop("states"):
        state.pop("undefined", None)
        theory = {f"persson_{name}": value for name, value in state.pop("persson").items()}
        warm = {f"heat_{name}": np.nan if value is None else value for name, value in state.pop("heat", {}).items()}
        parts = {f"residual_{name}": value for name, value in state.pop("residual").items()}
        rows.append({**state, **theory, **warm, **parts})
    columns = {name: frozen(np.array([row[name] for row in rows])) for name in (rows[0] if rows else ())}
    reported = {name: _command.records(value) for name, value in values.items()}
    if isinstance(bound, np.ndarray):
        reported["hardness"] = bound
    return Slide({**reported, "unit": made.unit, "surface": made, "states": States(columns), **fields}, file)
