"""Steady sliding over viscoelastic bodies."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _command
from ._body import Body, as_body
from ._check import Array, integer, number, numbers, quantities, word
from ._errors import InputError
from ._record import Record
from ._surface import Surface, as_surface


class Slide(Record):
    """Steady states of a surface that slides over a viscoelastic body.

    Attributes:
        states: a Record of arrays over the states, every load at every velocity: `velocity`, `mean_pressure`, `max_pressure` (stress),
            `p_star`, `displacement` (the approach), `mean_gap` (length), `area_fraction`, `friction` (by the power lost in the body),
            `friction_slope` (by the pressure on the slopes), `dissipated_power` (stress * velocity), `persson_friction`,
            `persson_area_fraction`, `iterations`, `transform_pairs`, `converged`, `residual_...`, `seconds`.
        pressure, gap, displacement_z: fields [state, x, y], stress and length; NaN at states that were not reached.
        direction: unit vector of the velocity.
        prony, moduli, relaxes, young_long_term, young_instantaneous: the relaxation of the body.
        warnings: a Record for each warning of the computation: `code`, `text`.
        surface, n, length, unit, rms_gradient, rms_height, e_star: the problem.

    Example:
        >>> rubber = gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)])
        >>> gfmd.slide(gfmd.self_affine(n=32, eps_f_inv=4), rubber, velocity=[0.01, 1.0], p_star=0.05).pressure.shape
        (2, 32, 32)
    """

    states: Record
    pressure: Array
    gap: Array
    displacement_z: Array
    direction: list[float]
    prony: list[list[float]]
    moduli: str
    relaxes: str
    young_long_term: float
    young_instantaneous: float
    surface: Surface
    n: list[int]
    length: list[float]
    unit: Optional[str]
    rms_gradient: float
    rms_height: float
    e_star: float
    warnings: list[Record]


def slide(
    surface: Surface | npt.ArrayLike | Any,
    body: Body,
    *,
    velocity: Any,
    mean_pressure: Any = None,
    p_star: Any = None,
    approach: Any = None,
    direction: float = 0.0,
    stress_unit: Optional[str] = None,
    tolerance: float = 1e-8,
    max_iterations: int = 100_000,
    threads: Optional[int] = None,
) -> Slide:
    """Slides a surface steadily over a viscoelastic body: friction by hysteresis, area and gap against velocity.

    Args:
        surface: as of `contact`.
        body: a viscoelastic body, `Body(prony=...)`.
        velocity: velocities of the surface relative to the body, length over the unit of the relaxation times; a number or a sequence.
        mean_pressure, p_star, approach: loads by one of the three (stress, 1, length), a number or a sequence. Stresses and lengths
            may be texts with a unit, such as "1MPa", if the surface has one.
        direction: direction of the velocity, degrees from x.
        stress_unit: unit of stresses given without one, as of `contact`.
        tolerance, max_iterations: of each state, as of `contact`.
        threads: number of threads; all cores by default.

    Raises:
        InputError: unusable arguments; nothing was computed.
        NotConverged, Interrupted: `.state` is the Slide so far.

    Example:
        >>> rubber = gfmd.Body(prony=[(0.1, 0.3), (10.0, 0.4)])
        >>> sliding = gfmd.slide(gfmd.self_affine(n=32, eps_f_inv=4), rubber, velocity=[0.001, 0.01], p_star=0.05)
        >>> bool((sliding.states.friction > 0).all())
        True
    """
    made, elastic = as_surface(surface), as_body(body, in_time=True)
    if not elastic.prony:
        raise InputError("body is elastic; it must be viscoelastic to slide: gfmd.Body(prony=...)")
    loads = {"mean_pressure": mean_pressure, "p_star": p_star, "approach": approach}
    kinds = {"mean_pressure": "stress", "p_star": "1", "approach": "length"}
    found = {name: quantities(name, value, kinds[name]) for name, value in loads.items() if value is not None}
    if len(found) != 1:
        raise InputError(f"the loads are given by {', '.join(found) or 'none'}; they must be given by one of mean_pressure, p_star, approach")
    problem: dict[str, Any] = dict(
        unit=made.unit,
        stress_unit=None if stress_unit is None else word("stress_unit", stress_unit),
        pressure=found.get("mean_pressure"),
        p_star=found.get("p_star"),
        displacement=found.get("approach"),
        velocity=numbers("velocity", velocity),
        direction=number("direction", direction),
        tol=number("tolerance", tolerance),
        max_iter=integer("max_iterations", max_iterations),
        length=list(made.size),
        **_command.body_keys(elastic),
        **_command.relaxation_keys(elastic),
    )
    values, failure, fields = _command.solve("slide", problem, {"surface": made.heights}, threads)
    rows = []
    for state in values.pop("states"):
        theory = {f"persson_{name}": value for name, value in state.pop("persson").items()}
        parts = {f"residual_{name}": value for name, value in state.pop("residual").items()}
        rows.append({**state, **theory, **parts})
    columns = {name: np.array([row[name] for row in rows]) for name in (rows[0] if rows else ())}
    told = {name: _command.records(value) for name, value in values.items()}
    result = Slide({**told, "unit": made.unit, "surface": made, "states": Record(columns), **fields})
    return _command.ended(result, failure)
