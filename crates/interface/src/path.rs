//! Contacts along a path of drives, with the energy lost in each step (theory.md, section 8).

use gfmd_contact::{
    Drive, Effort, Fields, Loss, Losses, Quasistatic, Reading, Refusal, Resumable, SolveError, Solver, Visit,
};
use gfmd_relax::{Budget, Watch};

use crate::{Interface, State};

/// Equilibrium state with its forces and energies.
type SolvedState<S> = (S, Reading);

/// Step in equal increments.
struct Divided<S> {
    /// State before the last increment, if any.
    before: Option<SolvedState<S>>,
    end: SolvedState<S>,
    /// Sums of the losses and of the imbalances of all increments.
    losses: Losses,
    imbalance: f64,
}

/// Accuracy of the energy balance of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refinement {
    /// With an energy, the largest error of a step, relative to the work exchanged in the step or, if larger, to the
    /// mean work per step so far. Where a loss is [known](Loss::Known), the largest error of the loss relative to that
    /// work, and twice the largest [change](Quasistatic::change) of the state when its increments are halved; its
    /// square root is the largest change of the [sticking fraction](Quasistatic::change_of_stick) when the last
    /// increment is halved.
    pub tolerance: f64,
    /// Average limit of extra solves per step; the solves for eight steps may be used in advance. With 0, steps are
    /// never divided.
    pub solves_per_step: u64,
}

impl Default for Refinement {
    /// Returns a tolerance of 1e-3, with at most 4 extra solves per step on average.
    fn default() -> Self {
        Self { tolerance: 1e-3, solves_per_step: 4 }
    }
}

/// Energy balance and effort of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Energy lost per area, stress × length; `None` if the tractions have no energy.
    pub dissipated: Option<f64>,
    /// Energy lost by each cause per area, stress × length; zeros if `dissipated` is unknown.
    pub losses: Losses,
    /// Estimated error of `dissipated`. `None` if `dissipated` is unknown or the step was not halved. Where the loss is
    /// [certified](Loss::Certified), it is twice the difference from a path with half as many increments.
    pub dissipated_error: Option<f64>,
    /// Estimated errors of the mean depths [worn off so far](Reading::worn), length: twice the difference from a path
    /// with half as many increments. `None` if that path was not followed.
    pub worn_error: Option<[f64; 2]>,
    /// Sum of the imbalances of work and energy over the increments, where the loss is [certified](Loss::Certified).
    pub work_imbalance: Option<f64>,
    /// Number of equal increments, where the loss is [known](Loss::Known) or [certified](Loss::Certified), else 0. The
    /// last one may have been divided further, for the [sticking fraction](Quasistatic::change_of_stick).
    pub increments: u64,
    /// [Change](Quasistatic::change) of the state from half as many increments, extrapolated if these were not made;
    /// `None` if division changes nothing, NaN if it may but there were too few extra solves to halve the step.
    pub change: Option<f64>,
    /// True if more increments may change the state, its loss or its sticking fraction by more than the tolerance,
    /// because there were too few extra solves.
    pub is_unsettled: bool,
    /// True if a jump was enclosed in the step: two states so close that the forces between them, if monotonic, explain
    /// less than the missing energy. False if no piece of the step loses more energy than its allowed error. `None` if
    /// there were too few extra solves to decide, or if the tractions have no energy.
    pub jumped: Option<bool>,
    /// Number of extra solves; every step needs one solve.
    pub extra_solves: u64,
    /// Effort of all solves.
    pub effort: Effort,
}

