use gfmd_contact::{Drive, Equilibrium, Fields as _, Load, Refusal, SolveError, Solver, Units, judge};
use gfmd_relax::{Budget, Ending, Fire, Progress, Watch};

use crate::certify::certify;
use crate::frame::Frame;
use crate::search_result::{End, SearchResult};
use crate::{Interface, State, dynamics, newton};

/// Solvers of an interface. Newton's method needs an energy; dynamics does not.
const SOLVERS: [Solver; 4] = [Solver::Auto, Solver::Newton, Solver::Fire, Solver::Fire2];

/// Solvers at a wall that gives way, of a plate, and of several processes.
const SMOOTH_SOLVERS: [Solver; 2] = [Solver::Auto, Solver::Newton];

impl Equilibrium for Interface {
    type State = State;

    fn solvers(&self) -> &'static [Solver] {
        let needs_energy = self.gives_way() || self.elastic.faces() == 2 || !self.share.is_whole();
        if needs_energy { &SMOOTH_SOLVERS } else { &SOLVERS }
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        if let Load::MeanPressure(mean) = drive.load {
            Units::check_pressure(mean)?;
        }
        drive.check()?;
        self.check_hardness(drive.load)?;
        self.frame(self.units.drive(drive)).map(drop).map_err(|refusal| match (refusal, drive.load) {
            (Refusal::Approach { limit, .. }, Load::Approach(found)) => {
                Refusal::Approach { found, limit: limit.map(|limit| limit * self.units.length()) }
            }
            (refusal, _) => refusal,
        })
    }

    /// Accepts any load with attraction, where residuals are absolute. A wall alone needs a load that they resolve.
    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        let (what, found) = match drive.load {
            Load::MeanPressure(mean) => ("mean pressure", mean),
            Load::Approach(approach) => ("approach", approach),
        };
        if !self.is_wall_alone() || found <= 0.0 {
            return Ok(());
        }
        let [softest, _] = self.elastic.stiffness_range();
        let softest = softest * self.units.stiffness();
        self.given.check_resolution(drive.load, softest, tolerance)?;
        let unit = if let Load::MeanPressure(_) = drive.load { softest } else { 1.0 } * self.given.rms_height();
        let least = RESOLVED * tolerance * unit;
        if found < least { Err(Refusal::Unresolved { what, found, least, tolerance }) } else { Ok(()) }
    }

    /// Lowers the energy from `start` to a stable state. Without `start`, the search begins at the contact with a hard
    /// wall alone if the drive presses, else at the undeformed surface. [`Solver::Auto`] is Newton's method if an
    /// energy exists, else FIRE 2.0.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&State>,
        watch: &mut dyn Watch,
    ) -> Result<State, SolveError<State>> {
        budget.check()?;
        self.check(drive)?;
        self.check_resolution(drive, budget.tolerance)?;
        if self.units.are_one() {
            let state = self.rest(drive, solver, budget, start, watch)?;
            self.check_load(&state, drive, budget.tolerance)?;
            return Ok(state);
        }
        let (length, stress) = (self.units.length(), self.units.stress());
        let start = start.map(|state| state.clone().times(1.0 / length, 1.0 / stress));
        let given = |state: State| state.times(length, stress);
        let watch = &mut self.units.shown(watch);
        match self.rest(self.units.drive(drive), solver, budget, start.as_ref(), watch) {
            Ok(state) => {
                Units::check_pressure(state.mean_pressure * stress)?;
                let state = given(state);
                self.check_load(&state, drive, budget.tolerance)?;
                Ok(state)
            }
            Err(SolveError::Detached { state, mean_pressure }) => {
                Err(SolveError::Detached { state: given(*state).into(), mean_pressure: mean_pressure * stress })
            }
            Err(error) => Err(error.map(given)),
        }
    }
}

/// Smallest load or approach of a wall alone, relative to the size of the roughness and divided by the tolerance.
const RESOLVED: f64 = 10.0;

/// Rounding error of a mean relative to the largest value: a load of this size counts as zero, such as the middle one
/// from -0.1 to 0.1.
const ROUNDING_OF_MEAN: f64 = 16.0 * f64::EPSILON;

impl Interface {
    /// Checks that the tractions of the law do not hide a prescribed load, in input units. The load residual is
    /// relative to the largest traction, so that a load below this traction times the tolerance may or may not be met.
    /// A load that is zero within rounding counts as zero.
    fn check_load(&self, state: &State, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        let Load::MeanPressure(found) = drive.load else { return Ok(()) };
        let largest = state.pressure().iter().fold(0.0, |largest: f64, p| largest.max(p.abs()));
        let traction = self.share.each(largest).into_iter().fold(0.0, f64::max);
        let (least, zero) = (tolerance * traction, ROUNDING_OF_MEAN * traction);
        let is_hidden = found.abs() > zero && found.abs() < least;
        if is_hidden { Err(Refusal::LoadBelowTractionRounding { found, least, traction }) } else { Ok(()) }
    }

