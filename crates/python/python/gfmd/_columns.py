"""The numbers and fields of states, with their units and definitions.

Made from crates/record/src by `GFMD_DOCS=write cargo test -p gfmd-record`.
"""

# mypy: no-warn-return-any

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy.typing as npt

from ._check import Array
from ._record import Record

if TYPE_CHECKING:
    from ._load import Residual

# The places of the numbers of a flow in its object, by their names.
FLOW = {
    "flow_xx": "conductivity.0.0",
    "flow_xy": "conductivity.0.1",
    "flow_yx": "conductivity.1.0",
    "flow_yy": "conductivity.1.1",
    "flow_percolates_x": "percolates.0",
    "flow_percolates_y": "percolates.1",
    "flow_residual": "residual",
    "flow_xx_limit": "conductivity_limit.0.0",
    "flow_xx_limit_error": "conductivity_limit_error.0.0",
    "flow_xx_grid_error": "conductivity_grid_error.0.0",
    "flow_yy_limit": "conductivity_limit.1.1",
    "flow_yy_limit_error": "conductivity_limit_error.1.1",
    "flow_yy_grid_error": "conductivity_grid_error.1.1",
}


class Residuals(Record):
    """The residuals of a load."""

    @property
    def complementarity(self) -> float:
        """Without unit: sum(p gap) / (sum(p) h_rms), from the final fields. With `lower_surface`: sum(p gap) /
        (sum(p) h_rms), from the final fields, the larger of the two faces. With `law`: sum(p gap) / (sum(p) h_rms)
        with p the pressure of the wall, from the final fields.
        """
        return self._value("complementarity")

    @property
    def penetration(self) -> float:
        """Without unit: max(0, -min gap) / h_rms, from the final fields. With `lower_surface`: max(0, -min gap) /
        h_rms, from the final fields, the larger of the two faces.
        """
        return self._value("penetration")

    @property
    def negative_pressure(self) -> float:
        """Without unit: max(0, -min p) / mean p, from the final fields. With `lower_surface`: max(0, -min p) / mean
        p, from the final fields, the larger of the two faces. With `law`: largest tension that the wall would have
        to hold, from the final fields, / the stress scale (the largest traction, or the softest stiffness times
        h_rms if more).
        """
        return self._value("negative_pressure")

    @property
    def load(self) -> float:
        """Without unit: |mean p - asked| / asked, from the final fields. With `lower_surface`: |mean p - asked| /
        asked, the larger of the two faces; if the approach is prescribed the difference of their mean pressures over
        its mean. With `law`: |mean p - asked| from the final fields, 0 if the approach is prescribed, / the stress
        scale (the largest traction, or the softest stiffness times h_rms if more).
        """
        return self._value("load")

    @property
    def saturation(self) -> float:
        """Without unit: largest gap / h_rms where the pressure is the hardness. With `hardness` only."""
        return self._value("saturation")

    @property
    def lateral_traction(self) -> float:
        """Without unit: largest lateral traction that the dynamics left / largest pressure. With `components="all"`
        only.
        """
        return self._value("lateral_traction")

    @property
    def lateral_displacement(self) -> float:
        """Without unit: last change of the lateral displacement over h_rms, which is consistent with the pressure to
        that extent. With `finite_slope` only.
        """
        return self._value("lateral_displacement")


class LowerFace(Record):
    """The numbers of the lower face of a slab between two surfaces."""

    @property
    def mean_pressure(self) -> float:
        """Stress: mean pressure over the whole lower surface."""
        return self._value("mean_pressure")

    @property
    def displacement(self) -> float:
        """Length: part of the approach at the lower face."""
        return self._value("displacement")

    @property
    def area_fraction(self) -> float:
        """Without unit: contact area fraction of the lower face."""
        return self._value("area_fraction")

    @property
    def area_fraction_corrected(self) -> float:
        """Without unit: contact area fraction of the lower face less the excess of the pixels along the perimeter."""
        return self._value("area_fraction_corrected")

    @property
    def contact_nodes(self) -> int:
        """Count: number of points in contact at the lower face."""
        return self._value("contact_nodes")

    @property
    def boundary_links(self) -> int:
        """Count: neighbouring pairs with one point in contact and one not, at the lower face."""
        return self._value("boundary_links")

    @property
    def mean_gap(self) -> float:
        """Length: mean distance between lower face and lower surface."""
        return self._value("mean_gap")

    @property
    def max_pressure(self) -> float:
        """Stress: largest pressure on the lower face."""
        return self._value("max_pressure")

    @property
    def mean_pressure_in_contact(self) -> float:
        """Stress: mean pressure over the points in contact at the lower face."""
        return self._value("mean_pressure_in_contact")

    @property
    def residual(self) -> Residual:
        """Residuals, recomputed from the final fields; `float(...)` is the largest."""
        return self._value("residual")


