use gfmd_relax::{Budget, Watch};

use crate::attempt::Attempt;
use crate::dual::{self, Gradients};
use crate::dynamics::{self, Motion};
use crate::{Contact, Drive, Effort, Equilibrium, Refusal, Solution, SolveError, Solver, judge};

impl Contact {
    /// The solvers for a hard wall: all except [`Solver::Newton`], which needs a law.
    pub const SOLVERS: [Solver; 9] = [
        Solver::Auto,
        Solver::PolonskyKeer,
        Solver::ProjectedCg,
        Solver::PreconditionedCg,
        Solver::Verlet,
        Solver::VerletCritical,
        Solver::Fire,
        Solver::Fire2,
        Solver::AugmentedLagrangian,
    ];
}

impl Equilibrium for Contact {
    type State = Solution;

    fn solvers(&self) -> &'static [Solver] {
        &Self::SOLVERS
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        self.check_load(drive.load)?;
        drive.check()
    }

    /// Starts from the pressure of `start`, scaled to the prescribed load, or from a uniform pressure.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&Solution>,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError<Solution>> {
        budget.check()?;
        self.check(drive)?;
        let start = start.map(|start| self.check_start(start.pressure.view())).transpose()?;
        let attempt =
            Attempt { contact: self, load: drive.load, budget: *budget, start, watch, effort: Effort::default() };
        let ended = match solver {
            Solver::Auto => dual::solve(attempt, Gradients::Auto)?,
            Solver::PolonskyKeer => dual::solve(attempt, Gradients::PolonskyKeer)?,
            Solver::ProjectedCg => dual::solve(attempt, Gradients::Projected)?,
            Solver::PreconditionedCg => dual::solve(attempt, Gradients::Preconditioned)?,
            Solver::Verlet => dynamics::solve(attempt, Motion::Verlet)?,
            Solver::VerletCritical => dynamics::solve(attempt, Motion::VerletCritical)?,
            Solver::Fire => dynamics::solve(attempt, Motion::Fire)?,
            Solver::Fire2 => dynamics::solve(attempt, Motion::Fire2)?,
            Solver::AugmentedLagrangian => dynamics::solve(attempt, Motion::AugmentedLagrangian)?,
            Solver::Newton => return Err(Refusal::Solver { found: solver, allowed: &Self::SOLVERS }.into()),
        };
        let mut solution = self.certified(ended.pressure, drive.load);
        solution.effort.iterations = ended.effort.iterations;
        solution.effort.transform_pairs += ended.effort.transform_pairs;
        judge(solution, ended.ending, budget.tolerance)
    }
}