/// A path of a contact, each state found from the previous one.
///
/// An elastic contact with a hard wall loses no energy: each step is one solve.
///
/// With a law, but without friction, the energy of a stable state changes by the work of the rigid surface, and energy
/// is lost only in jumps. A step is therefore divided until one of two conditions holds. Either the balance of work and
/// energy closes to fourth order and is alike in both halves, which shows that no energy was lost. Or a jump is
/// enclosed between two states so close that the work between them is negligible; the missing energy is then the loss.
/// Once the solves of a step are used up, the difference between the halves is an error of the loss.
///
/// With friction the state itself depends on the number of increments, as long as they are few: slip counts from the
/// start of an increment, which is too early where the contact grows. A step (also the first one, which begins at zero
/// load) is made in 1, 2, 4, ... equal increments until the state does not change; after 4, in the number at which the
/// last changes predict this (and the change by the last doubling follows from them). The last increment is then halved
/// until the sticking fraction of the contact does not change. Steps that change neither the limits of the shear nor
/// the direction of slip, or that have no shear, are made in one increment.
///
/// If the body relaxes or wears, the imbalance of work and energy of a step shows how far it must be divided. It is not
/// an error of the loss, though: at rest a relaxing body has no imbalance, however long its steps are. The path is
/// therefore also followed with half as many increments, from its start on; twice the difference is the error. In an
/// instantaneous step a law loses energy only in jumps, as on an elastic body.
///
/// A wave that jumps into contact and later out of it loses energy. Loading and unloading within the contact does not:
///
/// ```
/// use gfmd_contact::{Budget, Load, SolveError};
/// use gfmd_field::Grid;
/// use gfmd_green::{Body, Material};
/// use gfmd_interface::{Interface, Path, Refinement, State};
/// use gfmd_law::Exponential;
/// use ndarray::Array2;
///
/// let n = 256;
/// let grid = Grid::line(n, 1.0)?;
/// let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
/// let heights = Array2::from_shape_fn((n, 1), |(i, _)| 0.01 * (std::f64::consts::TAU * i as f64 / n as f64).cos());
/// let interface = Interface::new(&body, &grid, &heights, Exponential::new(1e-4, 2e-3)?)?;
///
/// let refinement = Refinement { solves_per_step: 12, ..Refinement::default() };
/// let mut path = Path::new(&interface, Budget::default(), refinement);
/// let mut lost = |waypoints: &[f64]| {
///     let (mut lost, mut error) = (0.0, 0.0);
///     for approach in waypoints {
///         let step = path.step(Load::Approach(*approach).into(), &mut ())?;
///         lost += step.dissipated.unwrap();
///         error += step.dissipated_error.unwrap();
///     }
///     Ok::<_, SolveError<State>>((lost, error))
/// };
/// let (loop_loss, error) = lost(&[-0.01, -0.005, 0.0, 0.003, 0.0, -0.005, -0.01])?;
/// assert!(loop_loss > 20.0 * error);
/// lost(&[0.0, 0.003])?;
/// let (smooth_loss, error) = lost(&[0.004, 0.005, 0.004, 0.003])?;
/// assert!(smooth_loss.abs() <= error && error < 1e-2 * loop_loss);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Path<'a, P: Quasistatic> {
    problem: &'a P,
    budget: Budget,
    solver: Solver,
    /// `None` for a path without energy balance.
    refinement: Option<Refinement>,
    last: Option<SolvedState<P::State>>,
    /// End of the path with half as many increments, if the loss is certified and its error is wanted.
    coarse: Option<SolvedState<P::State>>,
    /// True while every step was also made with half as many increments.
    is_halved: bool,
    /// Work exchanged in all steps so far, and their number.
    exchanged: f64,
    steps: u64,
    /// Remaining extra solves.
    allowance: u64,
}

impl<'a, P: Quasistatic> Path<'a, P> {
    /// Creates a path without a state. Without a refinement (`None`) each step is one solve, and its loss is not
    /// computed.
    pub fn new(problem: &'a P, budget: Budget, refinement: impl Into<Option<Refinement>>) -> Self {
        let refinement = refinement.into();
        let allowance = refinement.map_or(0, |refinement| refinement.solves_per_step.saturating_mul(IN_ADVANCE));
        let (solver, last, coarse) = (Solver::Auto, None, None);
        let path = Self {
            problem,
            budget,
            solver,
            refinement,
            last,
            coarse,
            is_halved: false,
            exchanged: 0.0,
            steps: 0,
            allowance,
        };
        Self { is_halved: path.seeks_errors(), ..path }
    }

    /// Sets the method of all solves, [`Solver::Auto`] by default.
    #[must_use]
    pub fn solver(self, solver: Solver) -> Self {
        Self { solver, ..self }
    }

    /// Sets the starting state of the next step, or none.
    pub fn start_from(&mut self, state: Option<P::State>) {
        self.last = state.map(|state| {
            let reading = self.problem.reading(&state);
            (state, reading)
        });
        (self.coarse, self.is_halved) = (None, self.is_halved && self.last.is_none());
    }

    /// Returns the last state.
    pub fn state(&self) -> Option<&P::State> {
        self.last.as_ref().map(|(state, _)| state)
    }

    /// Returns the [solves per step](Refinement::solves_per_step) that would probably have settled the last `step` if
    /// it is unsettled: its change falls to a quarter with each division. Never less than the value of this path.
    pub fn settling_solves(&self, step: &Step) -> u64 {
        let Some(Refinement { tolerance, solves_per_step }) = self.refinement else { return 0 };
        if !step.is_unsettled {
            return solves_per_step;
        }
        let excess = step.change.unwrap_or(f64::NAN) / (OF_A_CHANGE * tolerance);
        let divisions =
            if excess.is_finite() { (0.5 * excess.log2()).ceil().clamp(1.0, MOST_DIVISIONS) } else { DIVISIONS };
        // 2 m + 4 m + ... solves, with m increments so far.
        let needed = 2.0 * step.increments as f64 * (divisions.exp2() - 1.0) - self.allowance as f64;
        solves_per_step.saturating_add((needed.max(1.0) / (IN_ADVANCE + 1) as f64).ceil() as u64)
    }

