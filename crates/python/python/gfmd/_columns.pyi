"""The numbers and fields of results, with their units and definitions.

Made from crates/record/src by `GFMD_DOCS=write cargo test -p gfmd-record`.
"""

from typing import Any, Optional

import numpy.typing as npt

from ._check import Array
from ._load import Residual
from ._record import Record

class Residuals(Record):
    """The residuals of a load."""

    @property
    def complementarity(self) -> float:
        """Without unit: sum(p gap) / (sum(p) h_rms), from the final fields. With `law` or `lower_surface`: sum(p
        gap) / (sum(p) h_rms), from the final fields; larger of the two faces. With `law`: sum(p gap) / (sum(p)
        h_rms) with the wall pressure p, from the final fields.
        """

    @property
    def penetration(self) -> float:
        """Without unit: max(0, -min gap) / h_rms, from the final fields. With `lower_surface`: max(0, -min gap) /
        h_rms, from the final fields; larger of the two faces.
        """

    @property
    def negative_pressure(self) -> float:
        """Without unit: max(0, -min p) / mean p, from the final fields. With `law` or `lower_surface`: max(0, -min
        p) / mean p, from the final fields; larger of the two faces. With `law`: largest tension that the wall would
        have to carry, from the final fields, divided by the stress scale (larger of the largest traction and the
        softest stiffness times h_rms).
        """

    @property
    def load(self) -> float:
        """Without unit: |mean p - prescribed| / prescribed, from the final fields. With `law` or `lower_surface`:
        |mean p - prescribed| / prescribed, larger of the two faces; under a prescribed approach, the difference
        between the mean pressures on both faces divided by their mean. With `law`: |mean p - prescribed|, from the
        final fields (0 if the approach is prescribed), divided by the stress scale (larger of the largest traction
        and the softest stiffness times h_rms).
        """

    @property
    def saturation(self) -> float:
        """Without unit: largest gap / h_rms at points at the hardness. With `lower_surface`: largest gap / h_rms at
        points at the hardness; larger of the two faces. With `hardness` only.
        """

    @property
    def lateral_traction(self) -> float:
        """Without unit: largest lateral traction left by the dynamics, divided by the largest pressure. With
        `components="all"` only.
        """

    @property
    def lateral_displacement(self) -> float:
        """Without unit: last change of the lateral displacement / h_rms: its consistency with the pressure. With
        `finite_slope` only.
        """

class LowerFace(Record):
    """The numbers of the lower face of a slab between two surfaces."""

    @property
    def mean_pressure(self) -> float:
        """Stress: mean pressure over the whole lower surface."""

    @property
    def approach(self) -> float:
        """Length: part of the approach at the lower face."""

    @property
    def area_fraction(self) -> float:
        """Without unit: contact area fraction of the lower face."""

    @property
    def area_fraction_corrected(self) -> float:
        """Without unit: contact area fraction of the lower face, corrected for the excess of perimeter pixels."""

    @property
    def contact_nodes(self) -> int:
        """Count: number of points in contact at the lower face."""

    @property
    def boundary_links(self) -> int:
        """Count: number of neighbouring pairs with exactly one point in contact, at the lower face."""

    @property
    def mean_gap(self) -> float:
        """Length: mean distance between lower face and lower surface."""

    @property
    def max_pressure(self) -> float:
        """Stress: largest pressure on the lower face."""

    @property
    def mean_pressure_in_contact(self) -> float:
        """Stress: mean pressure over the points in contact at the lower face."""

    @property
    def plastic_fraction(self) -> float:
        """Without unit: share of lower-face points at the hardness. With `hardness` only."""

    @property
    def plastic_volume(self) -> float:
        """Length: mean plastic depth over the whole lower face. With `hardness` only."""

    @property
    def residual(self) -> Residual:
        """Residuals, recomputed from the final fields; `float(...)` is the largest. In some problems only."""

