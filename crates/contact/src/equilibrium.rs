use gfmd_relax::{Budget, Watch};

use crate::{Drive, Fields, Refusal, SolveError, Solver};

/// Contact that can be brought to rest under a load: with a hard wall, an adhesive or cohesive law, or friction.
pub trait Equilibrium {
    /// State at rest.
    type State: Fields;

    /// Returns the solvers for this kind of contact.
    fn solvers(&self) -> &'static [Solver];

    /// Checks that a drive is valid.
    ///
    /// # Errors
    /// An invalid drive.
    fn check(&self, drive: Drive) -> Result<(), Refusal>;

    /// Checks that a valid drive can be solved to `tolerance`: neither so small that squares vanish, nor so large that
    /// rounding errors exceed the tolerance.
    ///
    /// # Errors
    /// A load or an approach that is too small or too large.
    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal>;

    /// Brings the contact to rest. `start` is the state to start from, such as the state of a smaller load.
    /// [`press`](Self::press) calls this method, with defaults for most arguments.
    ///
    /// # Errors
    /// [`SolveError::Refused`] for invalid input; otherwise an error that contains the state reached.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&Self::State>,
        watch: &mut dyn Watch,
    ) -> Result<Self::State, SolveError<Self::State>>;

    /// Prepares a solve under `drive`, to be configured and [run](Press::solve).
    fn press(&self, drive: impl Into<Drive>) -> Press<'_, Self>
    where
        Self: Sized,
    {
        Press::new(self, drive.into())
    }
}

impl<E: Equilibrium + ?Sized> Equilibrium for Box<E> {
    type State = E::State;

    fn solvers(&self) -> &'static [Solver] {
        (**self).solvers()
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        (**self).check(drive)
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        (**self).check_resolution(drive, tolerance)
    }

    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&Self::State>,
        watch: &mut dyn Watch,
    ) -> Result<Self::State, SolveError<Self::State>> {
        (**self).equilibrate(drive, solver, budget, start, watch)
    }
}

/// Solve of one [`Equilibrium`], made by [`Equilibrium::press`]. The defaults are [`Solver::Auto`], a tolerance of
/// 1e-8, no start and no watcher.
#[must_use = "nothing is solved before `solve`"]
pub struct Press<'a, E: Equilibrium> {
    contact: &'a E,
    drive: Drive,
    solver: Solver,
    budget: Budget,
    start: Option<&'a E::State>,
    watch: Option<&'a mut dyn Watch>,
}

impl<'a, E: Equilibrium> Press<'a, E> {
    fn new(contact: &'a E, drive: Drive) -> Self {
        Self { contact, drive, solver: Solver::Auto, budget: Budget::default(), start: None, watch: None }
    }

    /// Sets the largest allowed residual, 1e-8 by default.
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.budget.tolerance = tolerance;
        self
    }

    /// Sets the largest number of iterations or time steps, 100 000 by default.
    pub fn max_iterations(mut self, max_iterations: u64) -> Self {
        self.budget.max_iterations = max_iterations;
        self
    }

    /// Sets the tolerance and the largest number of iterations.
    pub fn budget(mut self, budget: Budget) -> Self {
        self.budget = budget;
        self
    }

    /// Sets the method, [`Solver::Auto`] by default.
    pub fn solver(mut self, solver: Solver) -> Self {
        self.solver = solver;
        self
    }

    /// Sets the state to start from, such as the state of a smaller load.
    pub fn starting_from(mut self, start: Option<&'a E::State>) -> Self {
        self.start = start;
        self
    }

    /// Sets a watcher, which is called in every iteration and may ask to stop.
    pub fn watch(mut self, watch: &'a mut dyn Watch) -> Self {
        self.watch = Some(watch);
        self
    }

    /// Brings the contact to rest. Calls inside `rayon::scope` are a tenth faster on grids of 64² to 1024² points.
    ///
    /// # Errors
    /// [`SolveError::Refused`] for invalid input; otherwise an error that contains the state reached.
    pub fn solve(self) -> Result<E::State, SolveError<E::State>> {
        let Self { contact, drive, solver, budget, start, watch } = self;
        contact.equilibrate(drive, solver, &budget, start, watch.unwrap_or(&mut ()))
    }
}