    /// Solves in [`units`](Self::units).
    pub(crate) fn rest(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&State>,
        watch: &mut dyn Watch,
    ) -> Result<State, SolveError<State>> {
        let frame = self.frame(drive)?;
        let expected = frame.components() * frame.inside();
        let found = start.map(|state| state.displacement.len()).filter(|found| *found != expected);
        if let Some(found) = self.share.first(found) {
            return Err(Refusal::Start { found, expected }.into());
        }
        let method = self.method(solver, &frame)?;
        let is_pressed = match drive.load {
            Load::MeanPressure(found) | Load::Approach(found) => found > 0.0,
        };
        let nearer = match start {
            // A continued search has its own position. These searches are short and write no checkpoint.
            None if is_pressed && !self.is_wall_alone() && watch.recall().is_none() => {
                self.without_attraction(drive, budget, &mut |now: &Progress| watch.see(now))?
            }
            Some(start) if matches!(method, Method::Newton) && watch.recall().is_none() => {
                let mut is_stopped = false;
                let nearer = self.with_attraction_held(drive, budget, start, &mut |now: &Progress| {
                    let flow = watch.see(now);
                    is_stopped |= flow.is_break();
                    flow
                });
                if self.share.any(is_stopped) {
                    // Without a checkpoint, a continued search makes all rounds again.
                    let position = frame.starting_position(&self.elastic, Some(start));
                    return judge(certify(self, &frame, &position, &[]), Ending::Interrupted, budget.tolerance);
                }
                nearer
            }
            _ => None,
        };
        let before =
            nearer.as_ref().map_or((0.0, false), |state| (state.effort.transform_pairs, state.passed_instability));
        let start = nearer.as_ref().or(start);
        let SearchResult { position, inset, iterations, transform_pairs, passed_instability, lowest_curvature, end } =
            match method {
                Method::Newton => newton::descend(self, &frame, budget, start, before, watch),
                Method::Dynamics(engine) => dynamics::relax_to_rest(self, &frame, engine, budget, start, watch)?,
            };
        let mut state = certify(self, &frame, &position, &inset);
        if self.share.any(state.traction.iter().any(|t| !t.is_finite())) {
            return Err(Refusal::Overflow.into());
        }
        state.effort.iterations = iterations;
        state.effort.transform_pairs += transform_pairs;
        state.passed_instability = passed_instability;
        state.lowest_curvature = lowest_curvature;
        match end {
            End::Detached => Err(SolveError::Detached { state: Box::new(state), mean_pressure: frame.push }),
            End::Finished(ending) => judge(state, ending, budget.tolerance),
        }
    }
}

enum Method {
    Newton,
    /// Damped dynamics by FIRE, created from its largest time step.
    Dynamics(fn(f64) -> Fire),
}

impl Interface {
    fn method(&self, solver: Solver, frame: &Frame) -> Result<Method, Refusal> {
        let engine = match solver {
            Solver::Auto | Solver::Newton if self.has_energy() => return Ok(Method::Newton),
            Solver::Newton => return Err(Refusal::NoEnergy),
            _ if !self.solvers().contains(&solver) => {
                return Err(Refusal::Solver { found: solver, allowed: self.solvers() });
            }
            Solver::Fire => Fire::bitzek,
            Solver::Auto | Solver::Fire2 => Fire::v2,
            _ => return Err(Refusal::Solver { found: solver, allowed: self.solvers() }),
        };
        if solver != Solver::Auto && self.law.has_wall() && frame.held[frame.z()] {
            return Err(Refusal::NoDynamics);
        }
        Ok(Method::Dynamics(engine))
    }

    /// Returns the smallest reference stress of residuals, in [`units`](Self::units): the softest stiffness times the
    /// rms height or, for a wall alone, the stress of the load if lower. Errors that are small relative to the
    /// roughness may exceed a small load.
    pub(crate) fn stress_scale(&self, load: Load) -> f64 {
        let [softest, _] = self.elastic.stiffness_range();
        let rough = softest * self.surface.rms_height();
        match load {
            Load::MeanPressure(mean) if mean > 0.0 && self.is_wall_alone() => rough.min(mean),
            Load::Approach(approach) if approach > 0.0 && self.is_wall_alone() => rough.min(softest * approach),
            _ => rough,
        }
    }

    fn is_wall_alone(&self) -> bool {
        self.law.has_wall() && self.law.stiffness_bound(0.0) == 0.0 && self.law.steepness() == 0.0
    }
}