    /// Visits everything that [`resume`](Self::resume) needs to continue the path bit for bit; nothing before the first
    /// step.
    pub fn keep(&mut self, visitor: &mut dyn Visit)
    where
        P: Resumable,
    {
        if let Some((state, _)) = &mut self.last {
            self.problem.keep(state, visitor);
            self.visit_balance(visitor);
            if self.seeks_errors() {
                visitor.flag(&mut self.coarse.is_some());
            }
            if let Some((state, _)) = &mut self.coarse {
                self.problem.keep(state, visitor);
            }
        }
    }

    /// Visits the numbers of the energy balance, if any.
    fn visit_balance(&mut self, visitor: &mut dyn Visit) {
        if self.refinement.is_some() {
            visitor.number(&mut self.exchanged);
            visitor.count(&mut self.steps);
            visitor.count(&mut self.allowance);
        }
    }

    /// Continues a path after its step to `drive`, from the values that [`keep`](Self::keep) visited.
    ///
    /// # Errors
    /// Returns an error for an invalid drive.
    pub fn resume(&mut self, drive: Drive, visitor: &mut dyn Visit) -> Result<(), Refusal>
    where
        P: Resumable,
    {
        self.last = Some(self.restored(drive, visitor)?);
        self.visit_balance(visitor);
        self.is_halved = false;
        if self.seeks_errors() {
            visitor.flag(&mut self.is_halved);
        }
        self.coarse = if self.is_halved { Some(self.restored(drive, visitor)?) } else { None };
        Ok(())
    }

