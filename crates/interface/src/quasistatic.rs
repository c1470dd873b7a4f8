//! Contacts made of parts, under loads or increment by increment.

mod division;
mod end;
mod faces;
mod gradient;
mod loads;
mod normal;
mod parts;
mod response;
mod shear;
mod state;
mod step;
mod stiffness;
mod stuck;
mod tangential;

use std::sync::Arc;

use gfmd_contact::{
    Boundary, Drive, Effort, Equilibrium, Fields as _, Hardness, Load, Loss, Quasistatic, Reading, Refusal, Resumable,
    RigidSurface, SolveError, Solver, Units, Variables as _, Visit,
};
use gfmd_field::Share;
use gfmd_law::{InUnits, Law};
use gfmd_medium::Medium;
use gfmd_relax::{Budget, Progress, Watch};
use gfmd_response::{FreeFullCompliance, FullResponse};
use ndarray::{Array2, ArrayRef2};

use crate::{StoredFields, Trapping};
pub use gradient::{Increment, PathGradient, PathGradientError};
use normal::Normal;
pub use parts::{LimitingPressure, Parts, Sequence, Shear, Wear};
use response::Response;
pub use state::QuasistaticState;
use step::Step;
pub use stiffness::StiffnessError;

/// A rigid rough surface above an elastic body, made of [`Parts`]: any body, any interaction, any history (theory.md,
/// section 8.2).
///
/// Under [loads](Sequence::Loads) each drive is a problem of its own. Along a [path](Sequence::Path) a drive is one
/// increment from the previous state, or from the undeformed surfaces at first touch. Each increment is
/// one problem: the body relates displacement and traction by an affine function, which contains its memory; the
/// repulsion at a point has bounds, and a compliance where the surfaces wear; the shear has a limit, set by the
/// repulsion; depths worn off and pressed in are updated at the end (implicit steps). At points where the shear is
/// below its limit the surfaces stick, that is, move together during the increment; at the limit they may slip against
/// the shear. The slip of a point that comes into contact counts from its position at the start of the increment.
///
/// With a shear strength alone ([`Limit::Tresca`](gfmd_law::Limit::Tresca)) the limit is discontinuous at the contact
/// edge. If shear moves the surface up and down (for all bodies except ν = ½), a point at the edge may have no
/// solution, because its shear lifts it out of contact. The solver then returns [`SolveError::NotConverged`].
///
/// A clone shares the data.
#[derive(Clone)]
pub struct QuasistaticContact {
    sequence: Sequence,
    /// Contact along the normal on a body with its long-term moduli, hardness and law in `units`.
    normal: Normal,
    medium: Option<Arc<dyn Medium>>,
    hardness: Option<Hardness>,
    shear: Option<Shear>,
    /// Response of all components, with shear.
    response: Option<Response>,
    wear: Option<Wear>,
    all_components: bool,
    /// Lateral displacement of the surface by its base alone, component by component, in `units`; empty if it is zero.
    sideways: Vec<f64>,
    /// Rigid surface as given.
    given: Arc<RigidSurface>,
    /// Rigid surface in `units`.
    scaled: Arc<RigidSurface>,
    /// E* as given.
    contact_modulus: f64,
    units: Units,
}

/// Checks that a drive does not run backwards from a time and distance. NaN is neither before nor after.
fn check_order(drive: Drive, [time, distance]: [f64; 2]) -> Result<(), Refusal> {
    match (drive.time >= time, drive.distance >= distance) {
        (true, true) => Ok(()),
        (false, _) => Err(Refusal::Time { found: drive.time, least: time }),
        (true, false) => Err(Refusal::Distance { found: drive.distance, least: distance }),
    }
}

/// The only solver of a contact with shear.
const WITH_SHEAR: [Solver; 1] = [Solver::Auto];

impl QuasistaticContact {
    /// Creates the contact of these parts.
    ///
    /// # Errors
    /// Returns an error for heights that do not match the grid or are not finite; for flat heights at a wall; for parts
    /// that are out of range; for a lower surface; for a body with unknown compliance of a patch, or with unknown
    /// relaxation; and for loads with shear, relaxation or wear.
    pub fn new(parts: &Parts) -> Result<Self, Refusal> {
        if parts.lower.is_some() {
            return Err(Refusal::Faces { found: 2, expected: 1 });
        }
        match parts.sequence {
            Sequence::Loads => Self::of_loads(parts),
            Sequence::Path => Self::of_path(parts),
        }
    }