class Numbers(Record):
    """The numbers of a load."""

    @property
    def mean_pressure(self) -> float:
        """Stress: mean pressure over the whole surface."""

    @property
    def p_star(self) -> float:
        """Without unit: reduced pressure p/(E* g)."""

    @property
    def force(self) -> float:
        """Stress * length^2: force; of a profile, per unit width (stress*length). With `boundary="free"` only."""

    @property
    def approach(self) -> float:
        """Length: rigid approach beyond first touch. In some problems: rigid approach beyond first touch, relative
        to points one profile length away. With `lower_surface`: approach of the two rigid surfaces beyond the
        distance where both touch the undeformed slab.
        """

    @property
    def mean_shear(self) -> list[float]:
        """Stress along x and y: mean traction that holds the rigid surface in place. With `finite_slope` only."""

    @property
    def area_fraction(self) -> float:
        """Without unit: contact area fraction: share of points in contact. With `law`: contact area fraction: share
        of points that are repelled.
        """

    @property
    def area_fraction_corrected(self) -> float:
        """Without unit: contact area fraction, corrected for the excess of perimeter pixels (Yastrebov et al. 2017)."""

    @property
    def kappa(self) -> float:
        """Without unit: area_fraction / p_star. With `law`: area_fraction / p_star; NaN if attraction carries the
        load.
        """

    @property
    def kappa_corrected(self) -> float:
        """Without unit: area_fraction_corrected / p_star. With `law`: area_fraction_corrected / p_star; NaN if
        attraction carries the load.
        """

    @property
    def contact_nodes(self) -> int:
        """Count: number of points in contact. With `law`: number of points that are repelled."""

    @property
    def boundary_links(self) -> int:
        """Count: number of neighbouring pairs with exactly one point in contact. With `law`: number of neighbouring
        pairs with exactly one point repelled.
        """

    @property
    def mean_gap(self) -> float:
        """Length: mean distance between the surfaces."""

    @property
    def max_pressure(self) -> float:
        """Stress: largest pressure. With `law`: largest repulsive pressure."""

    @property
    def max_net_pressure(self) -> float:
        """Stress: largest net pressure on the body (repulsion minus attraction), at most the hardness. With `law`
        and `hardness` only.
        """

    @property
    def mean_pressure_in_contact(self) -> float:
        """Stress: mean pressure over the points in contact. With `law`: mean repulsive pressure over the points that
        are repelled.
        """

    @property
    def pressure_deviation_in_contact(self) -> float:
        """Stress: standard deviation of the pressure over the points in contact. With `law`: standard deviation of
        the repulsive pressure over the points that are repelled.
        """

    @property
    def pressure_moment_2(self) -> float:
        """Stress^2: mean square pressure over the whole surface. With `law`: mean square repulsive pressure over the
        whole surface.
        """

    @property
    def elastic_energy(self) -> float:
        """Stress * length: elastic energy per area of the surface. In some problems: elastic energy per area,
        relative to points one profile length away. With `lower_surface`: elastic energy of the slab per area, from
        the pressures on both faces.
        """

    @property
    def interface_energy(self) -> float:
        """Stress * length: energy of the contact law per area, zero at large gaps. With `lower_surface`: energy of
        the law per area at both faces, zero at large gaps. With `law` only.
        """

    @property
    def passed_instability(self) -> bool:
        """Flag: true if the search from the last load met negative curvature. With `law` only."""

    @property
    def lowest_curvature(self) -> float:
        """Without unit: lowest curvature in the last search for a step, relative to the preconditioner. With `law`
        only.
        """

    @property
    def stiffness(self) -> float:
        """Stress/length: d(mean pressure)/d(approach) with fixed points in contact and constant pressure at the
        hardness; NaN where infinite (full contact with a fixed mean level) or not computed, with the reason in the
        attribute undefined.
        """

    @property
    def stiffness_error(self) -> float:
        """Without unit: relative error of the stiffness, from the residual of its linear problem."""

    @property
    def iterations(self) -> int:
        """Count: solver iterations or time steps."""

    @property
    def transform_pairs(self) -> float:
        """Without unit: pairs of forward and inverse real transforms of the full grid."""

    @property
    def converged(self) -> bool:
        """Flag: true if all residuals of this load are at most the tolerance. With `law`: true if all five residuals
        are at most the tolerance.
        """

    @property
    def residual(self) -> Residual:
        """Residuals, recomputed from the final fields; `float(...)` is the largest."""

    @property
    def seconds(self) -> float:
        """Seconds: wall time of a load: solution and, for a contact, stiffness, statistics and flow; excludes finer
        grids.
        """

    @property
    def plastic_fraction(self) -> float:
        """Without unit: share of points at the hardness. With `lower_surface`: share of upper-face points at the
        hardness. With `hardness` only.
        """

    @property
    def plastic_volume(self) -> float:
        """Length: mean plastic depth over the whole surface. With `lower_surface`: mean plastic depth over the whole
        upper face. With `hardness` only.
        """

    @property
    def projected_area_fraction(self) -> float:
        """Without unit: contact area of the deformed surface projected onto the plane of the rigid one, divided by
        the cell area. With `finite_slope` only.
        """

    @property
    def lower(self) -> LowerFace:
        """Numbers of the lower face. With `lower_surface` only."""

    @property
    def residual_equilibrium(self) -> float:
        """Without unit: largest unbalanced force per area, from the final fields, divided by the stress scale
        (larger of the largest traction and the softest stiffness times h_rms). With `law` only.
        """

    @property
    def mean_pressure_limit(self) -> float:
        """Stress: estimate of mean_pressure on an infinitely fine grid at the same approach. In some problems only."""

    @property
    def mean_pressure_limit_error(self) -> float:
        """Stress: error bound (95 %) of mean_pressure_limit. In some problems only."""

    @property
    def mean_pressure_grid_error(self) -> float:
        """Stress: grid error of mean_pressure: |mean_pressure - limit| + limit_error. In some problems only."""

    @property
    def approach_limit(self) -> float:
        """Length: estimate of approach on an infinitely fine grid under the same mean pressure. In some problems
        only.
        """

    @property
    def approach_limit_error(self) -> float:
        """Length: error bound (95 %) of approach_limit. In some problems only."""

    @property
    def approach_grid_error(self) -> float:
        """Length: grid error of approach: |approach - limit| + limit_error. In some problems only."""

    @property
    def area_fraction_limit(self) -> float:
        """Without unit: estimate of area_fraction on an infinitely fine grid under the same mean pressure."""

    @property
    def area_fraction_limit_error(self) -> float:
        """Without unit: error bound (95 %) of area_fraction_limit."""

    @property
    def area_fraction_grid_error(self) -> float:
        """Without unit: grid error of area_fraction: |area_fraction - limit| + limit_error."""

    @property
    def kappa_limit(self) -> float:
        """Without unit: estimate of kappa on an infinitely fine grid under the same mean pressure."""

    @property
    def kappa_limit_error(self) -> float:
        """Without unit: error bound (95 %) of kappa_limit."""

    @property
    def kappa_grid_error(self) -> float:
        """Without unit: grid error of kappa: |kappa - limit| + limit_error."""

    @property
    def boundary_links_limit(self) -> float:
        """Without unit: estimate of the boundary length on an infinitely fine grid, in steps of this grid."""

    @property
    def boundary_links_limit_error(self) -> float:
        """Without unit: error bound (95 %) of boundary_links_limit."""

    @property
    def boundary_links_grid_error(self) -> float:
        """Without unit: grid error of boundary_links: |boundary_links - limit| + limit_error."""

    @property
    def mean_gap_limit(self) -> float:
        """Length: estimate of mean_gap on an infinitely fine grid under the same mean pressure."""

    @property
    def mean_gap_limit_error(self) -> float:
        """Length: error bound (95 %) of mean_gap_limit."""

    @property
    def mean_gap_grid_error(self) -> float:
        """Length: grid error of mean_gap: |mean_gap - limit| + limit_error."""

    @property
    def max_pressure_limit(self) -> float:
        """Stress: estimate of max_pressure on an infinitely fine grid under the same mean pressure."""

    @property
    def max_pressure_limit_error(self) -> float:
        """Stress: error bound (95 %) of max_pressure_limit."""

    @property
    def max_pressure_grid_error(self) -> float:
        """Stress: grid error of max_pressure: |max_pressure - limit| + limit_error."""

    @property
    def mean_pressure_in_contact_limit(self) -> float:
        """Stress: estimate of mean_pressure_in_contact on an infinitely fine grid under the same mean pressure."""

    @property
    def mean_pressure_in_contact_limit_error(self) -> float:
        """Stress: error bound (95 %) of mean_pressure_in_contact_limit."""

    @property
    def mean_pressure_in_contact_grid_error(self) -> float:
        """Stress: grid error of mean_pressure_in_contact: |mean_pressure_in_contact - limit| + limit_error."""

    @property
    def pressure_deviation_in_contact_limit(self) -> float:
        """Stress: estimate of pressure_deviation_in_contact on an infinitely fine grid under the same mean pressure."""

    @property
    def pressure_deviation_in_contact_limit_error(self) -> float:
        """Stress: error bound (95 %) of pressure_deviation_in_contact_limit."""

    @property
    def pressure_deviation_in_contact_grid_error(self) -> float:
        """Stress: grid error of pressure_deviation_in_contact: |pressure_deviation_in_contact - limit| +
        limit_error.
        """

    @property
    def pressure_moment_2_limit(self) -> float:
        """Stress^2: estimate of pressure_moment_2 on an infinitely fine grid under the same mean pressure."""

    @property
    def pressure_moment_2_limit_error(self) -> float:
        """Stress^2: error bound (95 %) of pressure_moment_2_limit."""

    @property
    def pressure_moment_2_grid_error(self) -> float:
        """Stress^2: grid error of pressure_moment_2: |pressure_moment_2 - limit| + limit_error."""

    @property
    def elastic_energy_limit(self) -> float:
        """Stress * length: estimate of elastic_energy on an infinitely fine grid under the same mean pressure."""

    @property
    def elastic_energy_limit_error(self) -> float:
        """Stress * length: error bound (95 %) of elastic_energy_limit."""

    @property
    def elastic_energy_grid_error(self) -> float:
        """Stress * length: grid error of elastic_energy: |elastic_energy - limit| + limit_error."""

    @property
    def interface_energy_limit(self) -> float:
        """Stress * length: estimate of interface_energy on an infinitely fine grid under the same mean pressure.
        With `law` only.
        """

    @property
    def interface_energy_limit_error(self) -> float:
        """Stress * length: error bound (95 %) of interface_energy_limit. With `law` only."""

    @property
    def interface_energy_grid_error(self) -> float:
        """Stress * length: grid error of interface_energy: |interface_energy - limit| + limit_error. With `law`
        only.
        """

    @property
    def stiffness_limit(self) -> float:
        """Stress/length: estimate of stiffness on an infinitely fine grid under the same mean pressure."""

    @property
    def stiffness_limit_error(self) -> float:
        """Stress/length: error bound (95 %) of stiffness_limit."""

    @property
    def stiffness_grid_error(self) -> float:
        """Stress/length: grid error of stiffness: |stiffness - limit| + limit_error."""