    fn restored(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<SolvedState<P::State>, Refusal>
    where
        P: Resumable,
    {
        let state = self.problem.restore(drive, visitor)?;
        let reading = self.problem.reading(&state);
        Ok((state, reading))
    }

    /// Returns true if each step is one solve, which can continue from a checkpoint.
    pub fn solves_once(&self) -> bool {
        !self.seeks_errors()
    }

    /// Returns true if a path with half as many increments gives the errors of certified losses.
    fn seeks_errors(&self) -> bool {
        self.refinement.is_some_and(|refinement| refinement.solves_per_step > 0)
    }

    /// Continues to `drive`. With [`Loss::Balance`], the first step loses no energy.
    ///
    /// # Errors
    /// Returns the errors of the solver. The state is then the last equilibrium state known to lie on the path.
    pub fn step(&mut self, drive: Drive, watch: &mut dyn Watch) -> Result<Step, SolveError<P::State>> {
        let Refinement { tolerance, solves_per_step } =
            self.refinement.unwrap_or(Refinement { solves_per_step: 0, ..Refinement::default() });
        let mut search = Search {
            problem: self.problem,
            budget: self.budget,
            solver: self.solver,
            watch,
            step: Step::default(),
            tolerance,
            increments_to: self.budget.tolerance,
            allowance: self.allowance.saturating_add(solves_per_step),
        };
        if solves_per_step > 0 && self.problem.slips() {
            search.increments_to = self.budget.tolerance.max(OF_AN_INCREMENT * tolerance);
        }
        let (state, reading) = search.rest(drive, self.state(), search.increments_to)?;
        if self.refinement.is_none() {
            self.last = Some((state, reading));
            return Ok(search.step);
        }
        let step = &mut search.step;
        match (reading.loss, self.last.take()) {
            (Loss::Unknown, _) => {}
            (Loss::Known(_), last) => {
                // An error leaves the path unchanged.
                self.last = last;
                let made = search.divide(self.last.as_ref(), (state, reading), drive);
                self.allowance = search.allowance;
                self.last = Some(made?);
                return Ok(search.step);
            }
            (Loss::Conserved, _) | (Loss::Balance(_), None) => {
                (step.dissipated, step.dissipated_error, step.jumped) = (Some(0.0), Some(0.0), Some(false));
            }
            (Loss::Balance(_) | Loss::Certified { stored: Some(_), .. }, Some((start, begin)))
                if matches!(reading.loss, Loss::Balance(_)) || reading.is_at_once(&begin) =>
            {
                let exchanged = Balance::between(&begin, &reading).exchanged;
                self.exchanged += exchanged;
                self.steps += 1;
                let reference = exchanged.max(self.exchanged / self.steps as f64);
                let mut here = StepPoint { state: start, reading: begin, share: 0.0, origin: 0.0 };
                let end = StepPoint { state, reading, share: 1.0, origin: 0.0 };
                let is_halved = self.is_halved && matches!(reading.loss, Loss::Certified { .. });
                let outcome = search.account(&mut here, end, drive, reference).and_then(|()| {
                    let worn = here.reading.worn;
                    let coarse = is_halved.then(|| search.beside(self.coarse.as_ref(), drive, worn)).transpose()?;
                    Ok(coarse.flatten())
                });
                self.allowance = search.allowance;
                self.last = Some((here.state, here.reading));
                let coarse = outcome?;
                (self.is_halved, self.coarse) = (coarse.is_some(), coarse);
                return Ok(search.step);
            }
            (Loss::Certified { .. } | Loss::Balance(_), last) => {
                self.last = last;
                let start = self.last.as_ref();
                let made = search.halve(start, (state, reading), drive, self.is_halved).and_then(|made| {
                    let (coarse, worn) = (self.coarse.as_ref(), made.1.worn);
                    let coarse = self.is_halved.then(|| search.beside(coarse, drive, worn)).transpose()?;
                    Ok((made, coarse.flatten()))
                });
                self.allowance = search.allowance;
                let (made, coarse) = made?;
                (self.last, self.is_halved, self.coarse) = (Some(made), coarse.is_some(), coarse);
                return Ok(search.step);
            }
        }
        self.last = Some((state, reading));
        Ok(search.step)
    }
}

/// Returns the difference between states by the last of several doublings of the increments, relative to the
/// difference by all of them, if each reduces it by the `ratio`.
fn of_last_doubling(ratio: f64, doublings: u32) -> f64 {
    ratio.powi(doublings as i32 - 1) * (1.0 - ratio) / (1.0 - ratio.powi(doublings as i32))
}

/// State within a step.
struct StepPoint<S> {
    state: S,
    reading: Reading,
    /// Position of the state within the step, from 0 to 1, and position of its starting state.
    share: f64,
    origin: f64,
}

/// Number of steps whose extra solves may be used in advance.
const IN_ADVANCE: u64 = 8;
/// Length relative to the step below which a piece is not divided.
const SHORTEST: f64 = 1e-9;
/// Allowed error of a piece with a jump, relative to the allowed error of its step.
const OF_A_JUMP: f64 = 0.25;
/// Allowed change from half as many increments, relative to the tolerance. The next change would be a little more than
/// half of it in the tractions, since their order in the length of an increment is slightly below one.
const OF_A_CHANGE: f64 = 0.5;
/// Difference between states after a doubling of the increments divided by the difference before, for an error of first
/// order in their length, and the largest value used: the order is slightly below one.
const FIRST_ORDER: f64 = 0.5;
const SLOWEST: f64 = 0.6;
/// Largest number of doublings at once.
const MOST_DOUBLINGS: f64 = 6.0;
/// Error of a certified loss divided by its change from half as many increments. Where a contact begins, the order in
/// their length is about one, and the error is as large as the change.
const OF_A_LOSS: f64 = 2.0;
/// Residual of increments of surfaces that slip, divided by the tolerance of the losses. The last one of a step is then
/// solved to the tolerance of the path.
const OF_AN_INCREMENT: f64 = 0.1;
/// Least part of a step whose increment may have this residual: the slip of a shorter one is smaller, and must exceed
/// the error of the search.
const LONG_PART: f64 = 0.03125;
/// Number of divisions of a step expected if its change is unknown (from the first loading of a sphere), and the
/// largest number.
const DIVISIONS: f64 = 4.0;
const MOST_DIVISIONS: f64 = 30.0;
/// Number of solves that must be left to divide a piece: both halves and the rest of the step then get a middle state,
/// without which their error is hardly known.
const RESERVE: u64 = 5;

/// Step during its computation.
struct Search<'a, P: Quasistatic> {
    problem: &'a P,
    budget: Budget,
    solver: Solver,
    watch: &'a mut dyn Watch,
    step: Step,
    /// Largest error of the step ([`Refinement::tolerance`]).
    tolerance: f64,
    /// Residual to which increments are solved before the last one is finished.
    increments_to: f64,
    /// Remaining extra solves.
    allowance: u64,
}