    fn of_path(parts: &Parts) -> Result<Self, Refusal> {
        let Parts { body, grid, heights, boundary, law, all_components, held, .. } = parts;
        let Parts { hardness, shear, wear, sideways, .. } = parts;
        let share = &parts.share();
        let surface = RigidSurface::distributed(share, grid, *heights)?;
        let given = Arc::new(if *boundary == Boundary::Free { surface.alone() } else { surface });
        let units = Units::of(body, &given)?;
        let wear = wear.map(Wear::check).transpose()?;
        if wear.is_some_and(|wear| wear.by_slip > 0.0) && shear.is_none() {
            return Err(Refusal::WearBySlip);
        }
        if *all_components && (shear.is_some() || wear.is_some() || hardness.is_some()) {
            return Err(Refusal::AllComponents);
        }
        if *held {
            parts.check_held()?;
        }
        let limit = shear.map(|shear| shear.limit.check()).transpose()?;
        let (stress, length) = (units.stress(), units.length());
        let shear = shear.zip(limit).map(|(shear, limit)| Shear { limit: limit.in_units(stress), ..shear });
        let hardness = hardness.as_ref().map(|hardness| hardness.times(1.0 / stress));
        let law = law.as_ref().map(|law| match units.are_one() {
            true => Arc::clone(law),
            false => InUnits::new(Arc::clone(law), stress, length).into_shared(),
        });
        let (body, grid) = (&units.body(body), &units.grid(grid));
        let response = match (shear, boundary) {
            (None, _) => None,
            (Some(_), Boundary::Periodic) => {
                Some(Response::Periodic(FullResponse::distributed(*grid, body, share).into()))
            }
            (Some(_), Boundary::Free) => {
                Some(Response::Free(FreeFullCompliance::distributed(*grid, body, share)?.into()))
            }
        };
        let normal =
            Normal::of(parts, share, (body, grid, heights.in_unit(length)), law, response.as_ref(), hardness.as_ref())?;
        let components = match &normal {
            Normal::Law(interface) => interface.elastic().components(),
            Normal::Wall(_) => 1,
        };
        let components = response.as_ref().map_or(components, |response| response.components().len());
        let sideways: Vec<f64> = match all_components {
            true => sideways.iter().flat_map(|field| field.iter().map(|u| u / length)).collect(),
            false => Vec::new(),
        };
        let expected = (components - 1) * given.clearance().len();
        if !sideways.is_empty() && sideways.len() != expected {
            return Err(Refusal::Start { found: sideways.len(), expected });
        }
        Ok(Self {
            sequence: Sequence::Path,
            normal,
            medium: parts.medium(grid, share, components)?,
            hardness,
            shear,
            response,
            wear: wear.map(|wear| Wear { by_distance: wear.by_distance * stress, by_slip: wear.by_slip * stress }),
            all_components: *all_components,
            sideways,
            scaled: units.surface(&given),
            given,
            contact_modulus: parts.body.contact_modulus(),
            units,
        })
    }

    /// Returns the rigid surface.
    pub fn surface(&self) -> &RigidSurface {
        &self.given
    }

    /// Returns the boundary of the surface.
    pub fn boundary(&self) -> Boundary {
        self.normal.boundary()
    }

    /// Returns a warning if the law is too steep for the grid ([`Interface::trapping`](crate::Interface::trapping)).
    pub fn trapping(&self) -> Option<Trapping> {
        let Normal::Law(interface) = &self.normal else { return None };
        let unit = self.units.stiffness();
        interface
            .trapping()
            .map(|found| Trapping { steepness: found.steepness * unit, stiffness: found.stiffness * unit })
    }