class Fields:
    """The fields of a load."""

    _fields: dict[str, Array]

    @property
    def pressure(self) -> Array:
        """Stress [x, y]: pressure on the elastic surface, compression positive; attraction is negative. Read-only."""

    @property
    def displacement_z(self) -> Array:
        """Length [x, y]: normal displacement of the elastic surface, negative downwards. Read-only."""

    @property
    def gap(self) -> Array:
        """Length [x, y]: distance between the surfaces. Read-only."""

    @property
    def plastic_depth(self) -> Optional[Array]:
        """Length [x, y]: depth by which the surfaces are pressed into each other beyond touching. With
        `lower_surface`: depth by which the upper face and surface are pressed into each other beyond touching. With
        `hardness` only, otherwise None. Read-only.
        """

    @property
    def displacement_x(self) -> Optional[Array]:
        """Length [x, y]: displacement of the elastic surface along x. With `components="all"` or `finite_slope`
        only, otherwise None. Read-only.
        """

    @property
    def displacement_y(self) -> Optional[Array]:
        """Length [x, y]: displacement of the elastic surface along y. In some problems only, otherwise None.
        Read-only.
        """

    @property
    def lower_pressure(self) -> Optional[Array]:
        """Stress [x, y]: pressure on the lower face of the slab. With `law`: pressure on the lower face of the slab;
        attraction is negative. With `lower_surface` only, otherwise None. Read-only.
        """

    @property
    def lower_displacement_z(self) -> Optional[Array]:
        """Length [x, y]: normal displacement of the lower face of the slab, positive upwards. With `lower_surface`
        only, otherwise None. Read-only.
        """

    @property
    def lower_gap(self) -> Optional[Array]:
        """Length [x, y]: distance between the lower face of the slab and the lower surface. With `lower_surface`
        only, otherwise None. Read-only.
        """

    @property
    def lower_plastic_depth(self) -> Optional[Array]:
        """Length [x, y]: depth by which the lower face and surface are pressed into each other beyond touching. With
        `hardness` and `lower_surface` only, otherwise None. Read-only.
        """

    @property
    def lower_repulsion(self) -> Optional[Array]:
        """Stress [x, y]: repulsive pressure on the lower face of the slab, without attraction. With `law` and
        `lower_surface` only, otherwise None. Read-only.
        """

    @property
    def repulsion(self) -> Optional[Array]:
        """Stress [x, y]: repulsive pressure, without attraction; positive at the points in contact. With `law` only,
        otherwise None. Read-only.
        """

