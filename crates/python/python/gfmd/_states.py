"""The numbers and fields of states that slide steadily, with their units and definitions.

Made from crates/cli/src/slide/file.rs by `GFMD_DOCS=write cargo test -p gfmd-cli --lib`.
"""

# mypy: no-warn-return-any

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from ._check import Array
from ._record import Record


class States(Record):
    """The numbers of states that slide steadily."""

    @property
    def velocity(self) -> Array:
        """Length/time [state]: velocity of the rigid surface relative to the body."""
        return self._value("velocity")

    @property
    def mean_pressure(self) -> Array:
        """Stress [state]: mean pressure over the whole surface."""
        return self._value("mean_pressure")

    @property
    def p_star(self) -> Array:
        """Without unit [state]: reduced pressure p/(E* g)."""
        return self._value("p_star")

    @property
    def displacement(self) -> Array:
        """Length [state]: rigid approach beyond first touch."""
        return self._value("displacement")

    @property
    def area_fraction(self) -> Array:
        """Without unit [state]: points with pressure over all points."""
        return self._value("area_fraction")

    @property
    def mean_gap(self) -> Array:
        """Length [state]: mean distance between the surfaces."""
        return self._value("mean_gap")

    @property
    def max_pressure(self) -> Array:
        """Stress [state]: largest pressure."""
        return self._value("max_pressure")

    @property
    def friction(self) -> Array:
        """Without unit [state]: coefficient of friction, by the power lost in the body."""
        return self._value("friction")

    @property
    def friction_slope(self) -> Array:
        """Without unit [state]: coefficient of friction, by the pressure on the slopes."""
        return self._value("friction_slope")

    @property
    def dissipated_power(self) -> Array:
        """Stress * length/time [state]: power lost in the body, per area."""
        return self._value("dissipated_power")

    @property
    def persson_friction(self) -> Array:
        """Without unit [state]: coefficient of friction by Persson's theory."""
        return self._value("persson_friction")

    @property
    def persson_area_fraction(self) -> Array:
        """Without unit [state]: contact area by Persson's theory."""
        return self._value("persson_area_fraction")

    @property
    def iterations(self) -> npt.NDArray[Any]:
        """Without unit [state]: iterations of the search."""
        return self._value("iterations")

    @property
    def transform_pairs(self) -> Array:
        """Without unit [state]: pairs of transforms of the search."""
        return self._value("transform_pairs")

    @property
    def converged(self) -> npt.NDArray[Any]:
        """Without unit [state]: true if the residual is at most the tolerance."""
        return self._value("converged")

    @property
    def seconds(self) -> Array:
        """Seconds [state]: wall time."""
        return self._value("seconds")

    @property
    def heat_mean_flux(self) -> Array:
        """Stress * length/time [state]: mean heat of friction, per area and time. With `heat` only."""
        return self._value("heat_mean_flux")

    @property
    def heat_fraction(self) -> Array:
        """Without unit [state]: part of the heat that flows into the body. With `heat` only."""
        return self._value("heat_fraction")

    @property
    def heat_max_rise(self) -> Array:
        """Temperature [state]: largest temperature in contact, above the mean of the surface. With `heat` only."""
        return self._value("heat_max_rise")

    @property
    def heat_mean_rise(self) -> Array:
        """Temperature [state]: mean temperature in contact, above the mean of the surface. With `heat` only."""
        return self._value("heat_mean_rise")

    @property
    def heat_residual(self) -> Array:
        """Without unit [state]: largest difference between the temperatures of both bodies over the largest rise.
        With `heat` only.
        """
        return self._value("heat_residual")


class StateFields(Record):
    """The fields of states that slide steadily."""

    @property
    def pressure(self) -> Array:
        """Stress [state, x, y]: pressure on the surface of the body. Read-only."""
        return self._value("pressure")

    @property
    def displacement_z(self) -> Array:
        """Length [state, x, y]: normal displacement of the surface of the body, negative downwards. Read-only."""
        return self._value("displacement_z")

    @property
    def gap(self) -> Array:
        """Length [state, x, y]: distance between the surfaces. Read-only."""
        return self._value("gap")

    @property
    def temperature(self) -> Array:
        """Temperature [state, x, y]: temperature of the body's surface, above its mean. With `heat` only. Read-only."""
        return self._value("temperature")

    @property
    def heat_flux(self) -> Array:
        """Stress * length/time [state, x, y]: heat that flows into the body, per area and time. With `heat` of both
        bodies only. Read-only.
        """
        return self._value("heat_flux")