class Numbers(Record):
    """The numbers of a load."""

    @property
    def mean_pressure(self) -> float:
        """Stress: mean pressure over the whole surface."""
        return self._value("mean_pressure")

    @property
    def p_star(self) -> float:
        """Without unit: reduced pressure p/(E* g)."""
        return self._value("p_star")

    @property
    def displacement(self) -> float:
        """Length: rigid approach beyond first touch. With `lower_surface`: approach of the two rigid surfaces beyond
        the distance at which both touch the undeformed slab.
        """
        return self._value("displacement")

    @property
    def mean_shear(self) -> list[float]:
        """Stress along x and y: mean traction that holds the rigid surface in its place. With `finite_slope` only."""
        return self._value("mean_shear")

    @property
    def area_fraction(self) -> float:
        """Without unit: contact area fraction, points in contact over all points. With `law`: contact area fraction,
        points that are repelled over all points.
        """
        return self._value("area_fraction")

    @property
    def area_fraction_corrected(self) -> float:
        """Without unit: contact area fraction less the excess of the pixels along the perimeter (Yastrebov et al.
        2017).
        """
        return self._value("area_fraction_corrected")

    @property
    def kappa(self) -> float:
        """Without unit: area_fraction / p_star. With `law`: area_fraction / p_star; NaN if attraction carries the
        load.
        """
        return self._value("kappa")

    @property
    def kappa_corrected(self) -> float:
        """Without unit: area_fraction_corrected / p_star. With `law`: area_fraction_corrected / p_star; NaN if
        attraction carries the load.
        """
        return self._value("kappa_corrected")

    @property
    def contact_nodes(self) -> int:
        """Count: number of points in contact. With `law`: number of points that are repelled."""
        return self._value("contact_nodes")

    @property
    def boundary_links(self) -> int:
        """Count: neighbouring pairs with one point in contact and one not. With `law`: neighbouring pairs with one
        point repelled and one not.
        """
        return self._value("boundary_links")

    @property
    def mean_gap(self) -> float:
        """Length: mean distance between the surfaces."""
        return self._value("mean_gap")

    @property
    def max_pressure(self) -> float:
        """Stress: largest pressure. With `law`: largest repulsive pressure."""
        return self._value("max_pressure")

    @property
    def mean_pressure_in_contact(self) -> float:
        """Stress: mean pressure over the points in contact. With `law`: mean repulsive pressure over the points that
        are repelled.
        """
        return self._value("mean_pressure_in_contact")

    @property
    def pressure_deviation_in_contact(self) -> float:
        """Stress: standard deviation of the pressure over the points in contact. With `law`: standard deviation of
        the repulsive pressure over the points that are repelled.
        """
        return self._value("pressure_deviation_in_contact")

    @property
    def pressure_moment_2(self) -> float:
        """Stress^2: mean square pressure over the whole surface. With `law`: mean square repulsive pressure over the
        whole surface.
        """
        return self._value("pressure_moment_2")

    @property
    def elastic_energy(self) -> float:
        """Stress * length: elastic energy per area of the surface. With `lower_surface`: elastic energy of the slab
        per area, by the pressures on both faces.
        """
        return self._value("elastic_energy")

    @property
    def interface_energy(self) -> float:
        """Stress * length: energy of the contact law per area of the surface, zero far away. With `law` only."""
        return self._value("interface_energy")

    @property
    def passed_instability(self) -> bool:
        """Flag: true if directions of negative curvature were met on the way from the last load. With `law` only."""
        return self._value("passed_instability")

    @property
    def lowest_curvature(self) -> float:
        """Without unit: lowest curvature met in the last search for a step, over the elastic curvature. With `law`
        only.
        """
        return self._value("lowest_curvature")

    @property
    def stiffness(self) -> float:
        """Stress/length: d(mean pressure)/d(displacement) with the points in contact kept, those at the hardness
        with their pressure; NaN where it is infinite (full contact with a fixed mean level) or not computed: the
        attribute undefined says why.
        """
        return self._value("stiffness")

    @property
    def stiffness_error(self) -> float:
        """Without unit: relative error of the stiffness, from the residual of its linear problem."""
        return self._value("stiffness_error")

    @property
    def iterations(self) -> int:
        """Count: iterations or time steps of the solver."""
        return self._value("iterations")

    @property
    def transform_pairs(self) -> float:
        """Without unit: forward and inverse real transforms of the full grid, in pairs."""
        return self._value("transform_pairs")

    @property
    def converged(self) -> bool:
        """Flag: true if all residuals of this load are at most the tolerance. With `law`: true if all five residuals
        are at most the tolerance.
        """
        return self._value("converged")

    @property
    def residual(self) -> Residual:
        """Residuals, recomputed from the final fields; `float(...)` is the largest."""
        return self._value("residual")

    @property
    def seconds(self) -> float:
        """Seconds: wall time of a load: solution and, of a contact, stiffness, statistics, flow; without finer
        grids.
        """
        return self._value("seconds")

    @property
    def force(self) -> float:
        """Stress * length^2: force, of a line per length across it (stress*length). With `boundary="free"` only."""
        return self._value("force")

    @property
    def plastic_fraction(self) -> float:
        """Without unit: points whose pressure is the hardness over all points. With `hardness` only."""
        return self._value("plastic_fraction")

    @property
    def plastic_volume(self) -> float:
        """Length: mean plastic depth over the whole surface. With `hardness` only."""
        return self._value("plastic_volume")

    @property
    def projected_area_fraction(self) -> float:
        """Without unit: contact area of the deformed surface, projected onto the plane of the rigid one, over the
        area of the cell. With `finite_slope` only.
        """
        return self._value("projected_area_fraction")

    @property
    def lower(self) -> LowerFace:
        """Numbers of the lower face. With `lower_surface` only."""
        return self._value("lower")

    @property
    def residual_equilibrium(self) -> float:
        """Without unit: largest unbalanced force per area, from the final fields, / the stress scale (the largest
        traction, or the softest stiffness times h_rms if more). With `law` only.
        """
        return self._value("residual_equilibrium")

    @property
    def mean_pressure_limit(self) -> float:
        """Stress: estimate of mean_pressure on an infinitely fine grid at the same approach. With `approach` only."""
        return self._value("mean_pressure_limit")

    @property
    def mean_pressure_limit_error(self) -> float:
        """Stress: 95 % of the errors of mean_pressure_limit are smaller. With `approach` only."""
        return self._value("mean_pressure_limit_error")

    @property
    def mean_pressure_grid_error(self) -> float:
        """Stress: error of mean_pressure by the finite grid: |mean_pressure - limit| + limit_error. With `approach`
        only.
        """
        return self._value("mean_pressure_grid_error")

    @property
    def displacement_limit(self) -> float:
        """Length: estimate of displacement on an infinitely fine grid under the same mean pressure. In some problems
        only.
        """
        return self._value("displacement_limit")

    @property
    def displacement_limit_error(self) -> float:
        """Length: 95 % of the errors of displacement_limit are smaller. In some problems only."""
        return self._value("displacement_limit_error")

    @property
    def displacement_grid_error(self) -> float:
        """Length: error of displacement by the finite grid: |displacement - limit| + limit_error. In some problems
        only.
        """
        return self._value("displacement_grid_error")

    @property
    def area_fraction_limit(self) -> float:
        """Without unit: estimate of area_fraction on an infinitely fine grid under the same mean pressure."""
        return self._value("area_fraction_limit")

    @property
    def area_fraction_limit_error(self) -> float:
        """Without unit: 95 % of the errors of area_fraction_limit are smaller."""
        return self._value("area_fraction_limit_error")

    @property
    def area_fraction_grid_error(self) -> float:
        """Without unit: error of area_fraction by the finite grid: |area_fraction - limit| + limit_error."""
        return self._value("area_fraction_grid_error")

    @property
    def kappa_limit(self) -> float:
        """Without unit: estimate of kappa on an infinitely fine grid under the same mean pressure."""
        return self._value("kappa_limit")

    @property
    def kappa_limit_error(self) -> float:
        """Without unit: 95 % of the errors of kappa_limit are smaller."""
        return self._value("kappa_limit_error")

    @property
    def kappa_grid_error(self) -> float:
        """Without unit: error of kappa by the finite grid: |kappa - limit| + limit_error."""
        return self._value("kappa_grid_error")

    @property
    def boundary_links_limit(self) -> float:
        """Without unit: estimate of the length of the boundary on an infinitely fine grid, in steps of this grid."""
        return self._value("boundary_links_limit")

    @property
    def boundary_links_limit_error(self) -> float:
        """Without unit: 95 % of the errors of boundary_links_limit are smaller."""
        return self._value("boundary_links_limit_error")

    @property
    def boundary_links_grid_error(self) -> float:
        """Without unit: error of boundary_links by the finite grid: |boundary_links - limit| + limit_error."""
        return self._value("boundary_links_grid_error")

    @property
    def mean_gap_limit(self) -> float:
        """Length: estimate of mean_gap on an infinitely fine grid under the same mean pressure."""
        return self._value("mean_gap_limit")

    @property
    def mean_gap_limit_error(self) -> float:
        """Length: 95 % of the errors of mean_gap_limit are smaller."""
        return self._value("mean_gap_limit_error")

    @property
    def mean_gap_grid_error(self) -> float:
        """Length: error of mean_gap by the finite grid: |mean_gap - limit| + limit_error."""
        return self._value("mean_gap_grid_error")

    @property
    def max_pressure_limit(self) -> float:
        """Stress: estimate of max_pressure on an infinitely fine grid under the same mean pressure."""
        return self._value("max_pressure_limit")

    @property
    def max_pressure_limit_error(self) -> float:
        """Stress: 95 % of the errors of max_pressure_limit are smaller."""
        return self._value("max_pressure_limit_error")

    @property
    def max_pressure_grid_error(self) -> float:
        """Stress: error of max_pressure by the finite grid: |max_pressure - limit| + limit_error."""
        return self._value("max_pressure_grid_error")

    @property
    def mean_pressure_in_contact_limit(self) -> float:
        """Stress: estimate of mean_pressure_in_contact on an infinitely fine grid under the same mean pressure."""
        return self._value("mean_pressure_in_contact_limit")

    @property
    def mean_pressure_in_contact_limit_error(self) -> float:
        """Stress: 95 % of the errors of mean_pressure_in_contact_limit are smaller."""
        return self._value("mean_pressure_in_contact_limit_error")

    @property
    def mean_pressure_in_contact_grid_error(self) -> float:
        """Stress: error of mean_pressure_in_contact by the finite grid: |mean_pressure_in_contact - limit| +
        limit_error.
        """
        return self._value("mean_pressure_in_contact_grid_error")

    @property
    def pressure_deviation_in_contact_limit(self) -> float:
        """Stress: estimate of pressure_deviation_in_contact on an infinitely fine grid under the same mean pressure."""
        return self._value("pressure_deviation_in_contact_limit")

    @property
    def pressure_deviation_in_contact_limit_error(self) -> float:
        """Stress: 95 % of the errors of pressure_deviation_in_contact_limit are smaller."""
        return self._value("pressure_deviation_in_contact_limit_error")

    @property
    def pressure_deviation_in_contact_grid_error(self) -> float:
        """Stress: error of pressure_deviation_in_contact by the finite grid: |pressure_deviation_in_contact - limit|
        + limit_error.
        """
        return self._value("pressure_deviation_in_contact_grid_error")

    @property
    def pressure_moment_2_limit(self) -> float:
        """Stress^2: estimate of pressure_moment_2 on an infinitely fine grid under the same mean pressure."""
        return self._value("pressure_moment_2_limit")

    @property
    def pressure_moment_2_limit_error(self) -> float:
        """Stress^2: 95 % of the errors of pressure_moment_2_limit are smaller."""
        return self._value("pressure_moment_2_limit_error")

    @property
    def pressure_moment_2_grid_error(self) -> float:
        """Stress^2: error of pressure_moment_2 by the finite grid: |pressure_moment_2 - limit| + limit_error."""
        return self._value("pressure_moment_2_grid_error")

    @property
    def elastic_energy_limit(self) -> float:
        """Stress * length: estimate of elastic_energy on an infinitely fine grid under the same mean pressure."""
        return self._value("elastic_energy_limit")

    @property
    def elastic_energy_limit_error(self) -> float:
        """Stress * length: 95 % of the errors of elastic_energy_limit are smaller."""
        return self._value("elastic_energy_limit_error")

    @property
    def elastic_energy_grid_error(self) -> float:
        """Stress * length: error of elastic_energy by the finite grid: |elastic_energy - limit| + limit_error."""
        return self._value("elastic_energy_grid_error")

    @property
    def interface_energy_limit(self) -> float:
        """Stress * length: estimate of interface_energy on an infinitely fine grid under the same mean pressure.
        With `law` only.
        """
        return self._value("interface_energy_limit")

    @property
    def interface_energy_limit_error(self) -> float:
        """Stress * length: 95 % of the errors of interface_energy_limit are smaller. With `law` only."""
        return self._value("interface_energy_limit_error")

    @property
    def interface_energy_grid_error(self) -> float:
        """Stress * length: error of interface_energy by the finite grid: |interface_energy - limit| + limit_error.
        With `law` only.
        """
        return self._value("interface_energy_grid_error")

    @property
    def stiffness_limit(self) -> float:
        """Stress/length: estimate of stiffness on an infinitely fine grid under the same mean pressure."""
        return self._value("stiffness_limit")

    @property
    def stiffness_limit_error(self) -> float:
        """Stress/length: 95 % of the errors of stiffness_limit are smaller."""
        return self._value("stiffness_limit_error")

    @property
    def stiffness_grid_error(self) -> float:
        """Stress/length: error of stiffness by the finite grid: |stiffness - limit| + limit_error."""
        return self._value("stiffness_grid_error")