class Steps(Record):
    """The numbers of the steps of a path."""

    @property
    def mean_pressure(self) -> Array:
        """Stress [step]: mean pressure over the whole surface; negative under tension."""

    @property
    def p_star(self) -> Array:
        """Without unit [step]: reduced pressure p/(E* g)."""

    @property
    def force(self) -> Array:
        """Stress * length^2 [step]: force; of a profile, per unit width (stress*length). With `boundary="free"`
        only.
        """

    @property
    def approach(self) -> Array:
        """Length [step]: rigid approach beyond first touch. In some problems: rigid approach beyond first touch,
        relative to points one profile length away. With `lower_surface`: approach of the two rigid surfaces beyond
        the distance where both touch the undeformed slab.
        """

    @property
    def time(self) -> Array:
        """Time [step]: time since first touch, in the unit of the relaxation times. With `prony` only."""

    @property
    def distance(self) -> Array:
        """Length [step]: sliding distance since first touch. With `wear` only."""

    @property
    def lateral(self) -> Array:
        """Length [step, 2]: lateral displacement of the rigid surface."""

    @property
    def mean_shear(self) -> Array:
        """Stress [step, 2]: mean shear traction on the elastic surface."""

    @property
    def area_fraction(self) -> Array:
        """Without unit [step]: share of points that are repelled."""

    @property
    def stick_fraction(self) -> Array:
        """Without unit [step]: fraction of all points that touch with a shear below its limit; NaN without friction."""

    @property
    def mean_gap(self) -> Array:
        """Length [step]: mean distance between the surfaces."""

    @property
    def max_pressure(self) -> Array:
        """Stress [step]: largest pressure. With `law`: largest repulsive pressure. In some problems only."""

    @property
    def max_net_pressure(self) -> Array:
        """Stress [step]: largest net pressure on the body (repulsion minus attraction), at most the hardness. With
        `law` and `hardness` only.
        """

    @property
    def wear_volume(self) -> Array:
        """Length [step]: mean depth lost so far, over the whole surface. With `lower_surface`: mean depth lost so
        far, over the whole upper face. With `wear` only.
        """

    @property
    def wear_volume_error(self) -> Array:
        """Length [step]: estimated error of wear_volume by the finite length of all increments so far: twice its
        difference from a path with half as many; NaN if that path was not followed. With `wear` only.
        """

    @property
    def max_wear(self) -> Array:
        """Length [step]: largest depth lost so far. With `lower_surface`: largest depth lost so far at the upper
        face. With `wear` only.
        """

    @property
    def elastic_energy(self) -> Array:
        """Stress * length [step]: elastic energy per area of the surface. In some problems: elastic energy per area,
        relative to points one profile length away. With `yield_stress`: elastic energy per area, including the
        energy of residual stress. With `lower_surface` or `prony`: elastic energy per area in the springs of all
        branches. With `lower_surface`: elastic energy of the slab per area, from the pressures on both faces.
        """

    @property
    def interface_energy(self) -> Array:
        """Stress * length [step]: energy of the law per area, zero at large gaps; NaN if the law has no potential.
        With `lower_surface`: energy of the law per area at both faces, zero at large gaps.
        """

    @property
    def dissipated(self) -> Array:
        """Stress * length [step]: energy lost in this step, per area; with a law, at least minus its error; NaN if
        the law has no potential. With `yield_stress`: energy dissipated by plastic strain in this step, per area,
        excluding hardening_energy. In some problems: work of the pressure on the depth lost in this step, per area,
        excluding friction. In some problems: energy lost in the dashpots in this step, per area. With `law` and
        `friction` or `law` and `hardness="or __coefficient"` or `friction` and `hardness="or __coefficient"` or
        `law` and `prony` or `friction` and `prony` or `hardness="or __coefficient"` and `prony` or `hardness` and
        `wear`: energy lost in dashpots and jumps in this step, per area; the first step counts no jumps. With `law`
        and `friction` or `law` and `hardness="or __coefficient"` or `friction` and `hardness="or __coefficient"` or
        `friction` and `prony` or `hardness="or __coefficient"` and `prony` or `hardness` and `wear`: energy lost in
        this step, per area: the sum of the columns lost_*.
        """

    @property
    def hardening_energy(self) -> Array:
        """Stress * length [step]: energy stored by hardening, per area; not recoverable with isotropic hardening.
        With `yield_stress` only.
        """

    @property
    def lost_relaxation(self) -> Array:
        """Stress * length [step]: energy lost in the dashpots in this step, per area (part of dissipated). With
        `law` and `prony` or `friction` and `prony` or `hardness="or __coefficient"` and `prony` only.
        """

    @property
    def lost_friction(self) -> Array:
        """Stress * length [step]: energy lost by slip in this step, per area (part of dissipated). With `law` and
        `friction` or `friction` and `hardness="or __coefficient"` or `friction` and `prony` only.
        """

    @property
    def lost_wear(self) -> Array:
        """Stress * length [step]: work of the pressure on the depth worn off in this step, per area (part of
        dissipated). With `law` and `wear` or `hardness` and `wear` or `friction` and `wear` or `prony` and `wear`
        only.
        """

    @property
    def lost_plastic(self) -> Array:
        """Stress * length [step]: work of the pressure on the plastic depth gained in this step, per area (part of
        dissipated). With `law` and `hardness` or `hardness` and `friction` or `hardness` and `prony` or `hardness`
        and `wear` only.
        """

    @property
    def lost_jumps(self) -> Array:
        """Stress * length [step]: energy lost in jumps in this step, per area (part of dissipated): the remainder of
        the balance of work and energy, at least minus its error. With `law` and `friction` or `law` and
        `hardness="or __coefficient"` or `law` and `prony` only.
        """

    @property
    def dissipated_error(self) -> Array:
        """Stress * length [step]: estimated error of dissipated; NaN if the step was not halved or dissipated is
        unknown. In some problems: estimated error of dissipated: twice its difference from a path with half as many
        increments; 0 in a step of zero duration without a law; NaN if that path was not followed. With `law` and
        `friction` or `law` and `hardness="or __coefficient"` or `friction` and `hardness="or __coefficient"` or
        `friction` and `prony` or `hardness="or __coefficient"` and `prony` or `hardness="or __coefficient"` and
        `wear`: estimated error of dissipated: 0 in a step of zero distance, else NaN. With `law` and `friction` or
        `law` and `hardness="or __coefficient"` or `friction` and `hardness="or __coefficient"` or `friction` and
        `prony` or `hardness="or __coefficient"` and `prony` or `hardness` and `wear`: estimated error of dissipated,
        from a path with half as many increments; 0 in a step that cannot lose energy; NaN if that path was not
        followed.
        """

    @property
    def work_imbalance(self) -> Array:
        """Stress * length [step]: absolute difference between the work of the rigid surface (trapezoidal rule) and
        the energies gained and lost; the sum of a path excludes a first step of zero duration and distance. With
        `law` and `prony`: absolute difference between the work of the rigid surface (trapezoidal rule) and the
        energies gained and lost; in a step with a jump, the largest error of that rule; 0 in a first step of zero
        duration, which the sum of a path excludes. In some problems only.
        """

    @property
    def passed_instability(self) -> npt.NDArray[Any]:
        """Flag [step]: true if a jump in this step lost more energy than its error; NaN if no energy balance reveals
        jumps.
        """

    @property
    def lowest_curvature(self) -> Array:
        """Without unit [step]: lowest curvature in the last search for a step, relative to the preconditioner."""

    @property
    def stiffness(self) -> Array:
        """Stress/length [step]: instantaneous d(mean pressure)/d(approach) at the end of the step: fixed points in
        contact, constant pressure at the hardness (under a growing load; on unloading the contact is stiffer), no
        wear, instantaneous moduli of a viscoelastic body, no lateral motion; with friction points in contact stick;
        NaN where infinite (full contact with a fixed mean level) or not computed, with the reason in the attribute
        undefined. With `yield_stress`: d(mean pressure)/d(approach) at the end of the step with fixed points in
        contact: elastic, as at the onset of unloading; NaN where infinite (full contact with a fixed mean level),
        with the reason in the attribute undefined.
        """

    @property
    def stiffness_error(self) -> Array:
        """Without unit [step]: relative error of the stiffness, from the residual of its linear problem."""

    @property
    def extra_solves(self) -> npt.NDArray[Any]:
        """Count [step]: additional solves for the energy lost in the step."""

    @property
    def increments(self) -> npt.NDArray[Any]:
        """Count [step]: number of equal increments of the step, raised until the result did not change. With
        `friction` only.
        """

    @property
    def operators(self) -> npt.NDArray[Any]:
        """Count [step]: number of volume operators (plastic strain and pressure to strain), including extra solves.
        With `yield_stress` only.
        """

    @property
    def iterations(self) -> npt.NDArray[Any]:
        """Count [step]: solver steps, including extra solves. With `yield_stress`: number of volume operators, as in
        operators.
        """

    @property
    def transform_pairs(self) -> Array:
        """Without unit [step]: pairs of forward and inverse transforms of one component, including extra solves."""

    @property
    def converged(self) -> npt.NDArray[Any]:
        """Flag [step]: true if all residuals are at most the tolerance."""

    @property
    def residual_equilibrium(self) -> Array:
        """Without unit [step]: largest unbalanced force per area, from the final fields, divided by the stress scale
        (larger of the largest traction and the softest stiffness times h_rms). With `yield_stress`: rms unbalanced
        force on nodes below the surface, divided by the rms force on them, from the final strain. With `law` or
        `yield_stress` or `lower_surface` or `lateral` only.
        """

    @property
    def residual_complementarity(self) -> Array:
        """Without unit [step]: sum(p gap) / (sum(p) h_rms), from the final fields. In some problems only."""

    @property
    def residual_penetration(self) -> Array:
        """Without unit [step]: max(0, -min gap) / h_rms, from the final fields. With `lower_surface`: max(0, -min
        gap) / h_rms, from the final fields; larger of the two faces.
        """

    @property
    def residual_negative_pressure(self) -> Array:
        """Without unit [step]: max(0, -min p) / mean p, from the final fields. In some problems only."""

    @property
    def residual_wall_tension(self) -> Array:
        """Without unit [step]: largest tension that the wall would have to carry. With `law` or `lower_surface` or
        `lateral` only.
        """

    @property
    def residual_load(self) -> Array:
        """Without unit [step]: |mean p - prescribed| / prescribed, from the final fields. With `law` or
        `lower_surface`: |mean p - prescribed| / prescribed, larger of the two faces; under a prescribed approach,
        the difference between the mean pressures on both faces divided by their mean. With `law`: |mean p -
        prescribed|, from the final fields (0 if the approach is prescribed), divided by the stress scale (larger of
        the largest traction and the softest stiffness times h_rms).
        """

    @property
    def residual_friction(self) -> Array:
        """Without unit [step]: largest deviation of the shear from its law, divided by the largest limit. With
        `friction` only.
        """

    @property
    def residual_excess(self) -> Array:
        """Without unit [step]: largest excess of the shear over its limit, divided by the largest limit. With
        `friction` only.
        """

    @property
    def residual_saturation(self) -> Array:
        """Without unit [step]: largest gap / h_rms at points at the hardness. With `lower_surface`: largest gap /
        h_rms at points at the hardness; larger of the two faces. With `hardness` only.
        """

    @property
    def residual_yield(self) -> Array:
        """Without unit [step]: largest excess of the equivalent stress over the yield stress, divided by the initial
        yield stress. With `yield_stress` only.
        """

    @property
    def residual_flow(self) -> Array:
        """Without unit [step]: largest error of a plastic strain increment, divided by the largest equivalent
        strain. With `yield_stress` only.
        """

    @property
    def residual_flow_complementarity(self) -> Array:
        """Without unit [step]: largest product of strain increment and stress below yield, divided by the largest
        strain and yield stress. With `yield_stress` only.
        """

    @property
    def residual_bottom(self) -> Array:
        """Without unit [step]: 1 if the lowest cell yields although its layer continues below it, else 0. With
        `yield_stress` only.
        """

    @property
    def seconds(self) -> Array:
        """Seconds [step]: wall time of a load: solution and, for a contact, stiffness, statistics and flow; excludes
        finer grids.
        """

    @property
    def plastic_fraction(self) -> Array:
        """Without unit [step]: share of points at the hardness, to its accuracy. With `hardness` only."""

    @property
    def plastic_volume(self) -> Array:
        """Length [step]: mean plastic depth so far. With `hardness` only."""

    @property
    def max_plastic_strain(self) -> Array:
        """Without unit [step]: largest equivalent plastic strain below the surface. With `yield_stress` only."""

    @property
    def plastic_strain_integral(self) -> Array:
        """Length [step]: equivalent plastic strain integrated over depth, averaged over the surface. With
        `yield_stress` only.
        """

    @property
    def yielded_volume(self) -> Array:
        """Length [step]: yielded volume per surface area. With `yield_stress` only."""

    @property
    def yield_depth(self) -> Array:
        """Length [step]: bottom depth of the lowest cell that has yielded; 0 if none has. With `yield_stress` only."""

    @property
    def plastic_displacement(self) -> Array:
        """Length [step, 2]: mean normal surface displacement due to plastic strain, negative downwards. With
        `yield_stress` only.
        """

    @property
    def patches(self) -> npt.NDArray[Any]:
        """Count [step]: number of connected patches of points in contact. In some problems only."""

    @property
    def largest_patch_fraction(self) -> Array:
        """Without unit [step]: share of points in the largest patch. In some problems only."""

    @property
    def percolates_x(self) -> npt.NDArray[Any]:
        """Flag [step]: true if a patch winds around the cell along x or, with free boundaries, spans the surface. In
        some problems only.
        """

    @property
    def percolates_y(self) -> npt.NDArray[Any]:
        """Flag [step]: true if a patch winds around the cell along y or, with free boundaries, spans the surface. In
        some problems only.
        """

    @property
    def conductance(self) -> Array:
        """Per length [step]: conductance per area of the points in contact between two conductors, times the sum of
        their resistivities: current density divided by the potential difference without the bulk drop (with free
        boundaries, by the whole difference); no value if all points of a periodic surface touch. In some problems
        only.
        """

    @property
    def contact_conductance(self) -> Array:
        """Stress * length/time/temperature [step]: contact conductance per area: conductance divided by the sum of
        both conductors' resistivities. In some problems only.
        """

    @property
    def gas_conductance(self) -> Array:
        """Stress * length/time/temperature [step]: conductance per area of the gas in the gap: mean of k/(g + M)
        over all points, with gas conductivity k, gap g and temperature-jump length M; points in contact contribute
        nothing; excludes radiation. With `gas` only.
        """

    @property
    def flow_xx(self) -> Array:
        """Without unit [step]: mean flux along x under a mean pressure gradient along x, divided by the flux through
        a uniform gap equal to the mean gap. With `flow="or __flow_threshold"` only.
        """

    @property
    def flow_xy(self) -> Array:
        """Without unit [step]: mean flux along x under a mean pressure gradient along y, divided by the flux through
        a uniform gap equal to the mean gap. With `flow="or __flow_threshold"` only.
        """

    @property
    def flow_yx(self) -> Array:
        """Without unit [step]: mean flux along y under a mean pressure gradient along x, divided by the flux through
        a uniform gap equal to the mean gap. With `flow="or __flow_threshold"` only.
        """

    @property
    def flow_yy(self) -> Array:
        """Without unit [step]: mean flux along y under a mean pressure gradient along y, divided by the flux through
        a uniform gap equal to the mean gap. With `flow="or __flow_threshold"` only.
        """

    @property
    def flow_percolates_x(self) -> npt.NDArray[Any]:
        """Flag [step]: true if the gap is open to flow along x. With `flow="or __flow_threshold"` only."""

    @property
    def flow_percolates_y(self) -> npt.NDArray[Any]:
        """Flag [step]: true if the gap is open to flow along y. With `flow="or __flow_threshold"` only."""

    @property
    def flow_residual(self) -> Array:
        """Without unit [step]: upper minus lower bound of the conductivity, divided by the conductivity; larger of x
        and y. With `flow="or __flow_threshold"` only.
        """

    @property
    def leak(self) -> Array:
        """Length^3/time [step, 2]: fluid volume per time through the gap of the cell, driven by the pressure drop.
        With `viscosity` only.
        """

    @property
    def lower(self) -> Array:
        """Stress [step, 2]: mean pressure over the whole lower surface. With `lower_surface` only."""

    @property
    def mean_pressure_limit(self) -> Array:
        """Stress [step]: estimate of mean_pressure on an infinitely fine grid at the same approach. In some problems
        only.
        """

    @property
    def mean_pressure_limit_error(self) -> Array:
        """Stress [step]: error bound (95 %) of mean_pressure_limit. In some problems only."""

    @property
    def mean_pressure_grid_error(self) -> Array:
        """Stress [step]: grid error of mean_pressure: |mean_pressure - limit| + limit_error. In some problems only."""

    @property
    def mean_shear_limit(self) -> Array:
        """Stress [step, 2]: estimate of mean_shear_x on an infinitely fine grid under the same mean pressure. With
        `friction="or __lateral"` only.
        """

    @property
    def mean_shear_limit_error(self) -> Array:
        """Stress [step, 2]: error bound (95 %) of mean_shear_x_limit. With `friction="or __lateral"` only."""

    @property
    def mean_shear_grid_error(self) -> Array:
        """Stress [step, 2]: grid error of mean_shear_x: |mean_shear_x - limit| + limit_error. With `friction="or
        __lateral"` only.
        """

    @property
    def approach_limit(self) -> Array:
        """Length [step]: estimate of approach on an infinitely fine grid under the same mean pressure."""

    @property
    def approach_limit_error(self) -> Array:
        """Length [step]: error bound (95 %) of approach_limit."""

    @property
    def approach_grid_error(self) -> Array:
        """Length [step]: grid error of approach: |approach - limit| + limit_error."""

    @property
    def area_fraction_limit(self) -> Array:
        """Without unit [step]: estimate of area_fraction on an infinitely fine grid under the same mean pressure."""

    @property
    def area_fraction_limit_error(self) -> Array:
        """Without unit [step]: error bound (95 %) of area_fraction_limit."""

    @property
    def area_fraction_grid_error(self) -> Array:
        """Without unit [step]: grid error of area_fraction: |area_fraction - limit| + limit_error."""

    @property
    def mean_gap_limit(self) -> Array:
        """Length [step]: estimate of mean_gap on an infinitely fine grid under the same mean pressure."""

    @property
    def mean_gap_limit_error(self) -> Array:
        """Length [step]: error bound (95 %) of mean_gap_limit."""

    @property
    def mean_gap_grid_error(self) -> Array:
        """Length [step]: grid error of mean_gap: |mean_gap - limit| + limit_error."""

    @property
    def elastic_energy_limit(self) -> Array:
        """Stress * length [step]: estimate of elastic_energy on an infinitely fine grid under the same mean
        pressure.
        """

    @property
    def elastic_energy_limit_error(self) -> Array:
        """Stress * length [step]: error bound (95 %) of elastic_energy_limit."""

    @property
    def elastic_energy_grid_error(self) -> Array:
        """Stress * length [step]: grid error of elastic_energy: |elastic_energy - limit| + limit_error."""

    @property
    def interface_energy_limit(self) -> Array:
        """Stress * length [step]: estimate of interface_energy on an infinitely fine grid under the same mean
        pressure. With `law` or `lower_surface` or `lateral` only.
        """

    @property
    def interface_energy_limit_error(self) -> Array:
        """Stress * length [step]: error bound (95 %) of interface_energy_limit. With `law` or `lower_surface` or
        `lateral` only.
        """

    @property
    def interface_energy_grid_error(self) -> Array:
        """Stress * length [step]: grid error of interface_energy: |interface_energy - limit| + limit_error. With
        `law` or `lower_surface` or `lateral` only.
        """

    @property
    def dissipated_limit(self) -> Array:
        """Stress * length [step]: estimate of dissipated on an infinitely fine grid under the same mean pressure."""

    @property
    def dissipated_limit_error(self) -> Array:
        """Stress * length [step]: error bound (95 %) of dissipated_limit."""

    @property
    def dissipated_grid_error(self) -> Array:
        """Stress * length [step]: grid error of dissipated: |dissipated - limit| + limit_error."""

    @property
    def stiffness_limit(self) -> Array:
        """Stress/length [step]: estimate of stiffness on an infinitely fine grid under the same mean pressure."""

    @property
    def stiffness_limit_error(self) -> Array:
        """Stress/length [step]: error bound (95 %) of stiffness_limit."""

    @property
    def stiffness_grid_error(self) -> Array:
        """Stress/length [step]: grid error of stiffness: |stiffness - limit| + limit_error."""

    @property
    def patches_limit(self) -> Array:
        """Without unit [step]: estimate of patches on an infinitely fine grid under the same mean pressure. In some
        problems only.
        """

    @property
    def patches_limit_error(self) -> Array:
        """Without unit [step]: error bound (95 %) of patches_limit. In some problems only."""

    @property
    def patches_grid_error(self) -> Array:
        """Without unit [step]: grid error of patches: |patches - limit| + limit_error. In some problems only."""

    @property
    def largest_patch_fraction_limit(self) -> Array:
        """Without unit [step]: estimate of largest_patch_fraction on an infinitely fine grid under the same mean
        pressure. In some problems only.
        """

    @property
    def largest_patch_fraction_limit_error(self) -> Array:
        """Without unit [step]: error bound (95 %) of largest_patch_fraction_limit. In some problems only."""

    @property
    def largest_patch_fraction_grid_error(self) -> Array:
        """Without unit [step]: grid error of largest_patch_fraction: |largest_patch_fraction - limit| + limit_error.
        In some problems only.
        """

    @property
    def conductance_limit(self) -> Array:
        """Per length [step]: estimate of conductance on an infinitely fine grid under the same mean pressure. In
        some problems only.
        """

    @property
    def conductance_limit_error(self) -> Array:
        """Per length [step]: error bound (95 %) of conductance_limit. In some problems only."""

    @property
    def conductance_grid_error(self) -> Array:
        """Per length [step]: grid error of conductance: |conductance - limit| + limit_error. In some problems only."""

    @property
    def contact_conductance_limit(self) -> Array:
        """Stress * length/time/temperature [step]: estimate of contact_conductance on an infinitely fine grid under
        the same mean pressure. In some problems only.
        """

    @property
    def contact_conductance_limit_error(self) -> Array:
        """Stress * length/time/temperature [step]: error bound (95 %) of contact_conductance_limit. In some problems
        only.
        """

    @property
    def contact_conductance_grid_error(self) -> Array:
        """Stress * length/time/temperature [step]: grid error of contact_conductance: |contact_conductance - limit|
        + limit_error. In some problems only.
        """

    @property
    def gas_conductance_limit(self) -> Array:
        """Stress * length/time/temperature [step]: estimate of gas_conductance on an infinitely fine grid under the
        same mean pressure. With `gas` only.
        """

    @property
    def gas_conductance_limit_error(self) -> Array:
        """Stress * length/time/temperature [step]: error bound (95 %) of gas_conductance_limit. With `gas` only."""

    @property
    def gas_conductance_grid_error(self) -> Array:
        """Stress * length/time/temperature [step]: grid error of gas_conductance: |gas_conductance - limit| +
        limit_error. With `gas` only.
        """

    @property
    def flow_xx_limit(self) -> Array:
        """Without unit [step]: estimate of flow_xx on an infinitely fine grid under the same mean pressure. With
        `flow="or __flow_threshold"` only.
        """

    @property
    def flow_xx_limit_error(self) -> Array:
        """Without unit [step]: error bound (95 %) of flow_xx_limit. With `flow="or __flow_threshold"` only."""

    @property
    def flow_xx_grid_error(self) -> Array:
        """Without unit [step]: grid error of flow_xx: |flow_xx - limit| + limit_error. With `flow="or
        __flow_threshold"` only.
        """

    @property
    def flow_yy_limit(self) -> Array:
        """Without unit [step]: estimate of flow_yy on an infinitely fine grid under the same mean pressure. With
        `flow="or __flow_threshold"` only.
        """

    @property
    def flow_yy_limit_error(self) -> Array:
        """Without unit [step]: error bound (95 %) of flow_yy_limit. With `flow="or __flow_threshold"` only."""

    @property
    def flow_yy_grid_error(self) -> Array:
        """Without unit [step]: grid error of flow_yy: |flow_yy - limit| + limit_error. With `flow="or
        __flow_threshold"` only.
        """

    @property
    def leak_limit(self) -> Array:
        """Length^3/time [step, 2]: estimate of leak_x on an infinitely fine grid under the same mean pressure. With
        `viscosity` only.
        """

    @property
    def leak_limit_error(self) -> Array:
        """Length^3/time [step, 2]: error bound (95 %) of leak_x_limit. With `viscosity` only."""

    @property
    def leak_grid_error(self) -> Array:
        """Length^3/time [step, 2]: grid error of leak_x: |leak_x - limit| + limit_error. With `viscosity` only."""

