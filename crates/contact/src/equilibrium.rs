use gfmd_relax::{Budget, Watch};

use crate::{Drive, Fields, Refusal, SolveError, Solver};

/// A contact that can be brought to rest under a load: with a hard wall, an adhesive or cohesive law, or friction.
pub trait Equilibrium {
    /// The state at rest.
    type State: Fields;

    /// The solvers that this kind of contact has.
    fn solvers(&self) -> &'static [Solver];

    /// Checks whether a drive can be posed.
    ///
    /// # Errors
    /// A drive that cannot.
    fn check(&self, drive: Drive) -> Result<(), Refusal>;

    /// Brings the contact to rest. `start` is the state to start from, such as that of a smaller load.
    /// [`press`](Self::press) is the comfortable way to call this.
    ///
    /// # Errors
    /// [`SolveError::Refused`] for unusable input; else an error that carries the state reached.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&Self::State>,
        watch: &mut dyn Watch,
    ) -> Result<Self::State, SolveError<Self::State>>;

    /// A solve under `drive`, to be configured and [run](Press::solve).
    fn press(&self, drive: impl Into<Drive>) -> Press<'_, Self>
    where
        Self: Sized,
    {
        Press::new(self, drive.into())
    }
}

/// A solve of one [`Equilibrium`], made by [`Equilibrium::press`]: [`Solver::Auto`] from scratch to 1e-8, in silence, unless
/// said otherwise.
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

    /// Residual to which every part must fall, 1e-8 by default.
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.budget.tolerance = tolerance;
        self
    }

    /// Iterations, or time steps, after which the search is given up; 100 000 by default.
    pub fn max_iterations(mut self, max_iterations: u64) -> Self {
        self.budget.max_iterations = max_iterations;
        self
    }

    /// Tolerance and iterations at once.
    pub fn budget(mut self, budget: Budget) -> Self {
        self.budget = budget;
        self
    }

    /// The method, [`Solver::Auto`] by default.
    pub fn solver(mut self, solver: Solver) -> Self {
        self.solver = solver;
        self
    }

    /// The state to start from, such as that of a smaller load.
    pub fn starting_from(mut self, start: Option<&'a E::State>) -> Self {
        self.start = start;
        self
    }

    /// A watcher, which sees every iteration and may ask to stop.
    pub fn watch(mut self, watch: &'a mut dyn Watch) -> Self {
        self.watch = Some(watch);
        self
    }

    /// Brings the contact to rest.
    ///
    /// # Errors
    /// [`SolveError::Refused`] for unusable input; else an error that carries the state reached.
    pub fn solve(self) -> Result<E::State, SolveError<E::State>> {
        let Self { contact, drive, solver, budget, start, watch } = self;
        contact.equilibrate(drive, solver, &budget, start, watch.unwrap_or(&mut ()))
    }
}
