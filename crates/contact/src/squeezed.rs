//! Slab between two rough rigid surfaces, with both contacts solved together (theory.md, section 4.3).

mod dual;

use std::sync::Arc;

use gfmd_field::{Grid, Share};
use gfmd_green::{Body, Plate};
use gfmd_measure::{Scales, Summary};
use gfmd_relax::{Budget, Ceiling, Upper, Variables as _, Visit, Watch, worst};
use gfmd_response::{PlateResponse, PlateTransforms};
use gfmd_vector::{add, with_contiguous};
use ndarray::{Array2, ArrayRef2, ArrayView2, CowArray, Ix2};

use crate::refine::{Refined, coarsest, refine};
use crate::solution::{Conditions, between, field};
use crate::{
    Drive, Effort, Equilibrium, Fields, Hardness, Heights, Load, Refusal, Residual, Resumable, RigidSurface, Solution,
    SolveError, Solver, Units, judge,
};

/// Slab, or stack of layers, between two rigid surfaces, without friction or adhesion: hard walls, possibly with a
/// [hardness](Self::with_hardness). Nothing else holds the slab: the mean pressures on its two faces are equal. Clones
/// share the data.
#[derive(Clone, Debug)]
pub struct SqueezedContact {
    /// Plate, in `units`.
    plate: Plate,
    /// Response of the plate, in `units`.
    response: Arc<PlateResponse>,
    /// Surfaces, in `units`.
    scaled: [Arc<RigidSurface>; 2],
    surfaces: [Arc<RigidSurface>; 2],
    /// Largest pressure at each point of a face, the same on both, in `units`.
    hardness: Option<Upper>,
    contact_modulus: f64,
    units: Units,
}

/// Equilibrated [`SqueezedContact`]. Displacements are measured from the level at which the mean displacements of the
/// two faces are opposite.
#[derive(Clone, Debug, PartialEq)]
pub struct SqueezedSolution {
    /// Contact with the upper surface, with its part of the approach.
    pub upper: Solution,
    /// Contact with the lower surface, seen from below: its displacement is negative into the slab.
    pub lower: Solution,
    /// Approach of the two rigid surfaces to each other beyond the distance at which both touch the undeformed slab.
    pub approach: f64,
    /// Effort of the solve, including the transforms for the final fields.
    pub effort: Effort,
}