    /// Returns the names of the fields that [`certify`](Self::certify) needs for a state; empty if it cannot make one:
    /// with shear, or of a body with a memory.
    pub fn basis(&self) -> &'static [&'static str] {
        if self.sequence == Sequence::Loads {
            return self.normal.basis();
        }
        let has_history = self.shear.is_some() || self.medium.is_some() || self.all_components;
        match (&self.normal, &self.hardness, self.wear) {
            _ if has_history => &[],
            (Normal::Wall(_), None, None) => &["pressure"],
            (Normal::Wall(_), Some(_), None) => &["pressure", "plastic_depth"],
            (Normal::Wall(_), None, Some(_)) => &["pressure", "wear_depth"],
            (Normal::Wall(_), Some(_), Some(_)) => &["pressure", "plastic_depth", "wear_depth"],
            (Normal::Law(_), None, None) => &["gap", "pressure"],
            (Normal::Law(_), Some(_), None) => &["gap", "pressure", "plastic_depth"],
            (Normal::Law(_), None, Some(_)) => &["gap", "pressure", "wear_depth"],
            (Normal::Law(_), Some(_), Some(_)) => &["gap", "pressure", "plastic_depth", "wear_depth"],
        }
    }

    /// Computes the state of the [`basis`](Self::basis) fields under a drive, with fresh transforms. Depths are totals,
    /// and nothing is lost.
    ///
    /// # Errors
    /// Returns an error if the fields are not the basis, or do not fit the grid, or if the drive is invalid.
    pub fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<QuasistaticState, Refusal> {
        if self.sequence == Sequence::Loads {
            return self.certify_load(fields, drive);
        }
        let names = self.basis();
        if names.is_empty() || fields.len() != names.len() {
            return Err(Refusal::Basis { found: fields.len(), expected: names.len() });
        }
        let (points, shape) = (self.points(), self.normal.surface().shape());
        let wrong = fields.iter().find(|field| <[usize; 2]>::from(field.dim()) != shape).map(|field| field.len());
        if let Some(found) = self.share().first(wrong) {
            return Err(Refusal::Start { found, expected: points });
        }
        drive.check()?;
        let (length, stress) = (self.units.length(), self.units.stress());
        let field = |name: &str| {
            let unit = if name == "pressure" { stress } else { length };
            names.iter().position(|other| *other == name).map(|at| fields[at].mapv(|value| value / unit))
        };
        let drive = self.drive(drive);
        let mut start = self.blank()?;
        (start.time, start.distance) = (drive.time, drive.distance);
        (start.worn, start.pressed_in) = (field("wear_depth"), field("plastic_depth"));
        let none = || Array2::zeros(shape);
        let basis = (field("gap").unwrap_or_else(none), field("pressure").unwrap_or_else(none));
        let step = Step::new(self, drive, Some(&start))?;
        Ok(self.given_units(self.end(&step, step.reached((&basis.0, &basis.1))?)?))
    }

    /// Restores a state without history from stored fields, as a start.
    ///
    /// # Errors
    /// Returns an error for a contact with a history, or if the fields do not fit the grid.
    pub fn recall(&self, stored: StoredFields<'_>) -> Result<QuasistaticState, Refusal> {
        if self.sequence == Sequence::Loads {
            return self.recall_load(stored);
        }
        if self.basis().iter().any(|name| name.ends_with("depth")) || self.basis().is_empty() {
            return Err(Refusal::Basis { found: 3, expected: self.basis().len() });
        }
        let StoredFields { pressure, displacement_z, gap, approach } = stored;
        let (length, stress) = (self.units.length(), self.units.stress());
        let [pressure, displacement_z, gap] =
            [(pressure, stress), (displacement_z, length), (gap, length)].map(|(field, unit)| field.mapv(|x| x / unit));
        let approach = approach / length;
        let fields = StoredFields { pressure: &pressure, displacement_z: &displacement_z, gap: &gap, approach };
        let mut start = self.blank()?;
        start.normal = self.normal.recall(fields)?;
        Ok(self.given_units(start))
    }

    /// Returns the points of this process.
    fn share(&self) -> &Share {
        self.normal.surface().share()
    }

    /// Returns the number of points of all processes.
    fn all_points(&self) -> f64 {
        if self.share().is_whole() { self.points() as f64 } else { self.share().total() as f64 }
    }

    /// Returns the number of points of this process.
    fn points(&self) -> usize {
        self.normal.surface().clearance().len()
    }

    fn field(&self, values: Vec<f64>) -> Array2<f64> {
        let shape = self.normal.surface().shape();
        Array2::from_shape_vec(shape, values).expect("every field has the size of the grid")
    }

    /// Converts a drive to the units of the solve.
    fn drive(&self, drive: Drive) -> Drive {
        Drive { distance: drive.distance / self.units.length(), ..self.units.drive(drive) }
    }

    /// Converts a state to the units of the solve.
    fn in_units(&self, state: &QuasistaticState) -> QuasistaticState {
        if self.units.are_one() {
            return state.clone();
        }
        let scales = (&self.scaled, self.contact_modulus / self.units.modulus());
        state.clone().times(1.0 / self.units.length(), 1.0 / self.units.stress(), scales)
    }

    fn given_units(&self, state: QuasistaticState) -> QuasistaticState {
        if self.units.are_one() {
            return state;
        }
        state.times(self.units.length(), self.units.stress(), (&self.given, self.contact_modulus))
    }

    /// Returns true if surfaces in first touch without load are not in equilibrium on a body that relaxes: the law
    /// attracts them at once.
    fn is_drawn(&self) -> bool {
        self.medium.is_some() && self.attracts()
    }

    /// Returns true unless a law without a potential acts.
    fn has_energy(&self) -> bool {
        match &self.normal {
            Normal::Law(interface) => interface.has_energy(),
            Normal::Wall(_) => true,
        }
    }

    /// Solves an increment in the units of the solve.
    fn increment(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        (start, near): (Option<&QuasistaticState>, Option<&QuasistaticState>),
        watch: &mut dyn Watch,
    ) -> Result<QuasistaticState, SolveError<QuasistaticState>> {
        if start.is_none() && drive.time > 0.0 && self.is_drawn() {
            let load = match drive.load {
                Load::MeanPressure(_) => Load::MeanPressure(0.0),
                Load::Approach(_) => Load::Approach(0.0),
            };
            // The search is short and writes no checkpoint.
            let touched = Step::new(self, load.into(), None)?
                .solve(solver, budget, None, &mut |now: &Progress| watch.see(now))?;
            let mut state = Step::new(self, drive, Some(&touched))?.solve(solver, budget, near, watch)?;
            let (Effort { iterations, transform_pairs }, effort) = (touched.effort(), state.normal.effort());
            effort.iterations += iterations;
            effort.transform_pairs += transform_pairs;
            // The surfaces may yield when they jump into contact.
            state.losses = state.losses.and(touched.losses);
            return Ok(state);
        }
        Step::new(self, drive, start)?.solve(solver, budget, near, watch)
    }

    /// Solves an increment from `start`, with a search from `near` if it is given.
    fn solve(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        (start, near): (Option<&QuasistaticState>, Option<&QuasistaticState>),
        watch: &mut dyn Watch,
    ) -> Result<QuasistaticState, SolveError<QuasistaticState>> {
        if self.sequence == Sequence::Loads {
            return self.load(drive, solver, budget, near.or(start), watch);
        }
        budget.check().map_err(Refusal::from)?;
        self.check(drive)?;
        if self.shear.is_some() {
            self.check_resolution(drive, budget.tolerance)?;
        }
        if !self.solvers().contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: self.solvers() }.into());
        }
        let expected = self.points();
        let found = start.into_iter().chain(near).map(|state| state.gap().len()).find(|found| *found != expected);
        if let Some(found) = self.share().first(found) {
            return Err(Refusal::Start { found, expected }.into());
        }
        if self.units.are_one() {
            return self.increment(drive, solver, budget, (start, near), watch);
        }
        let stress = self.units.stress();
        let [start, near] = [start, near].map(|state| state.map(|state| self.in_units(state)));
        let watch = &mut self.units.shown(watch);
        let solved = self.increment(self.drive(drive), solver, budget, (start.as_ref(), near.as_ref()), watch);
        let state = solved.map_err(|error| match error {
            SolveError::Refused(refusal) => SolveError::Refused(self.given_refusal(refusal)),
            SolveError::Detached { state, mean_pressure } => {
                SolveError::Detached { state: self.given_units(*state).into(), mean_pressure: mean_pressure * stress }
            }
            error => error.map(|state| self.given_units(state)),
        })?;
        Units::check_pressure(state.mean_pressure() * stress)?;
        Ok(self.given_units(state))
    }
}