class Fields:
    """The fields of a load."""

    _fields: dict[str, Array]

    @property
    def pressure(self) -> Array:
        """Stress [x, y]: pressure on the elastic surface, compression positive; attraction is negative. Read-only."""
        return self._fields["pressure"]

    @property
    def displacement_z(self) -> Array:
        """Length [x, y]: normal displacement of the elastic surface, negative downwards. Read-only."""
        return self._fields["displacement_z"]

    @property
    def gap(self) -> Array:
        """Length [x, y]: distance between the surfaces. Read-only."""
        return self._fields["gap"]

    @property
    def plastic_depth(self) -> Optional[Array]:
        """Length [x, y]: depth by which the surfaces are pressed into each other beyond touching. With `hardness`
        only, otherwise None. Read-only.
        """
        return self._fields.get("plastic_depth")

    @property
    def displacement_x(self) -> Optional[Array]:
        """Length [x, y]: displacement of the elastic surface along x. With `components="all"` or `finite_slope`
        only, otherwise None. Read-only.
        """
        return self._fields.get("displacement_x")

    @property
    def displacement_y(self) -> Optional[Array]:
        """Length [x, y]: displacement of the elastic surface along y. In some problems only, otherwise None.
        Read-only.
        """
        return self._fields.get("displacement_y")

    @property
    def lower_pressure(self) -> Optional[Array]:
        """Stress [x, y]: pressure on the lower face of the slab. With `lower_surface` only, otherwise None.
        Read-only.
        """
        return self._fields.get("lower_pressure")

    @property
    def lower_displacement_z(self) -> Optional[Array]:
        """Length [x, y]: normal displacement of the lower face of the slab, positive upwards. With `lower_surface`
        only, otherwise None. Read-only.
        """
        return self._fields.get("lower_displacement_z")

    @property
    def lower_gap(self) -> Optional[Array]:
        """Length [x, y]: distance between the lower face of the slab and the lower surface. With `lower_surface`
        only, otherwise None. Read-only.
        """
        return self._fields.get("lower_gap")

    @property
    def repulsion(self) -> Optional[Array]:
        """Stress [x, y]: repulsive pressure, without attraction; positive at the points in contact. With `law` only,
        otherwise None. Read-only.
        """
        return self._fields.get("repulsion")