impl SqueezedContact {
    /// Makes the contact of the layers of `body`, without its base, with two rigid profiles on `grid`: `upper` above
    /// the slab and `lower` below it, each in length with peaks towards the slab. Points with the same indices lie
    /// above each other. A constant in the heights has no effect; one of the surfaces may be flat.
    ///
    /// # Errors
    /// A body that is no slab and no stack of layers; heights that differ in shape from the grid, are not finite, or
    /// are both flat; E* h_rms / L too large or small for a number.
    pub fn new<'a>(
        body: &Body,
        grid: &Grid,
        upper: impl Into<Heights<'a>>,
        lower: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        Self::distributed(&grid.whole(), body, grid, upper, lower)
    }

    /// Makes the contact as [`new`](Self::new), solved by the processes of a [`share`](crate::Contact::share). Each
    /// process gives and gets only its rows of all fields, and all make the same calls. Fields and numbers have the
    /// bits of a single process.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new), on all processes.
    pub fn distributed<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        upper: impl Into<Heights<'a>>,
        lower: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        Self::of_plate(share, Plate::of(body)?, body, grid, [upper.into(), lower.into()])
    }

    /// Makes the contact as [`new`](Self::new) of a slab whose faces have no lateral displacement: the two surfaces
    /// hold all their points sideways.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new).
    pub fn held_sideways<'a>(
        body: &Body,
        grid: &Grid,
        upper: impl Into<Heights<'a>>,
        lower: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        Self::held_sideways_over(&grid.whole(), body, grid, upper, lower)
    }

    /// Makes the contact as [`held_sideways`](Self::held_sideways), solved by several processes as
    /// [`distributed`](Self::distributed).
    ///
    /// # Errors
    /// The errors of [`new`](Self::new), on all processes.
    pub fn held_sideways_over<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        upper: impl Into<Heights<'a>>,
        lower: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        Self::of_plate(share, Plate::held_sideways(body)?, body, grid, [upper.into(), lower.into()])
    }

    fn of_plate(
        share: &Share,
        plate: Plate,
        body: &Body,
        grid: &Grid,
        [upper, lower]: [Heights; 2],
    ) -> Result<Self, Refusal> {
        let surface = |heights: Heights| RigidSurface::distributed(share, grid, heights).map(Arc::new);
        let surfaces = [surface(upper)?, surface(lower)?];
        let rougher = rougher(&surfaces);
        if rougher.rms_height() == 0.0 {
            return Err(Refusal::Flat);
        }
        let units = Units::of(body, rougher)?;
        let plate = if units.are_one() { plate } else { plate.in_units(units.modulus(), units.lateral()) };
        let response = PlateResponse::distributed(units.grid(grid), &plate, share).into();
        let scaled = surfaces.each_ref().map(|surface| units.surface(surface));
        Ok(Self { plate, response, scaled, surfaces, hardness: None, contact_modulus: body.contact_modulus(), units })
    }

    /// Sets the `hardness`, the largest pressure that both contacts can carry, in stress: a number, or a field `[x, y]`
    /// for both faces, since points with the same indices lie above each other.
    ///
    /// # Errors
    /// A hardness that is not positive and finite, or differs in shape from the heights.
    pub fn with_hardness(self, hardness: impl Into<Hardness>) -> Result<Self, Refusal> {
        let hardness = Some(hardness.into().in_units(&self.surfaces[0], &self.units)?);
        Ok(Self { hardness, ..self })
    }

    /// Returns the hardness, in stress.
    pub fn hardness(&self) -> Option<Hardness> {
        let hardness = self.hardness.as_ref()?.times(self.units.stress());
        Some(match hardness {
            Upper::All(hardness) => Hardness::Uniform(hardness),
            Upper::Each(values) => Hardness::Field(field(&self.surfaces[0], values.to_vec())),
        })
    }

    /// Returns the rigid surfaces: the upper, then the lower.
    pub fn surfaces(&self) -> [&RigidSurface; 2] {
        self.surfaces.each_ref().map(|surface| &**surface)
    }

    /// Returns the response of the plate, in the [units](Self::units) of the solve.
    pub fn response(&self) -> &Arc<PlateResponse> {
        &self.response
    }

    /// Returns the rigid surfaces in the units of the solve.
    pub fn surfaces_in_units(&self) -> [&RigidSurface; 2] {
        self.scaled.each_ref().map(|surface| &**surface)
    }

    /// Returns the units of the solve.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// Returns the smallest and largest stiffness of the waves of the faces, in stress/length.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.response.stiffness_range().map(|stiffness| stiffness * self.units.stiffness())
    }

    /// Computes the state of the pressures on the upper and the lower face under `load` with its residuals, from fresh
    /// transforms.
    ///
    /// # Errors
    /// A pressure that differs in shape from the grid.
    pub fn certify(&self, pressures: [&ArrayRef2<f64>; 2], load: Load) -> Result<SqueezedSolution, Refusal> {
        let stress = self.units.stress();
        let mut both = Vec::new();
        for pressure in pressures {
            let (found, expected) = (pressure.dim().into(), self.surfaces[0].shape());
            if self.share().any(found != expected) {
                return Err(Refusal::Shape { found, expected });
            }
            both.extend(pressure.iter().map(|p| p / stress));
        }
        Ok(self.given_units(self.certified(both, self.units.drive(load.into()).load)))
    }

    /// Computes the state as [`certify`](Self::certify), for pressures on both faces, all in `units`.
    fn certified(&self, mut pressure: Vec<f64>, load: Load) -> SqueezedSolution {
        let (share, points, hardness) = (self.share(), self.points(), self.hardness.as_ref());
        let all = share.total() as f64;
        let mut transforms = PlateTransforms::of(&self.response);
        let mut displacement = vec![0.0; pressure.len()];
        transforms.compliance(0.0, &pressure, &mut displacement);
        displacement.iter_mut().for_each(|u| *u = -*u);
        let [upper, lower] = [&pressure[..points], &pressure[points..]].map(|face| share.total_of(face));
        let sinking = self.response.uniform_compliance() * 0.5 * (upper + lower) / all;
        let loads = match load {
            Load::MeanPressure(_) => [load; 2],
            Load::Approach(approach) => {
                // The slab lies where the mean gaps over the two contacts are equal.
                let ceiling = hardness.map_or(Ceiling::All(f64::INFINITY), Upper::ceiling);
                let room = |face: usize| {
                    let range = face * points..(face + 1) * points;
                    let (clearance, pressure) = (self.scaled[face].clearance(), &pressure[range.clone()]);
                    let displacement = &displacement[range];
                    let touches = |i: &usize| pressure[*i] > 0.0 && pressure[*i] < ceiling.at(*i);
                    let of_range = |range: std::ops::Range<usize>| {
                        range
                            .filter(touches)
                            .fold([0.0; 2], |sums, i| add(sums, [clearance.at(i) - displacement[i], 1.0]))
                    };
                    let [sum, count] = share.reduce(&of_range, &add);
                    let mean = if count > 0.0 || hardness.is_none() {
                        sum / count
                    } else {
                        between(self.scaled[face].share(), pressure, ceiling, |i| clearance.at(i) - displacement[i])
                    };
                    mean + sinking
                };
                let tilt = 0.5 * (room(0) - room(1));
                [0.5 * approach + tilt, 0.5 * approach - tilt].map(Load::Approach)
            }
        };
        let length_scale = self.length_scale(load);
        // A face on a flat surface need not move at all.
        let extent = displacement.chunks_exact(points).map(|face| extent_of(share, face)).fold(0.0, f64::max);
        let mut face = |index: usize| {
            let pressure = pressure.split_off(index * points);
            let displacement = displacement.split_off(index * points);
            let conditions = Conditions { sinking, load: loads[index], length_scale, extent, hardness };
            Solution::of(&self.scaled[index], self.response.contact_modulus(), pressure, displacement, conditions)
        };
        let (mut second, mut first) = (face(1), face(0));
        if let Load::Approach(_) = load {
            // Equilibrium of the slab takes the place of the prescribed pressure.
            let unequal = (upper - lower).abs() / (0.5 * (upper + lower));
            (first.residual.load, second.residual.load) = (unequal, unequal);
        }
        let approach = if let Load::Approach(approach) = load { approach } else { first.approach + second.approach };
        let effort = Effort { iterations: 0, transform_pairs: transforms.pairs() };
        SqueezedSolution { upper: first, lower: second, approach, effort }
    }

    fn given_units(&self, state: SqueezedSolution) -> SqueezedSolution {
        let Self { units, surfaces: [above, below], contact_modulus, .. } = self;
        let SqueezedSolution { upper, lower, approach, effort } = state;
        SqueezedSolution {
            upper: upper.out_of(units, above, *contact_modulus),
            lower: lower.out_of(units, below, *contact_modulus),
            approach: approach * units.length(),
            effort,
        }
    }

    /// Returns the rows of this process on each face.
    fn share(&self) -> &Share {
        self.response.share()
    }

    /// Returns the number of points of this process on each face.
    fn points(&self) -> usize {
        self.share().own().len()
    }

    /// Returns the length scale of the residuals before the displacement is known, in `units`: the root of the sum of
    /// the squares of the two rms heights, unless the approach is very small.
    fn length_scale(&self, load: Load) -> f64 {
        let [upper, lower] = self.scaled.each_ref().map(|surface| surface.rms_height());
        RigidSurface::scale_of(upper.hypot(lower), load)
    }
}