class StepFields(Record):
    """The fields of a path."""

    @property
    def pressure(self) -> Array:
        """Stress [waypoint, x, y]: pressure on the elastic surface, compression positive; attraction is negative.
        Read-only.
        """

    @property
    def displacement_z(self) -> Array:
        """Length [waypoint, x, y]: normal displacement of the elastic surface, negative downwards. Read-only."""

    @property
    def gap(self) -> Array:
        """Length [waypoint, x, y]: distance between the surfaces. Read-only."""

    @property
    def plastic_depth(self) -> Array:
        """Length [waypoint, x, y]: depth by which the surfaces have been pressed into each other. With `hardness`
        only. Read-only.
        """

    @property
    def plastic_displacement_z(self) -> Array:
        """Length [waypoint, x, y]: normal displacement due to plastic strain below the surface; once unloaded, the
        residual topography. With `yield_stress` only. Read-only.
        """

    @property
    def wear_depth(self) -> Array:
        """Length [waypoint, x, y]: depth lost by both surfaces so far. With `lower_surface`: depth lost by the upper
        face and surface so far. With `wear` only. Read-only.
        """

    @property
    def shear_x(self) -> Array:
        """Stress [waypoint, x, y]: shear traction on the elastic surface along x. With `friction="or __lateral"`
        only. Read-only.
        """

    @property
    def shear_y(self) -> Array:
        """Stress [waypoint, x, y]: shear traction on the elastic surface along y. In some problems only. Read-only."""

    @property
    def lower_pressure(self) -> Array:
        """Stress [waypoint, x, y]: pressure on the lower face of the slab. With `law`: pressure on the lower face of
        the slab; attraction is negative. With `lower_surface` only. Read-only.
        """

    @property
    def lower_displacement_z(self) -> Array:
        """Length [waypoint, x, y]: normal displacement of the lower face of the slab, positive upwards. With
        `lower_surface` only. Read-only.
        """

    @property
    def lower_gap(self) -> Array:
        """Length [waypoint, x, y]: distance between the lower face of the slab and the lower surface. With
        `lower_surface` only. Read-only.
        """

    @property
    def lower_plastic_depth(self) -> Array:
        """Length [waypoint, x, y]: depth by which the lower face and surface have been pressed into each other. With
        `hardness` and `lower_surface` only. Read-only.
        """

    @property
    def lower_wear_depth(self) -> Array:
        """Length [waypoint, x, y]: depth lost by the lower face and surface so far. With `lower_surface` and `wear`
        only. Read-only.
        """

    @property
    def repulsion(self) -> Array:
        """Stress [waypoint, x, y]: repulsive pressure, without attraction; positive at the points in contact. In
        some problems only. Read-only.
        """