class Steps(Record):
    """The numbers of the steps of a path."""

    @property
    def mean_pressure(self) -> Array:
        """Stress [step]: mean pressure over the whole surface; negative if it is pulled."""
        return self._value("mean_pressure")

    @property
    def p_star(self) -> Array:
        """Without unit [step]: reduced pressure p/(E* g)."""
        return self._value("p_star")

    @property
    def displacement(self) -> Array:
        """Length [step]: rigid approach beyond first touch."""
        return self._value("displacement")

    @property
    def time(self) -> Array:
        """Time [step]: time since first touch, in the unit of the relaxation times. With `prony` only."""
        return self._value("time")

    @property
    def distance(self) -> Array:
        """Length [step]: sliding distance since first touch. With `coefficient` only."""
        return self._value("distance")

    @property
    def lateral(self) -> Array:
        """Length [step, 2]: lateral displacement of the rigid surface."""
        return self._value("lateral")

    @property
    def mean_shear(self) -> Array:
        """Stress [step, 2]: mean shear traction on the elastic surface."""
        return self._value("mean_shear")

    @property
    def area_fraction(self) -> Array:
        """Without unit [step]: points that are repelled over all points."""
        return self._value("area_fraction")

    @property
    def stick_fraction(self) -> Array:
        """Without unit [step]: points in contact whose shear is below its limit, over all points; NaN without
        friction.
        """
        return self._value("stick_fraction")

    @property
    def mean_gap(self) -> Array:
        """Length [step]: mean distance between the surfaces."""
        return self._value("mean_gap")

    @property
    def max_pressure(self) -> Array:
        """Stress [step]: largest pressure. With `law`: largest repulsive pressure. With `prony` or `coefficient`
        only.
        """
        return self._value("max_pressure")

    @property
    def wear_volume(self) -> Array:
        """Length [step]: mean over the whole surface of the depth lost so far, the volume over the area. With
        `coefficient` only.
        """
        return self._value("wear_volume")

    @property
    def max_wear(self) -> Array:
        """Length [step]: largest depth lost so far. With `coefficient` only."""
        return self._value("max_wear")

    @property
    def elastic_energy(self) -> Array:
        """Stress * length [step]: elastic energy per area of the surface. With `prony`: energy stored in the springs
        of all branches, per area of the surface.
        """
        return self._value("elastic_energy")

    @property
    def interface_energy(self) -> Array:
        """Stress * length [step]: energy of the law per area of the surface, zero far away; NaN if it has none."""
        return self._value("interface_energy")

    @property
    def dissipated(self) -> Array:
        """Stress * length [step]: energy lost in this step, per area; NaN if the law has no energy. With
        `coefficient`: work of the pressure on the depth lost in this step, per area, without the work of friction.
        With `prony`: energy lost in the dashpots in this step, per area. With `law` and `prony`: energy lost in the
        dashpots and in jumps in this step, per area; in the first one without jumps.
        """
        return self._value("dissipated")

    @property
    def dissipated_error(self) -> Array:
        """Stress * length [step]: estimated error of dissipated; NaN if the step was not halved, or if dissipated is
        unknown. With `prony`: estimated error of dissipated: twice its difference from a path in half as many
        increments; 0 in a step of no time without a law; NaN if that path was not followed. With `coefficient`:
        estimated error of dissipated: 0 in a step of no distance, else NaN.
        """
        return self._value("dissipated_error")

    @property
    def work_imbalance(self) -> Array:
        """Stress * length [step]: work of the rigid surface by the trapezoidal rule less the energies gained and
        lost, in magnitude. With `law`: work of the rigid surface by the trapezoidal rule less the energies gained
        and lost, in magnitude; in a step with a jump the largest error of that rule; 0 in the first step of no time.
        With `prony` or `coefficient` only.
        """
        return self._value("work_imbalance")

    @property
    def passed_instability(self) -> npt.NDArray[Any]:
        """Flag [step]: true if more energy was lost in a jump of this step than its error; NaN if no energy tells."""
        return self._value("passed_instability")

    @property
    def lowest_curvature(self) -> Array:
        """Without unit [step]: lowest curvature met in the last search for a step, over the elastic curvature."""
        return self._value("lowest_curvature")

    @property
    def extra_solves(self) -> npt.NDArray[Any]:
        """Count [step]: further solves to find the energy lost in the step."""
        return self._value("extra_solves")

    @property
    def increments(self) -> npt.NDArray[Any]:
        """Count [step]: equal increments in which the step was made until they changed nothing. With `friction`
        only.
        """
        return self._value("increments")

    @property
    def iterations(self) -> npt.NDArray[Any]:
        """Count [step]: steps of the solver, extra solves included."""
        return self._value("iterations")

    @property
    def transform_pairs(self) -> Array:
        """Without unit [step]: forward and inverse transforms of one component, in pairs, extra solves included."""
        return self._value("transform_pairs")

    @property
    def converged(self) -> npt.NDArray[Any]:
        """Flag [step]: true if all residuals are at most the tolerance."""
        return self._value("converged")

    @property
    def residual_equilibrium(self) -> Array:
        """Without unit [step]: largest unbalanced force per area, from the final fields, / the stress scale (the
        largest traction, or the softest stiffness times h_rms if more). In some problems only.
        """
        return self._value("residual_equilibrium")

    @property
    def residual_complementarity(self) -> Array:
        """Without unit [step]: sum(p gap) / (sum(p) h_rms), from the final fields. In some problems only."""
        return self._value("residual_complementarity")

    @property
    def residual_penetration(self) -> Array:
        """Without unit [step]: max(0, -min gap) / h_rms, from the final fields."""
        return self._value("residual_penetration")

    @property
    def residual_negative_pressure(self) -> Array:
        """Without unit [step]: max(0, -min p) / mean p, from the final fields. In some problems only."""
        return self._value("residual_negative_pressure")

    @property
    def residual_wall_tension(self) -> Array:
        """Without unit [step]: largest tension that the wall would have to hold. In some problems only."""
        return self._value("residual_wall_tension")

    @property
    def residual_load(self) -> Array:
        """Without unit [step]: |mean p - asked| / asked, from the final fields. With `law`: |mean p - asked| from
        the final fields, 0 if the approach is prescribed, / the stress scale (the largest traction, or the softest
        stiffness times h_rms if more).
        """
        return self._value("residual_load")

    @property
    def residual_friction(self) -> Array:
        """Without unit [step]: largest distance of the shear from its law / the largest limit. With `friction` only."""
        return self._value("residual_friction")

    @property
    def residual_excess(self) -> Array:
        """Without unit [step]: largest excess of the shear over its limit / the largest limit. With `friction` only."""
        return self._value("residual_excess")

    @property
    def residual_saturation(self) -> Array:
        """Without unit [step]: largest gap / h_rms where the pressure is the hardness. With `hardness` only."""
        return self._value("residual_saturation")

    @property
    def seconds(self) -> Array:
        """Seconds [step]: wall time of a load: solution and, of a contact, stiffness, statistics, flow; without
        finer grids.
        """
        return self._value("seconds")

    @property
    def plastic_fraction(self) -> Array:
        """Without unit [step]: points whose pressure is the hardness, to its accuracy, over all points. With
        `hardness` only.
        """
        return self._value("plastic_fraction")

    @property
    def plastic_volume(self) -> Array:
        """Length [step]: mean plastic depth so far. With `hardness` only."""
        return self._value("plastic_volume")

    @property
    def flow_xx(self) -> Array:
        """Without unit [step]: mean flux along x by a mean pressure gradient along x, over that of a uniform gap
        equal to the mean gap. With `flow` only.
        """
        return self._value("flow_xx")

    @property
    def flow_xy(self) -> Array:
        """Without unit [step]: mean flux along x by a mean pressure gradient along y, over that of a uniform gap
        equal to the mean gap. With `flow` only.
        """
        return self._value("flow_xy")

    @property
    def flow_yx(self) -> Array:
        """Without unit [step]: mean flux along y by a mean pressure gradient along x, over that of a uniform gap
        equal to the mean gap. With `flow` only.
        """
        return self._value("flow_yx")

    @property
    def flow_yy(self) -> Array:
        """Without unit [step]: mean flux along y by a mean pressure gradient along y, over that of a uniform gap
        equal to the mean gap. With `flow` only.
        """
        return self._value("flow_yy")

    @property
    def flow_percolates_x(self) -> npt.NDArray[Any]:
        """Flag [step]: true if the gap lets a fluid through along x. With `flow` only."""
        return self._value("flow_percolates_x")

    @property
    def flow_percolates_y(self) -> npt.NDArray[Any]:
        """Flag [step]: true if the gap lets a fluid through along y. With `flow` only."""
        return self._value("flow_percolates_y")

    @property
    def flow_residual(self) -> Array:
        """Without unit [step]: largest of what is missing in a cell and the deviations of sections and power, over
        the mean flow. With `flow` only.
        """
        return self._value("flow_residual")

    @property
    def mean_pressure_limit(self) -> Array:
        """Stress [step]: estimate of mean_pressure on an infinitely fine grid at the same approach. With `approach`
        only.
        """
        return self._value("mean_pressure_limit")

    @property
    def mean_pressure_limit_error(self) -> Array:
        """Stress [step]: 95 % of the errors of mean_pressure_limit are smaller. With `approach` only."""
        return self._value("mean_pressure_limit_error")

    @property
    def mean_pressure_grid_error(self) -> Array:
        """Stress [step]: error of mean_pressure by the finite grid: |mean_pressure - limit| + limit_error. With
        `approach` only.
        """
        return self._value("mean_pressure_grid_error")

    @property
    def mean_shear_limit(self) -> Array:
        """Stress [step, 2]: estimate of mean_shear_x on an infinitely fine grid under the same mean pressure. With
        `friction` or `lateral` only.
        """
        return self._value("mean_shear_limit")

    @property
    def mean_shear_limit_error(self) -> Array:
        """Stress [step, 2]: 95 % of the errors of mean_shear_x_limit are smaller. With `friction` or `lateral` only."""
        return self._value("mean_shear_limit_error")

    @property
    def mean_shear_grid_error(self) -> Array:
        """Stress [step, 2]: error of mean_shear_x by the finite grid: |mean_shear_x - limit| + limit_error. With
        `friction` or `lateral` only.
        """
        return self._value("mean_shear_grid_error")

    @property
    def displacement_limit(self) -> Array:
        """Length [step]: estimate of displacement on an infinitely fine grid under the same mean pressure."""
        return self._value("displacement_limit")

    @property
    def displacement_limit_error(self) -> Array:
        """Length [step]: 95 % of the errors of displacement_limit are smaller."""
        return self._value("displacement_limit_error")

    @property
    def displacement_grid_error(self) -> Array:
        """Length [step]: error of displacement by the finite grid: |displacement - limit| + limit_error."""
        return self._value("displacement_grid_error")

    @property
    def area_fraction_limit(self) -> Array:
        """Without unit [step]: estimate of area_fraction on an infinitely fine grid under the same mean pressure."""
        return self._value("area_fraction_limit")

    @property
    def area_fraction_limit_error(self) -> Array:
        """Without unit [step]: 95 % of the errors of area_fraction_limit are smaller."""
        return self._value("area_fraction_limit_error")

    @property
    def area_fraction_grid_error(self) -> Array:
        """Without unit [step]: error of area_fraction by the finite grid: |area_fraction - limit| + limit_error."""
        return self._value("area_fraction_grid_error")

    @property
    def mean_gap_limit(self) -> Array:
        """Length [step]: estimate of mean_gap on an infinitely fine grid under the same mean pressure."""
        return self._value("mean_gap_limit")

    @property
    def mean_gap_limit_error(self) -> Array:
        """Length [step]: 95 % of the errors of mean_gap_limit are smaller."""
        return self._value("mean_gap_limit_error")

    @property
    def mean_gap_grid_error(self) -> Array:
        """Length [step]: error of mean_gap by the finite grid: |mean_gap - limit| + limit_error."""
        return self._value("mean_gap_grid_error")

    @property
    def elastic_energy_limit(self) -> Array:
        """Stress * length [step]: estimate of elastic_energy on an infinitely fine grid under the same mean
        pressure.
        """
        return self._value("elastic_energy_limit")

    @property
    def elastic_energy_limit_error(self) -> Array:
        """Stress * length [step]: 95 % of the errors of elastic_energy_limit are smaller."""
        return self._value("elastic_energy_limit_error")

    @property
    def elastic_energy_grid_error(self) -> Array:
        """Stress * length [step]: error of elastic_energy by the finite grid: |elastic_energy - limit| +
        limit_error.
        """
        return self._value("elastic_energy_grid_error")

    @property
    def interface_energy_limit(self) -> Array:
        """Stress * length [step]: estimate of interface_energy on an infinitely fine grid under the same mean
        pressure. In some problems only.
        """
        return self._value("interface_energy_limit")

    @property
    def interface_energy_limit_error(self) -> Array:
        """Stress * length [step]: 95 % of the errors of interface_energy_limit are smaller. In some problems only."""
        return self._value("interface_energy_limit_error")

    @property
    def interface_energy_grid_error(self) -> Array:
        """Stress * length [step]: error of interface_energy by the finite grid: |interface_energy - limit| +
        limit_error. In some problems only.
        """
        return self._value("interface_energy_grid_error")

    @property
    def dissipated_limit(self) -> Array:
        """Stress * length [step]: estimate of dissipated on an infinitely fine grid under the same mean pressure."""
        return self._value("dissipated_limit")

    @property
    def dissipated_limit_error(self) -> Array:
        """Stress * length [step]: 95 % of the errors of dissipated_limit are smaller."""
        return self._value("dissipated_limit_error")

    @property
    def dissipated_grid_error(self) -> Array:
        """Stress * length [step]: error of dissipated by the finite grid: |dissipated - limit| + limit_error."""
        return self._value("dissipated_grid_error")

    @property
    def flow_xx_limit(self) -> Array:
        """Without unit [step]: estimate of flow_xx on an infinitely fine grid under the same mean pressure. With
        `flow` only.
        """
        return self._value("flow_xx_limit")

    @property
    def flow_xx_limit_error(self) -> Array:
        """Without unit [step]: 95 % of the errors of flow_xx_limit are smaller. With `flow` only."""
        return self._value("flow_xx_limit_error")

    @property
    def flow_xx_grid_error(self) -> Array:
        """Without unit [step]: error of flow_xx by the finite grid: |flow_xx - limit| + limit_error. With `flow`
        only.
        """
        return self._value("flow_xx_grid_error")

    @property
    def flow_yy_limit(self) -> Array:
        """Without unit [step]: estimate of flow_yy on an infinitely fine grid under the same mean pressure. With
        `flow` only.
        """
        return self._value("flow_yy_limit")

    @property
    def flow_yy_limit_error(self) -> Array:
        """Without unit [step]: 95 % of the errors of flow_yy_limit are smaller. With `flow` only."""
        return self._value("flow_yy_limit_error")

    @property
    def flow_yy_grid_error(self) -> Array:
        """Without unit [step]: error of flow_yy by the finite grid: |flow_yy - limit| + limit_error. With `flow`
        only.
        """
        return self._value("flow_yy_grid_error")