/// Returns the largest minus the smallest value of a field.
fn extent_of(share: &Share, field: &[f64]) -> f64 {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let wider = |[lowest, highest]: [f64; 2], [low, high]: [f64; 2]| [lowest.min(low), highest.max(high)];
    let own = field.iter().fold(none, |ends, value| wider(ends, [*value; 2]));
    let [lowest, highest] = share.each(own).into_iter().fold(none, wider);
    highest - lowest
}

fn rougher(surfaces: &[Arc<RigidSurface>; 2]) -> &Arc<RigidSurface> {
    let [upper, lower] = surfaces;
    if lower.rms_height() > upper.rms_height() { lower } else { upper }
}

/// Solvers of a [`SqueezedContact`].
const SOLVERS: [Solver; 2] = [Solver::Auto, Solver::PreconditionedCg];

impl Equilibrium for SqueezedContact {
    type State = SqueezedSolution;

    fn solvers(&self) -> &'static [Solver] {
        &SOLVERS
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        match drive.load {
            Load::MeanPressure(found) if found > 0.0 && found.is_finite() => {
                Units::check_pressure(found)?;
                if let Some(hardness) = self.hardness() {
                    hardness.check_mean_over(&self.surfaces[0], found)?;
                }
            }
            Load::MeanPressure(found) => return Err(Refusal::MeanPressure { found }),
            Load::Approach(found) => {
                // With a hardness points yield, and any approach has a state.
                let is_fixed = self.hardness.is_none() && self.response.uniform_compliance() == 0.0;
                let limit = is_fixed.then(|| self.surfaces.iter().map(|surface| surface.mean_clearance()).sum());
                if !(found > 0.0 && found < limit.unwrap_or(f64::INFINITY)) {
                    return Err(Refusal::Approach { found, limit });
                }
            }
        }
        drive.check()
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        let [softest, _] = self.stiffness_range();
        rougher(&self.surfaces).check_resolution(drive.load, softest, tolerance)
    }

    /// Starts from the pressures of `start`, or from uniform ones.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&SqueezedSolution>,
        watch: &mut dyn Watch,
    ) -> Result<SqueezedSolution, SolveError<SqueezedSolution>> {
        budget.check()?;
        if !self.solvers().contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: self.solvers() }.into());
        }
        self.check(drive)?;
        self.check_resolution(drive, budget.tolerance)?;
        let start = start.map(|start| self.check_start(start)).transpose()?;
        let load = self.units.drive(drive).load;
        let coarsest = coarsest(self.length_scale(load), load, budget.tolerance);
        let (state, ending) = refine(coarsest, budget, start, watch, |length_scale, budget, start, watch| {
            let ended = dual::solve(self, load, length_scale, &budget, start, watch)?;
            let mut state = self.certified(ended.pressure, load);
            state.effort.iterations = ended.effort.iterations;
            state.effort.transform_pairs += ended.effort.transform_pairs;
            Ok((state, ended.ending))
        })?;
        for (surface, face) in self.scaled.iter().zip([&state.upper, &state.lower]) {
            if face.length_scale < coarsest {
                surface.check_heights(drive.load, face.length_scale, budget.tolerance)?;
            }
        }
        let state = self.given_units(state);
        Units::check_pressure(state.upper.mean_pressure)?;
        if let Load::Approach(_) = load {
            let [softest, _] = self.stiffness_range();
            let what = "mean pressure of this approach";
            rougher(&self.surfaces).check_traction(what, state.upper.mean_pressure, softest, budget.tolerance)?;
        }
        judge(state, ending, budget.tolerance)
    }
}

