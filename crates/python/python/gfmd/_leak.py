"""Leak rates with units: volume per time, from conductivities relative to a uniform gap."""

from __future__ import annotations

import json
import math
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _gfmd
from ._check import Array, Quantity, in_units, shown
from ._errors import InputError
from ._hints import hinted
from ._units import metre


def transmissivity(conductivity: Array, percolates: npt.NDArray[np.bool_], mean_gap: Any) -> Array:
    """Returns conductivity times mean gap³/12, length³; zero if the gap is closed."""
    through: Array = (
        np.where(np.isnan(conductivity) & ~percolates, 0.0, conductivity) * np.asarray(mean_gap) ** 3 / 12.0
    )
    return through


def viscosity_of(fluid: Optional[str], viscosity: Optional[Quantity]) -> Quantity:
    """Returns the given viscosity, or the viscosity of a named fluid."""
    if fluid is None:
        if viscosity is None:
            raise InputError("viscosity is missing; give it, or the name of a fluid")
        return viscosity
    if viscosity is not None:
        raise InputError(f"fluid is {fluid}; it must be given without viscosity: it has a viscosity")
    known: dict[str, dict[str, str]] = json.loads(_gfmd.fluids())
    if fluid not in known:
        raise InputError(f"fluid is {shown(fluid)}; it must be one of {', '.join(known)}")
    return known[fluid]["viscosity"]


def rate(
    along: Array,
    size: tuple[float, float],
    metre: float,
    fluid: tuple[Optional[str], Optional[Quantity]],
    pressure_drop: Quantity,
) -> Array:
    """Returns the volume per time through the cell along x and y (last axis), from the transmissivities.

    `fluid` is a name and a viscosity, exactly one of them given.
    """
    viscosity = viscosity_of(*fluid)
    thickness, drop = in_units("viscosity", viscosity), in_units("pressure_drop", pressure_drop)
    if not (0.0 < thickness < math.inf and 0.0 < drop < math.inf):
        raise InputError(
            f"viscosity and pressure_drop are {viscosity!r}, {pressure_drop!r}; they must be positive and finite"
        )
    lx, ly = size
    volume: Array = along * np.array([ly / lx, lx / ly]) * metre**3 * drop / thickness
    return volume


class Leaks:
    """A result with steps that may have a `flow`."""

    @hinted
    def leak_rate(
        self, *, viscosity: Optional[Quantity] = None, pressure_drop: Quantity, fluid: Optional[str] = None
    ) -> Array:
        """Returns the leak rate (volume per time) through the gap along x and along y after each step, [step, 2].

        Args:
            viscosity: fluid viscosity, Pa s, or a string with a unit, such as "1 mPa*s"; in stress * time if the length
                unit is unknown.
            pressure_drop: pressure drop over the length of the cell along the flow, Pa, or a string with a unit, such
                as "1 bar"; in stress if the length unit is unknown.
            fluid: fluid name, such as "water", in place of `viscosity`; `gfmd materials` lists them.

        Returns:
            Leak rates in m³/s (length³/time if the length unit is unknown); zero if the gap is closed.

        Raises:
            InputError: a result without flow; arguments that are not positive; an unknown fluid.

        Example:
            >>> rubber = gfmd.Body(young="2 MPa", poisson=0.5, prony=[("1 s", 0.3), ("1 d", 0.4)])
            >>> rough = gfmd.self_affine(n=32, eps_f_inv=4, unit="um")
            >>> seal = gfmd.path(rough, rubber, p_star=0.1, time=[0, "1 d"], steps=1, flow=True)
            >>> leak = seal.leak_rate(viscosity="1 mPa*s", pressure_drop="1 bar")
            >>> bool(leak[-1, 0] < leak[0, 0])
            True
        """
        steps, surface = self.steps, self.surface  # type: ignore[attr-defined]
        if "flow_xx" not in steps:
            raise InputError("the result has no flow; path takes flow=True")
        along = np.stack([steps.flow_xx, steps.flow_yy], axis=-1)
        is_open = np.stack([steps.flow_percolates_x, steps.flow_percolates_y], axis=-1).astype(bool)
        through = transmissivity(along, is_open, np.asarray(steps.mean_gap)[:, np.newaxis])
        return rate(through, surface.size, metre(surface.unit), (fluid, viscosity), pressure_drop)