impl<P: Quasistatic> Search<'_, P> {
    fn rest(
        &mut self,
        drive: Drive,
        start: Option<&P::State>,
        tolerance: f64,
    ) -> Result<SolvedState<P::State>, SolveError<P::State>> {
        let budget = Budget { tolerance, ..self.budget };
        let state = self.problem.equilibrate(drive, self.solver, &budget, start, &mut *self.watch)?;
        Ok(self.read(state))
    }

    /// Adds the effort of a state to the step, and reads it.
    fn read(&mut self, state: P::State) -> SolvedState<P::State> {
        let Effort { iterations, transform_pairs } = state.effort();
        self.step.effort.iterations += iterations;
        self.step.effort.transform_pairs += transform_pairs;
        let reading = self.problem.reading(&state);
        (state, reading)
    }

    /// Finds the state at the end of a step from `start`, doubling the number of equal increments until the state does
    /// not change, from the third time on at once as often as is probably needed. `end` was found in one increment.
    fn divide(
        &mut self,
        start: Option<&SolvedState<P::State>>,
        end: SolvedState<P::State>,
        drive: Drive,
    ) -> Result<SolvedState<P::State>, SolveError<P::State>> {
        let tolerance = self.tolerance;
        let (state, begin) = (start.map(|(state, _)| state), start.map_or(Reading::UNLOADED, |(_, reading)| *reading));
        let mut made = Divided { before: None, losses: end.1.losses, imbalance: 0.0, end };
        self.step.increments = 1;
        let mut settles = !self.problem.depends_on_division(state, &made.end.0, tolerance);
        let mut change_of_stick = if settles { 0.0 } else { f64::INFINITY };
        if !settles {
            self.step.change = Some(f64::NAN);
        }
        let mut ratio = None;
        while !settles {
            let wanted = ratio.map_or(1, |ratio| self.doublings(ratio));
            let made_by = |doublings: &u32| self.can_make(self.step.increments << doublings);
            let Some(doublings) = (1..=wanted).rev().find(made_by) else { break };
            let increments = self.step.increments << doublings;
            let finer = match self.in_increments(state, &begin, drive, increments) {
                Ok(finer) => finer,
                Err(error @ SolveError::Interrupted { .. }) => return Err(error),
                // The step itself was solved; its change is not known.
                Err(_) => break,
            };
            let of_last = of_last_doubling(ratio.unwrap_or(FIRST_ORDER), doublings);
            let mut differences = self.differences(state, [&made, &finer], of_last);
            let exchanged = Balance::between(&begin, &finer.end.1).exchanged;
            let is_small =
                |[change, error, _]: [f64; 3]| change <= OF_A_CHANGE * tolerance && error <= tolerance * exchanged;
            // An extrapolated change that is too large may be so by its error alone.
            if doublings > 1 && !is_small(differences) && self.can_make(increments / 2) {
                match self.in_increments(state, &begin, drive, increments / 2) {
                    Ok(half) => differences = self.differences(state, [&half, &finer], 1.0),
                    Err(error @ SolveError::Interrupted { .. }) => return Err(error),
                    Err(_) => {}
                }
            }
            settles = is_small(differences);
            let [change, error, of_stick] = differences;
            change_of_stick = of_stick;
            let before = self.step.change.filter(|before| *before > 0.0);
            ratio = before.map(|before| (change / before).powf(0.5 / f64::from(doublings)).clamp(FIRST_ORDER, SLOWEST));
            (self.step.increments, self.step.change) = (increments, Some(change));
            self.step.dissipated_error = Some(error);
            made = finer;
        }
        // The sticking fraction only needs a short last increment.
        let mut last = 1.0 / self.step.increments as f64;
        let sticks = |change: f64| change <= tolerance.sqrt();
        while settles && !sticks(change_of_stick) && self.can_make(2) {
            last *= 0.5;
            let halved = match self.halve_last(&made, &begin, drive, last) {
                Ok(halved) => halved,
                Err(error @ SolveError::Interrupted { .. }) => return Err(error),
                Err(_) => break,
            };
            change_of_stick = self.problem.change_of_stick(&made.end.0, &halved.end.0);
            made = halved;
        }
        self.step.is_unsettled = !settles || !sticks(change_of_stick);
        let made = self.finish(made, state, drive)?;
        (self.step.dissipated, self.step.losses) = (Some(made.losses.total()), made.losses);
        Ok(made.end)
    }

    /// Returns the change of the state, of the loss and of the sticking fraction of a step between two divisions, the
    /// first two for the last of their doublings, which makes the fraction `of_last` of the difference.
    fn differences(&self, start: Option<&P::State>, [a, b]: [&Divided<P::State>; 2], of_last: f64) -> [f64; 3] {
        let change = self.problem.change(start, &a.end.0, &b.end.0);
        let of_loss = (b.losses.total() - a.losses.total()).abs();
        let of_stick = self.problem.change_of_stick(&a.end.0, &b.end.0);
        [of_last.powi(2) * change, of_last * of_loss, of_stick]
    }

    /// Returns the number of doublings that are probably needed until the state does not change, if each of them
    /// reduces the difference between states by the `ratio`.
    fn doublings(&self, ratio: f64) -> u32 {
        let excess = self.step.change.unwrap_or(f64::NAN) / (OF_A_CHANGE * self.tolerance);
        let needed = -0.5 * excess.ln() / ratio.ln();
        if needed.is_finite() { needed.ceil().clamp(1.0, MOST_DOUBLINGS) as u32 } else { 1 }
    }

    /// Makes a step, doubling the number of equal increments until the imbalance of work and energy is at most the
    /// tolerance times the work exchanged and the energy lost, and where points slip until the state does not change.
    /// There are at least two if half as many will be made, too. `end` was found in one increment.
    fn halve(
        &mut self,
        start: Option<&SolvedState<P::State>>,
        end: SolvedState<P::State>,
        drive: Drive,
        is_halved: bool,
    ) -> Result<SolvedState<P::State>, SolveError<P::State>> {
        let tolerance = self.tolerance;
        let (state, begin) = (start.map(|(state, _)| state), start.map_or(Reading::UNLOADED, |(_, reading)| *reading));
        let is_lossless = end.1.is_at_once(&begin) && !matches!(end.1.loss, Loss::Certified { flows: true, .. });
        let mut made = Divided { before: None, losses: end.1.losses, imbalance: end.1.imbalance(), end };
        self.step.increments = 1;
        let balances = |made: &Divided<P::State>, increments: u64| {
            made.imbalance <= tolerance * (Balance::between(&begin, &made.end.1).exchanged + made.losses.total())
                && (increments > 1 || is_lossless || !is_halved)
        };
        let mut settles = !self.problem.depends_on_division(state, &made.end.0, tolerance);
        if !settles {
            self.step.change = Some(f64::NAN);
        }
        let solves = if is_halved { 3 } else { 2 };
        while !(settles && balances(&made, self.step.increments)) && self.can_make(solves * self.step.increments) {
            let increments = 2 * self.step.increments;
            match self.in_increments(state, &begin, drive, increments) {
                Ok(finer) => {
                    if self.step.change.is_some() {
                        let change = self.problem.change(state, &made.end.0, &finer.end.0);
                        settles = change <= OF_A_CHANGE * tolerance;
                        self.step.change = Some(change);
                    }
                    (made, self.step.increments) = (finer, increments);
                }
                Err(error @ SolveError::Interrupted { .. }) => return Err(error),
                // The step itself was solved.
                Err(_) => break,
            }
        }
        self.step.is_unsettled = !settles;
        let made = self.finish(made, state, drive)?;
        (self.step.dissipated, self.step.work_imbalance) = (Some(made.losses.total()), Some(made.imbalance));
        self.step.losses = made.losses;
        self.step.dissipated_error = is_lossless.then_some(0.0);
        Ok(made.end)
    }

    /// Makes the step with half as many increments, too, from the end `coarse` of the coarser path, and sets the errors
    /// of the depths `worn` off and of the loss unless it is known. Returns `None` if the step is not divided or cannot
    /// be made.
    fn beside(
        &mut self,
        coarse: Option<&SolvedState<P::State>>,
        drive: Drive,
        worn: [f64; 2],
    ) -> Result<Option<SolvedState<P::State>>, SolveError<P::State>> {
        let (state, begin) =
            (coarse.map(|(state, _)| state), coarse.map_or(Reading::UNLOADED, |(_, reading)| *reading));
        let increments = match (self.step.dissipated_error, self.step.increments) {
            (Some(_), _) => 1,
            (None, increments) => increments / 2,
        };
        if increments == 0 || increments > self.allowance {
            return Ok(None);
        }
        match self.in_increments(state, &begin, drive, increments) {
            Ok(Divided { end, losses, .. }) => {
                let lost = losses.total();
                let change = self.step.dissipated.map(|dissipated| OF_A_LOSS * (dissipated - lost).abs());
                self.step.dissipated_error = self.step.dissipated_error.or(change);
                let by_half = end.1.worn;
                self.step.worn_error = Some([0, 1].map(|face| OF_A_LOSS * (worn[face] - by_half[face]).abs()));
                Ok(Some(end))
            }
            Err(error @ SolveError::Interrupted { .. }) => Err(error),
            // The step itself was solved.
            Err(_) => Ok(None),
        }
    }

    /// Returns true if increments are solved less exactly than the end of the step.
    fn is_rough(&self) -> bool {
        self.increments_to > self.budget.tolerance
    }

    /// Returns true if this number of increments can be made.
    fn can_make(&self, increments: u64) -> bool {
        increments <= self.allowance
    }

    /// Solves the last increment of a step from `start` to the tolerance of the path.
    fn finish(
        &mut self,
        made: Divided<P::State>,
        start: Option<&P::State>,
        drive: Drive,
    ) -> Result<Divided<P::State>, SolveError<P::State>> {
        if !self.is_rough() {
            return Ok(made);
        }
        let before = made.before.as_ref().map(|(state, _)| state).or(start);
        let solved = self.problem.polish(drive, self.solver, &self.budget, (before, &made.end.0), &mut *self.watch)?;
        let end = self.read(solved);
        let losses = made.losses.without(made.end.1.losses).and(end.1.losses);
        let imbalance = made.imbalance - made.end.1.imbalance() + end.1.imbalance();
        Ok(Divided { end, losses, imbalance, ..made })
    }

    /// Makes a step in `increments` equal increments.
    fn in_increments(
        &mut self,
        start: Option<&P::State>,
        begin: &Reading,
        drive: Drive,
        increments: u64,
    ) -> Result<Divided<P::State>, SolveError<P::State>> {
        let mut before: Option<SolvedState<P::State>> = None;
        let (mut losses, mut imbalance) = (Losses::default(), 0.0);
        let part = 1.0 / increments as f64;
        for increment in 1..increments {
            let drive = begin.towards(drive, increment as f64 / increments as f64);
            let reached = self.increment(drive, before.as_ref().map_or(start, |(state, _)| Some(state)), part)?;
            losses = losses.and(reached.1.losses);
            imbalance += reached.1.imbalance();
            before = Some(reached);
        }
        let end = self.increment(drive, before.as_ref().map_or(start, |(state, _)| Some(state)), part)?;
        losses = losses.and(end.1.losses);
        imbalance += end.1.imbalance();
        Ok(Divided { before, end, losses, imbalance })
    }

    /// Divides the last increment of a step in two; the second part is the fraction `last` of the step.
    fn halve_last(
        &mut self,
        made: &Divided<P::State>,
        begin: &Reading,
        drive: Drive,
        last: f64,
    ) -> Result<Divided<P::State>, SolveError<P::State>> {
        let before = made.before.as_ref().map(|(state, _)| state);
        let middle = self.increment(begin.towards(drive, 1.0 - last), before, last)?;
        let end = self.increment(drive, Some(&middle.0), last)?;
        let losses = made.losses.without(made.end.1.losses).and(middle.1.losses).and(end.1.losses);
        Ok(Divided { before: Some(middle), end, losses, imbalance: made.imbalance })
    }

    /// Finds the equilibrium state under `drive` by an extra solve of an increment, a `part` of the step.
    fn increment(
        &mut self,
        drive: Drive,
        start: Option<&P::State>,
        part: f64,
    ) -> Result<SolvedState<P::State>, SolveError<P::State>> {
        let to = self.increments_to * (part / LONG_PART).min(1.0);
        self.extra(drive, start, to.max(self.budget.tolerance))
    }

    /// Finds the equilibrium state under `drive` by an extra solve.
    fn further(
        &mut self,
        drive: Drive,
        start: Option<&P::State>,
    ) -> Result<SolvedState<P::State>, SolveError<P::State>> {
        self.extra(drive, start, self.budget.tolerance)
    }

    fn extra(
        &mut self,
        drive: Drive,
        start: Option<&P::State>,
        tolerance: f64,
    ) -> Result<SolvedState<P::State>, SolveError<P::State>> {
        self.step.extra_solves += 1;
        self.allowance = self.allowance.saturating_sub(1);
        self.rest(drive, start, tolerance)
    }

    /// Moves `here` to `end` piece by piece and sums the losses of the pieces, to the tolerance times the `reference`
    /// work.
    fn account(
        &mut self,
        here: &mut StepPoint<P::State>,
        end: StepPoint<P::State>,
        drive: Drive,
        reference: f64,
    ) -> Result<(), SolveError<P::State>> {
        let begin = here.reading;
        // Forces are known to the tolerance of the search: their work over a motion without resistance is no loss.
        let hidden = self.budget.tolerance * Balance::between(&begin, &end.reading).largest;
        let allowed = (self.tolerance * reference).max(hidden);
        let extra = |search: &mut Self, share: f64, start: &StepPoint<P::State>| {
            let (state, reading) = search.further(begin.towards(drive, share), Some(&start.state))?;
            Ok::<_, SolveError<P::State>>(StepPoint { state, reading, share, origin: start.share })
        };
        let (mut lost, mut uncertain) = (0.0, 0.0);
        let (mut jumped, mut is_known) = (false, true);
        // Below this allowance, pieces are not divided for different halves alone; the difference is then their error.
        let enough = self.allowance - self.allowance / IN_ADVANCE;
        // End of the last piece that was divided although it balanced.
        let mut balanced = 0.0;
        // Ends of the next one or two pieces, in reverse order.
        let mut ahead = vec![end];
        while here.share < 1.0 {
            let mut end = match ahead.pop() {
                Some(end) => end,
                None => extra(self, 1.0, here)?,
            };
            let span = end.share - here.share;
            let chord = Balance::between(&here.reading, &end.reading);
            let mut piece = (chord.missing, chord.spread + chord.missing.abs());
            if piece.1 > allowed * span && span > SHORTEST && self.allowance > 0 {
                match extra(self, here.share + 0.5 * span, here) {
                    Err(error @ SolveError::Interrupted { .. }) => return Err(error),
                    // The solver may not converge close to an instability; the piece is then not divided.
                    Err(_) => {}
                    Ok(middle) => {
                        let mut halves = Halves::new(&here.reading, &middle.reading, &end.reading);
                        let balances = |halves: &Halves| halves.simpson().abs() <= allowed * span;
                        let is_part = end.share <= balanced;
                        let is_alike = |halves: &Halves| is_part || halves.unlikeness <= allowed * span;
                        let is_late = self.allowance < enough;
                        let closes = |halves: &Halves| balances(halves) && (is_late || is_alike(halves));
                        // The ends of a piece do not show a force that rises and falls within it; the work of this
                        // force is of second order in the length of the piece.
                        let enclosed = |halves: &Halves| halves.spread + reference * span * span;
                        let encloses = |halves: &Halves| enclosed(halves) <= OF_A_JUMP * allowed;
                        if encloses(&halves) && !closes(&halves) {
                            // States found from a state before the jump are not valid after it.
                            ahead.clear();
                            if end.origin < here.share {
                                end = extra(self, end.share, &middle)?;
                                halves = Halves::new(&here.reading, &middle.reading, &end.reading);
                            }
                        }
                        piece = if closes(&halves) {
                            // Without a loss, the difference of work and energy is the error of the work.
                            let error = if is_alike(&halves) { 0.0 } else { halves.unlikeness };
                            (halves.simpson(), halves.simpson().abs().max(error))
                        } else if encloses(&halves) {
                            (halves.missing, enclosed(&halves))
                        } else if self.allowance < RESERVE {
                            (halves.missing, halves.error_estimate())
                        } else {
                            balanced = if balances(&halves) { end.share } else { 0.0 };
                            ahead.clear();
                            ahead.extend([end, middle]);
                            continue;
                        };
                    }
                }
            }
            lost += piece.0;
            uncertain += piece.1;
            jumped |= piece.0 > piece.1;
            is_known &= piece.0 > piece.1 || piece.1 <= allowed * span.max(OF_A_JUMP);
            *here = end;
        }
        (self.step.dissipated, self.step.dissipated_error) = (Some(lost), Some(uncertain));
        self.step.losses = Losses { jumps: lost, ..Losses::default() };
        self.step.jumped = (jumped || is_known).then_some(jumped);
        Ok(())
    }
}