impl SqueezedContact {
    /// Returns the start pressures in `units`, if they are valid.
    fn check_start(&self, start: &SqueezedSolution) -> Result<Vec<f64>, Refusal> {
        let mut both = Vec::new();
        for Solution { pressure, .. } in [&start.upper, &start.lower] {
            let (share, found, expected) = (self.share(), pressure.len(), self.points());
            if share.any(found != expected) {
                return Err(Refusal::Start { found, expected });
            }
            let first = if share.is_whole() { 0 } else { share.rows().start };
            let wrong = pressure.indexed_iter().find(|(_, p)| !(p.is_finite() && **p >= 0.0));
            if let Some((index, value)) = share.first(wrong.map(|((i, j), value)| ([first + i, j], *value))) {
                return Err(Refusal::StartPressure { index, value });
            }
            if !share.any(pressure.iter().any(|p| *p != 0.0)) {
                return Err(Refusal::StartApart);
            }
            both.extend(pressure.iter().map(|p| p / self.units.stress()));
        }
        Ok(both)
    }
}

/// The state follows from its pressures.
impl Resumable for SqueezedContact {
    fn keep(&self, state: &mut SqueezedSolution, visitor: &mut dyn Visit) {
        for face in [&mut state.upper, &mut state.lower] {
            with_contiguous(&mut face.pressure, |pressure| visitor.rows(self.share(), pressure));
        }
        state.effort.visit(visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<SqueezedSolution, Refusal> {
        self.check(drive)?;
        let points = self.points();
        let mut pressure = vec![0.0; 2 * points];
        pressure.chunks_exact_mut(points).for_each(|face| visitor.rows(self.share(), face));
        let stress = self.units.stress();
        pressure.iter_mut().for_each(|p| *p /= stress);
        let mut state = self.given_units(self.certified(pressure, self.units.drive(drive).load));
        state.effort.visit(visitor);
        Ok(state)
    }
}

impl SqueezedSolution {
    /// Returns the normal displacement u_z of the lower face, in length; positive upwards, into the slab.
    pub fn lower_displacement_z(&self) -> Array2<f64> {
        -&self.lower.displacement
    }
}

impl Fields for SqueezedSolution {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.upper.pressure()
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.upper.displacement_z()
    }

    fn gap(&self) -> ArrayView2<'_, f64> {
        self.upper.gap()
    }