class Patches(Record):
    """The patches of points in contact, as `gfmd contact --statistics` measures them."""

    @property
    def area(self) -> Array:
        """Length^2 [patch]: area: number of points times the pixel area."""

    @property
    def perimeter(self) -> Array:
        """Length [patch]: length of the edges between points in contact and points out of contact; excludes the rim
        of a surface with free boundaries.
        """

    @property
    def force(self) -> Array:
        """Stress * length^2 [patch]: force on the patch."""

    @property
    def x(self) -> Array:
        """Length [patch]: x of the centre of area; NaN if the patch winds around the cell along x."""

    @property
    def y(self) -> Array:
        """Length [patch]: y of the centre of area; NaN if the patch winds around the cell along y."""

class States(Record):
    """The numbers of states that slide steadily."""

    @property
    def velocity(self) -> Array:
        """Length/time [state]: velocity of the rigid surface relative to the body."""

    @property
    def mean_pressure(self) -> Array:
        """Stress [state]: mean pressure over the whole surface."""

    @property
    def p_star(self) -> Array:
        """Without unit [state]: reduced pressure p/(E* g)."""

    @property
    def approach(self) -> Array:
        """Length [state]: rigid approach beyond first touch."""

    @property
    def area_fraction(self) -> Array:
        """Without unit [state]: contact area fraction: share of points with pressure."""

    @property
    def mean_gap(self) -> Array:
        """Length [state]: mean distance between the surfaces."""

    @property
    def max_pressure(self) -> Array:
        """Stress [state]: largest pressure."""

    @property
    def plastic_fraction(self) -> Array:
        """Without unit [state]: share of points at the hardness. With `hardness` only."""

    @property
    def plastic_volume(self) -> Array:
        """Length [state]: mean plastic depth over the whole surface. With `hardness` only."""

    @property
    def friction(self) -> Array:
        """Without unit [state]: friction coefficient, lateral force divided by load: friction_interface +
        friction_hysteresis.
        """

    @property
    def friction_interface(self) -> Array:
        """Without unit [state]: friction coefficient of the interface: mean shear divided by mean pressure."""

    @property
    def friction_hysteresis(self) -> Array:
        """Without unit [state]: friction coefficient from the pressure on the slopes of the deformed body: without
        interface friction, the power lost in the body divided by velocity and mean pressure.
        """

    @property
    def friction_slope(self) -> Array:
        """Without unit [state]: friction coefficient from the pressure on the slopes of the rough surface."""

    @property
    def dissipated_power(self) -> Array:
        """Stress * length/time [state]: power lost in the body, per area."""

    @property
    def persson_friction(self) -> Array:
        """Without unit [state]: friction coefficient from Persson's theory."""

    @property
    def persson_area_fraction(self) -> Array:
        """Without unit [state]: contact area fraction from Persson's theory."""

    @property
    def heat_mean_flux(self) -> Array:
        """Stress * length/time [state]: mean frictional heat, per area and time. With `heat` only."""

    @property
    def heat_fraction(self) -> Array:
        """Without unit [state]: share of the heat that flows into the body. With `heat` only."""

    @property
    def heat_max_rise(self) -> Array:
        """Temperature [state]: largest temperature in contact, relative to the surface mean. With `heat` only."""

    @property
    def heat_mean_rise(self) -> Array:
        """Temperature [state]: mean temperature in contact, relative to the surface mean. With `heat` only."""

    @property
    def heat_residual(self) -> Array:
        """Without unit [state]: largest temperature difference between both bodies, divided by the largest rise.
        With `heat` only.
        """

    @property
    def iterations(self) -> npt.NDArray[Any]:
        """Count [state]: solver iterations."""

    @property
    def transform_pairs(self) -> Array:
        """Without unit [state]: transform pairs of the solver."""

    @property
    def converged(self) -> npt.NDArray[Any]:
        """Flag [state]: true if the residual is at most the tolerance."""

    @property
    def area_fraction_limit(self) -> Array:
        """Without unit [state]: estimate of area_fraction on an infinitely fine grid under the same load. With
        `grid_error="refine"` only.
        """

    @property
    def area_fraction_limit_error(self) -> Array:
        """Without unit [state]: error bound (95 %) of area_fraction_limit. With `grid_error="refine"` only."""

    @property
    def area_fraction_grid_error(self) -> Array:
        """Without unit [state]: grid error of area_fraction: |area_fraction - limit| + limit_error. With
        `grid_error="refine"` only.
        """

    @property
    def friction_limit(self) -> Array:
        """Without unit [state]: estimate of friction on an infinitely fine grid under the same load. With
        `grid_error="refine"` only.
        """

    @property
    def friction_limit_error(self) -> Array:
        """Without unit [state]: error bound (95 %) of friction_limit. With `grid_error="refine"` only."""

    @property
    def friction_grid_error(self) -> Array:
        """Without unit [state]: grid error of friction: |friction - limit| + limit_error. With `grid_error="refine"`
        only.
        """

    @property
    def friction_hysteresis_limit(self) -> Array:
        """Without unit [state]: estimate of friction_hysteresis on an infinitely fine grid under the same load. With
        `grid_error="refine"` only.
        """

    @property
    def friction_hysteresis_limit_error(self) -> Array:
        """Without unit [state]: error bound (95 %) of friction_hysteresis_limit. With `grid_error="refine"` only."""

    @property
    def friction_hysteresis_grid_error(self) -> Array:
        """Without unit [state]: grid error of friction_hysteresis: |friction_hysteresis - limit| + limit_error. With
        `grid_error="refine"` only.
        """

    @property
    def seconds(self) -> Array:
        """Seconds [state]: wall time."""