/// Balance of work and energy between two states, per area.
#[derive(Clone, Copy, Debug, Default)]
struct Balance {
    /// Trapezoidal work minus the energy gained.
    missing: f64,
    /// Largest error of this work if the forces change monotonically, jumps included.
    spread: f64,
    /// Magnitude of the work.
    exchanged: f64,
    /// Largest force times the whole motion.
    largest: f64,
}

impl Balance {
    fn between(from: &Reading, to: &Reading) -> Self {
        let works = |r: &Reading| {
            [(r.mean_pressure, r.approach), (r.mean_shear[0], r.lateral[0]), (r.mean_shear[1], r.lateral[1])]
        };
        let stored = |r: &Reading| match r.loss {
            Loss::Balance(energy) | Loss::Certified { stored: Some(energy), .. } => energy,
            _ => f64::NAN,
        };
        let mut balance = Self { missing: stored(from) - stored(to), ..Self::default() };
        let (mut strongest, mut whole) = (0.0_f64, 0.0);
        for ((force, place), (next_force, next_place)) in works(from).into_iter().zip(works(to)) {
            let moved = next_place - place;
            balance.missing += 0.5 * (force + next_force) * moved;
            balance.spread += 0.5 * ((next_force - force) * moved).abs();
            balance.exchanged += 0.5 * (force.abs() + next_force.abs()) * moved.abs();
            strongest = strongest.max(force.abs()).max(next_force.abs());
            whole += moved.abs();
        }
        Self { largest: strongest * whole, ..balance }
    }
}