class StepFields(Record):
    """The fields of a path."""

    @property
    def pressure(self) -> Array:
        """Stress [waypoint, x, y]: pressure on the elastic surface, compression positive; attraction is negative.
        Read-only.
        """
        return self._value("pressure")

    @property
    def displacement_z(self) -> Array:
        """Length [waypoint, x, y]: normal displacement of the elastic surface, negative downwards. Read-only."""
        return self._value("displacement_z")

    @property
    def gap(self) -> Array:
        """Length [waypoint, x, y]: distance between the surfaces. Read-only."""
        return self._value("gap")

    @property
    def plastic_depth(self) -> Array:
        """Length [waypoint, x, y]: depth by which the surfaces were pressed into each other so far. With `hardness`
        only. Read-only.
        """
        return self._value("plastic_depth")

    @property
    def shear_x(self) -> Array:
        """Stress [waypoint, x, y]: shear traction on the elastic surface along x. With `friction` or `lateral` only.
        Read-only.
        """
        return self._value("shear_x")

    @property
    def shear_y(self) -> Array:
        """Stress [waypoint, x, y]: shear traction on the elastic surface along y. In some problems only. Read-only."""
        return self._value("shear_y")


class WearFields(Record):
    """The fields of wear."""

    @property
    def pressure(self) -> Array:
        """Stress [waypoint, x, y]: pressure on the elastic surface, compression positive; attraction is negative.
        Read-only.
        """
        return self._value("pressure")

    @property
    def displacement_z(self) -> Array:
        """Length [waypoint, x, y]: normal displacement of the elastic surface, negative downwards. Read-only."""
        return self._value("displacement_z")

    @property
    def gap(self) -> Array:
        """Length [waypoint, x, y]: distance between the surfaces. Read-only."""
        return self._value("gap")

    @property
    def wear_depth(self) -> Array:
        """Length [waypoint, x, y]: depth that both surfaces have lost so far. Read-only."""
        return self._value("wear_depth")


class Patches(Record):
    """The patches of points in contact, as `gfmd contact --statistics` measures them."""

    @property
    def area(self) -> Array:
        """Length^2 [patch]: area: number of points times that of a cell."""
        return self._value("area")

    @property
    def perimeter(self) -> Array:
        """Length [patch]: length of the edges between points in contact and points not in contact; the edge of a
        patch with free boundaries has no part in it.
        """
        return self._value("perimeter")

    @property
    def force(self) -> Array:
        """Stress * length^2 [patch]: force on the patch."""
        return self._value("force")

    @property
    def x(self) -> Array:
        """Length [patch]: x of the centre of area; NaN if the patch winds around the cell along x."""
        return self._value("x")

    @property
    def y(self) -> Array:
        """Length [patch]: y of the centre of area; NaN if the patch winds around the cell along y."""
        return self._value("y")