class StateFields(Record):
    """The fields of states that slide steadily."""

    @property
    def pressure(self) -> Array:
        """Stress [state, x, y]: pressure on the surface of the body. Read-only."""

    @property
    def displacement_z(self) -> Array:
        """Length [state, x, y]: normal displacement of the body surface, negative downwards. Read-only."""

    @property
    def gap(self) -> Array:
        """Length [state, x, y]: distance between the surfaces. Read-only."""

    @property
    def plastic_depth(self) -> Array:
        """Length [state, x, y]: depth by which the surfaces are pressed into each other beyond touching. With
        `hardness` only. Read-only.
        """

    @property
    def temperature(self) -> Array:
        """Temperature [state, x, y]: surface temperature of the body, relative to its mean. With `heat` only.
        Read-only.
        """

    @property
    def heat_flux(self) -> Array:
        """Stress * length/time [state, x, y]: heat flux into the body. With `heat` of both bodies only. Read-only."""

class PunchNumbers(Record):
    """The numbers of a punch."""

    @property
    def punch_width(self) -> float:
        """Length: width of the punch. Without `mask` only."""

    @property
    def effective_width(self) -> float:
        """Length: effective width of its N points, N - 1/3 grid spacings. Without `mask` only."""

    @property
    def depth(self) -> float:
        """Length: indentation depth of the punch."""

    @property
    def contact_nodes(self) -> int:
        """Count: points under the punch."""

    @property
    def mean_pressure(self) -> float:
        """Stress: mean pressure over the whole surface."""

    @property
    def mean_traction(self) -> list[float]:
        """Stress by component: mean traction over the whole surface."""

    @property
    def max_pressure(self) -> float:
        """Stress: largest pressure, at the edge of the punch."""

    @property
    def elastic_energy(self) -> float:
        """Stress * length: elastic energy per area of the surface."""

    @property
    def residual(self) -> float:
        """Without unit: largest error of the prescribed displacement, divided by the depth."""

    @property
    def converged(self) -> bool:
        """Flag: true if the residual is within the tolerance."""

    @property
    def iterations(self) -> int:
        """Count: iterations, or time steps."""

    @property
    def transform_pairs(self) -> int:
        """Count: transform pairs of one component."""

    @property
    def seconds(self) -> float:
        """Seconds: wall time."""