/// Balance of work and energy over a piece of a path, from its ends and its middle.
struct Halves {
    /// Trapezoidal work over the halves minus the energy gained.
    missing: f64,
    /// Largest error of this work if the forces change monotonically in each half.
    spread: f64,
    /// Difference of `missing` from its value for the undivided piece.
    change: f64,
    /// Magnitude of the difference of `missing` between the halves. Where small jumps lose energy, the balance by
    /// Simpson's rule can close by chance; the halves then differ.
    unlikeness: f64,
}

impl Halves {
    fn new(from: &Reading, middle: &Reading, to: &Reading) -> Self {
        let [first, second] = [Balance::between(from, middle), Balance::between(middle, to)];
        let missing = first.missing + second.missing;
        let change = missing - Balance::between(from, to).missing;
        let unlikeness = (first.missing - second.missing).abs();
        Self { missing, spread: first.spread + second.spread, change, unlikeness }
    }

    /// Returns the work by Simpson's rule minus the energy gained.
    fn simpson(&self) -> f64 {
        self.missing + self.change / 3.0
    }

    /// Estimates the error of `missing`: its magnitude if no energy was lost, its change if a jump lies in one half.
    /// Energy is never gained, so that a negative `missing` shows that the forces are not monotonic.
    fn error_estimate(&self) -> f64 {
        match self.missing < 0.0 {
            true => self.spread - self.missing,
            false => self.spread.min(self.missing.max(self.change.abs())),
        }
    }
}

impl Quasistatic for Interface {
    fn reading(&self, state: &State) -> Reading {
        Reading {
            mean_pressure: state.mean_pressure,
            approach: state.approach,
            mean_shear: state.mean_shear,
            lateral: state.lateral,
            loss: match self.has_energy() {
                true if !self.attracts() => Loss::Conserved,
                true => Loss::Balance(state.elastic_energy + state.interface_energy),
                false => Loss::Unknown,
            },
            ..Reading::UNLOADED
        }
    }
}