    fn mean_pressure(&self) -> f64 {
        self.upper.mean_pressure
    }

    fn approach(&self) -> f64 {
        self.approach
    }

    fn effort(&self) -> Effort {
        self.effort
    }

    /// Returns the larger residuals of the two faces; `saturation` only with a hardness.
    fn residuals(&self) -> Vec<(&'static str, f64)> {
        let [upper, lower] = [&self.upper, &self.lower].map(|face| face.plastic.as_ref());
        let saturation =
            upper.zip(lower).map(|(upper, lower)| ("saturation", worst([upper.saturation, lower.saturation])));
        self.residual().parts().into_iter().chain(saturation).collect()
    }

    fn scales(&self) -> Scales {
        self.upper.scales()
    }

    /// Returns the summary of the upper contact, with the elastic energy of both pressures.
    fn summary_in(&self, scales: &Scales) -> Summary {
        let [upper, lower] = [&self.upper, &self.lower].map(|face| face.summary_in(scales));
        Summary { elastic_energy: upper.elastic_energy + lower.elastic_energy, ..upper }
    }
}

impl Refined for SqueezedSolution {
    /// Returns the finer scale of the two faces.
    fn length_scale(&self) -> f64 {
        self.upper.length_scale.min(self.lower.length_scale)
    }

    fn start(&self) -> Vec<f64> {
        [&self.upper, &self.lower].into_iter().flat_map(|face| face.start()).collect()
    }

    fn effort_mut(&mut self) -> &mut Effort {
        &mut self.effort
    }
}

impl SqueezedSolution {
    /// Returns the larger residuals of the two faces. If the approach is prescribed, the load residual is the
    /// difference of the two mean pressures divided by their mean.
    pub fn residual(&self) -> Residual {
        let [upper, lower] = [&self.upper, &self.lower].map(|face| face.residual);
        let larger = |of: fn(&Residual) -> f64| worst([of(&upper), of(&lower)]);
        Residual {
            complementarity: larger(|residual| residual.complementarity),
            penetration: larger(|residual| residual.penetration),
            negative_pressure: larger(|residual| residual.negative_pressure),
            load: larger(|residual| residual.load),
        }
    }
}