impl Equilibrium for QuasistaticContact {
    type State = QuasistaticState;

    fn solvers(&self) -> &'static [Solver] {
        let by_slip = self.wear.is_some_and(|wear| wear.by_slip > 0.0);
        if self.shear.is_some() || by_slip { &WITH_SHEAR } else { self.normal.solvers() }
    }

    /// Accepts approaches beyond the mean clearance of worn surfaces. Along a path a hard wall may part from the
    /// surface and touch it again: under a mean pressure of zero, at first touch, and at any approach below it. Ignores
    /// a lateral displacement of surfaces that do not shear each other.
    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        if self.sequence == Sequence::Loads {
            return self.normal.check(drive);
        }
        drive.check()?;
        check_order(drive, [0.0; 2])?;
        match drive.load {
            _ if self.lifts(drive.load) => Ok(()),
            Load::Approach(approach)
                if approach > 0.0 && self.wear.is_some() && self.boundary() == Boundary::Periodic && self.is_wall() =>
            {
                Ok(())
            }
            load => {
                if let Load::MeanPressure(mean) = load {
                    Units::check_pressure(mean)?;
                }
                self.normal.check(self.drive(drive)).map_err(|refusal| self.given_refusal(refusal))
            }
        }
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        if self.lifts(drive.load) {
            return Ok(());
        }
        self.normal.check_resolution(self.drive(drive), tolerance).map_err(|refusal| self.given_refusal(refusal))
    }

    /// Solves the load, with a search from `start`; or the increment from `start`, or from the undeformed surfaces at
    /// time 0 and distance 0. A law on a body
    /// that relaxes first draws the surfaces together, which takes a second solve.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&QuasistaticState>,
        watch: &mut dyn Watch,
    ) -> Result<QuasistaticState, SolveError<QuasistaticState>> {
        self.solve(drive, solver, budget, (start, None), watch)
    }
}