class SurfaceNumbers(Record):
    """The statistics of a surface."""

    @property
    def mean(self) -> float:
        """Length: mean height."""

    @property
    def rms_height(self) -> float:
        """Length: root-mean-square height about the mean: Sq of ISO 25178."""

    @property
    def lowest(self) -> float:
        """Length: lowest height."""

    @property
    def highest(self) -> float:
        """Length: highest height."""

    @property
    def peak_to_valley(self) -> float:
        """Length: highest minus lowest height: Sz of ISO 25178."""

    @property
    def sa(self) -> float:
        """Length: Sa of ISO 25178: mean distance from the mean height."""

    @property
    def sp(self) -> float:
        """Length: Sp of ISO 25178: highest height above the mean."""

    @property
    def sv(self) -> float:
        """Length: Sv of ISO 25178: depth of the lowest height below the mean."""

    @property
    def ssk(self) -> float:
        """Without unit: Ssk of ISO 25178: skewness."""

    @property
    def sku(self) -> float:
        """Without unit: Sku of ISO 25178: kurtosis, 3 of a Gaussian surface."""

    @property
    def sdr(self) -> float:
        """Without unit: Sdr of ISO 25178: developed area divided by projected area, minus 1."""

    @property
    def sk(self) -> float:
        """Length: Sk of ISO 25178: core height of the bearing curve."""

    @property
    def spk(self) -> float:
        """Length: Spk of ISO 25178: reduced peak height above the core."""

    @property
    def svk(self) -> float:
        """Length: Svk of ISO 25178: reduced valley depth below the core."""

    @property
    def smr1(self) -> float:
        """Without unit: Smr1 of ISO 25178: material ratio between peaks and core."""

    @property
    def smr2(self) -> float:
        """Without unit: Smr2 of ISO 25178: material ratio between core and valleys."""

    @property
    def spkx(self) -> float:
        """Length: Spkx of ISO 25178: highest peak above the core."""

    @property
    def svkx(self) -> float:
        """Length: Svkx of ISO 25178: deepest valley below the core."""

    @property
    def vmp(self) -> float:
        """Length: Vmp of ISO 25178: peak material volume per area, above the material ratio 10 %."""

    @property
    def vmc(self) -> float:
        """Length: Vmc of ISO 25178: core material volume per area, between 10 and 80 %."""

    @property
    def vvc(self) -> float:
        """Length: Vvc of ISO 25178: core void volume per area, between 10 and 80 %."""

    @property
    def vvv(self) -> float:
        """Length: Vvv of ISO 25178: valley void volume per area, below 80 %."""

    @property
    def sxp(self) -> float:
        """Length: Sxp of ISO 25178: height at the material ratio 2.5 % minus the height at 50 %."""

    @property
    def sdc(self) -> float:
        """Length: Sdc of ISO 25178: height at the material ratio 10 % minus the height at 80 %."""

    @property
    def rms_gradient(self) -> float:
        """Without unit: rms of the full gradient, from the spectrum."""

    @property
    def rms_gradient_central(self) -> float:
        """Without unit: rms gradient from central differences."""

    @property
    def rms_gradient_forward(self) -> float:
        """Without unit: rms gradient from forward differences."""

    @property
    def rms_gradient_inside(self) -> float:
        """Without unit: rms gradient from forward differences, excluding the periodic seam."""

    @property
    def rms_curvature(self) -> float:
        """Per length: rms of the mean curvature (h'' of a profile)."""

    @property
    def rms_curvature_inside(self) -> float:
        """Per length: rms of the mean curvature from second differences, excluding the periodic seam."""

    @property
    def rms_laplacian(self) -> float:
        """Per length: rms of the Laplacian."""

    @property
    def m0(self) -> float:
        """Length^2: zeroth profile moment."""

    @property
    def m2(self) -> float:
        """Without unit: second profile moment."""

    @property
    def m4(self) -> float:
        """Per length^2: fourth profile moment."""

    @property
    def m4_inside(self) -> float:
        """Per length^2: fourth profile moment from second differences, excluding the periodic seam."""

    @property
    def nayak(self) -> float:
        """Without unit: Nayak's parameter m0 m4/m2^2."""

    @property
    def nayak_inside(self) -> float:
        """Without unit: Nayak's parameter from differences, excluding the periodic seam."""

    @property
    def hurst(self) -> float:
        """Without unit: fitted Hurst exponent."""

    @property
    def hurst_error(self) -> float:
        """Without unit: standard error of the fitted Hurst exponent."""

    @property
    def hurst_range(self) -> list[float]:
        """Length: longest and shortest wavelength of the fit of `hurst`."""

    @property
    def longest_wavelength(self) -> float:
        """Length: longest wavelength with power."""

    @property
    def shortest_wavelength(self) -> float:
        """Length: shortest wavelength with power."""

    @property
    def seam(self) -> list[float]:
        """Without unit along x and y: rms step across the periodic seam divided by the rms step inside."""

    @property
    def sal(self) -> float:
        """Length: Sal of ISO 25178: shortest distance at which the autocorrelation is 0.2. With `features` only."""

    @property
    def str(self) -> float:
        """Without unit: Str of ISO 25178: shortest divided by longest distance at which the autocorrelation is 0.2.
        Of a surface with `features` only.
        """

    @property
    def ssw(self) -> float:
        """Length: Ssw of ISO 25178: wavelength of the wave with the largest amplitude. With `features` only."""

    @property
    def std(self) -> float:
        """Degree: Std of ISO 25178: direction of the waves with the most power, from the x axis. Of a surface with
        `features` only.
        """

    @property
    def lay(self) -> float:
        """Degree: direction of the lay from the x axis, normal to Std. Of a surface with `features` only."""

    @property
    def steepest(self) -> float:
        """Degree: direction of the largest mean square slope, from the x axis. Of a surface with `features` only."""

    @property
    def hills(self) -> int:
        """Count: number of hills after Wolf pruning. Of a surface with `features` only."""

    @property
    def dales(self) -> int:
        """Count: number of dales after Wolf pruning. Of a surface with `features` only."""

    @property
    def spd(self) -> float:
        """Per length^2: Spd of ISO 25178: peaks per area. Of a surface with `features` only."""

    @property
    def svd(self) -> float:
        """Per length^2: Svd of ISO 25178: pits per area. Of a surface with `features` only."""

    @property
    def spc(self) -> float:
        """Per length: Spc of ISO 25178: mean curvature of the peaks. Of a surface with `features` only."""

    @property
    def svc(self) -> float:
        """Per length: Svc of ISO 25178: mean curvature of the pits. Of a surface with `features` only."""

    @property
    def s5p(self) -> float:
        """Length: S5p of ISO 25178: mean height of the five highest peaks above the mean. Of a surface with
        `features` only.
        """

    @property
    def s5v(self) -> float:
        """Length: S5v of ISO 25178: mean depth of the five deepest pits below the mean. Of a surface with `features`
        only.
        """

    @property
    def s10z(self) -> float:
        """Length: S10z of ISO 25178: S5p plus S5v. Of a surface with `features` only."""

    @property
    def mean_hill_area(self) -> float:
        """Length^2: mean hill area. Of a surface with `features` only."""

    @property
    def mean_dale_area(self) -> float:
        """Length^2: mean dale area. Of a surface with `features` only."""

    @property
    def sections(self) -> int:
        """Count: number of whole sections of the profile. Of a profile only."""

    @property
    def ra(self) -> float:
        """Length: Ra of ISO 21920: mean distance from the mean line. Of a profile only."""

    @property
    def rq(self) -> float:
        """Length: Rq of ISO 21920: root-mean-square distance from the mean line. Of a profile only."""

    @property
    def rsk(self) -> float:
        """Without unit: Rsk of ISO 21920: skewness. Of a profile only."""

    @property
    def rku(self) -> float:
        """Without unit: Rku of ISO 21920: kurtosis. Of a profile only."""

    @property
    def rt(self) -> float:
        """Length: Rt of ISO 21920: highest minus lowest height. Of a profile only."""

    @property
    def rp(self) -> float:
        """Length: Rp of ISO 21920: highest height of a section, mean over the sections. Of a profile only."""

    @property
    def rv(self) -> float:
        """Length: Rv of ISO 21920: depth of the lowest height of a section, mean over the sections. Of a profile
        only.
        """

    @property
    def rz(self) -> float:
        """Length: Rz of ISO 21920: highest minus lowest height of a section, mean over the sections. Of a profile
        only.
        """

    @property
    def rzx(self) -> float:
        """Length: Rzx of ISO 21920: largest difference between highest and lowest height of a section. Of a profile
        only.
        """

    @property
    def rdq(self) -> float:
        """Without unit: Rdq of ISO 21920: root-mean-square slope from forward differences. Of a profile only."""

    @property
    def rsm(self) -> float:
        """Length: Rsm of ISO 21920: mean width of the profile elements. Of a profile only."""

    @property
    def rk(self) -> float:
        """Length: Rk of ISO 21920: core height of the bearing curve. Of a profile only."""

    @property
    def rpk(self) -> float:
        """Length: Rpk of ISO 21920: reduced peak height above the core. Of a profile only."""

    @property
    def rvk(self) -> float:
        """Length: Rvk of ISO 21920: reduced valley depth below the core. Of a profile only."""

    @property
    def rmr1(self) -> float:
        """Without unit: Rmr1 of ISO 21920: material ratio between peaks and core. Of a profile only."""

    @property
    def rmr2(self) -> float:
        """Without unit: Rmr2 of ISO 21920: material ratio between core and valleys. Of a profile only."""

MEASURED: dict[str, str]