impl QuasistaticContact {
    fn is_wall(&self) -> bool {
        matches!(self.normal, Normal::Wall(_))
    }

    /// Returns true for a load along a path that lifts a hard wall off the given surface.
    fn lifts(&self, load: Load) -> bool {
        self.sequence == Sequence::Path && self.is_wall() && load.is_lifted()
    }

    /// Converts the numbers of a refusal to the units of the input.
    fn given_refusal(&self, refusal: Refusal) -> Refusal {
        if self.units.are_one() { refusal } else { refusal.times(self.units.length(), self.units.stress()) }
    }
}

impl Quasistatic for QuasistaticContact {
    fn reading(&self, state: &QuasistaticState) -> Reading {
        let stored = || state.elastic_energy() + state.interface_energy();
        let loss = match &self.normal {
            Normal::Law(_) if !self.has_energy() => Loss::Unknown,
            _ if !self.loses() && !self.attracts() => Loss::Conserved,
            Normal::Law(_) if !self.loses() => Loss::Balance(stored()),
            Normal::Wall(_) if self.medium.is_none() && self.wear.is_none() => Loss::Known(state.losses.total()),
            _ => {
                let flows = self.shear.is_some() || self.hardness.is_some();
                Loss::Certified {
                    lost: state.losses.total(),
                    imbalance: state.work_imbalance,
                    stored: (self.may_jump() && !flows).then(stored),
                    flows,
                }
            }
        };
        Reading {
            mean_pressure: state.mean_pressure(),
            approach: state.approach(),
            mean_shear: state.mean_shear,
            lateral: state.lateral,
            time: state.time,
            distance: state.distance,
            losses: state.losses,
            loss,
            worn: [state.wear_volume(), 0.0],
        }
    }

    fn depends_on_division(&self, start: Option<&QuasistaticState>, end: &QuasistaticState, tolerance: f64) -> bool {
        self.may_change(start, end, tolerance)
    }

    fn change(&self, start: Option<&QuasistaticState>, from: &QuasistaticState, to: &QuasistaticState) -> f64 {
        self.distance(start, from, to)
    }

    /// Returns true for surfaces with shear, unless the law has no energy.
    fn slips(&self) -> bool {
        self.shear.is_some() && self.has_energy()
    }

    fn polish(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        (start, near): (Option<&QuasistaticState>, &QuasistaticState),
        watch: &mut dyn Watch,
    ) -> Result<QuasistaticState, SolveError<QuasistaticState>> {
        self.solve(drive, solver, budget, (start, Some(near)), watch)
    }

    fn change_of_stick(&self, from: &QuasistaticState, to: &QuasistaticState) -> f64 {
        match from.stick_fraction().zip(to.stick_fraction()) {
            Some((from, sticking)) => {
                let own = to.repulsion().iter().filter(|r| **r > 0.0).count();
                let touching = self.share().each(own).into_iter().sum::<usize>() as f64 / self.all_points();
                (sticking - from).abs() / touching
            }
            None => 0.0,
        }
    }
}

impl Resumable for QuasistaticContact {
    fn keep(&self, state: &mut QuasistaticState, visitor: &mut dyn Visit) {
        match self.sequence {
            Sequence::Loads => self.keep_load(state, visitor),
            Sequence::Path => state.visit(visitor),
        }
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<QuasistaticState, Refusal> {
        if self.sequence == Sequence::Loads {
            return self.restore_load(drive, visitor);
        }
        self.check(drive)?;
        let mut state = self.given_units(self.blank()?);
        state.visit(visitor);
        Ok(state)
    }
}

impl std::fmt::Debug for QuasistaticContact {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { sequence, shear, wear, all_components, .. } = self;
        let relaxes = self.medium.is_some();
        f.debug_struct("QuasistaticContact")
            .field("sequence", sequence)
            .field("relaxes", &relaxes)
            .field("shear", shear)
            .field("wear", wear)
            .field("all_components", all_components)
            .finish_non_exhaustive()
    }
}
