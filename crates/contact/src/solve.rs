use gfmd_relax::{Budget, Watch};

use crate::attempt::{Attempt, FoundPressure};
use crate::dual::{self, Gradients};
use crate::dynamics::{self, Motion};
use crate::refine::{coarsest, refine};
use crate::{Contact, Drive, Effort, Equilibrium, Load, Refusal, Solution, SolveError, Solver, Units, full, judge};

impl Contact {
    /// Solvers for a hard wall: all except [`Solver::Newton`], which needs a law.
    pub const SOLVERS: [Solver; 10] = [
        Solver::Auto,
        Solver::PolonskyKeer,
        Solver::ProjectedCg,
        Solver::PreconditionedCg,
        Solver::Verlet,
        Solver::VerletCritical,
        Solver::VerletModes,
        Solver::Fire,
        Solver::Fire2,
        Solver::AugmentedLagrangian,
    ];

    /// Solvers with a hardness: the methods that support two bounds.
    pub const HARDNESS_SOLVERS: [Solver; 2] = [Solver::Auto, Solver::PreconditionedCg];

    /// Solvers with free boundaries, with springs that differ between points, and of several processes: the methods
    /// that seek the pressure.
    pub const FREE_SOLVERS: [Solver; 4] =
        [Solver::Auto, Solver::PolonskyKeer, Solver::ProjectedCg, Solver::PreconditionedCg];
}

impl Equilibrium for Contact {
    type State = Solution;

    fn solvers(&self) -> &'static [Solver] {
        match (&self.hardness, &self.free) {
            _ if self.all_components.is_some() => &Self::ALL_COMPONENTS_SOLVERS,
            (Some(_), _) => &Self::HARDNESS_SOLVERS,
            (None, Some(_)) => &Self::FREE_SOLVERS,
            _ if self.springs.is_some() || !self.share.is_whole() => &Self::FREE_SOLVERS,
            (None, None) => &Self::SOLVERS,
        }
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        self.check_load(drive.load)?;
        drive.check()
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        let [softest, _] = match &self.all_components {
            Some(response) => response.stiffness_range(),
            None => self.response.stiffness_range(),
        };
        self.surface().check_resolution(drive.load, softest * self.units().stiffness(), tolerance)
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
        if !self.solvers().contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: self.solvers() }.into());
        }
        self.check(drive)?;
        self.check_resolution(drive, budget.tolerance)?;
        if let (Some(response), Load::MeanPressure(mean)) = (&self.all_components, drive.load) {
            return full::solve(self, response, (mean, solver), budget, start, watch);
        }
        let start = start.map(|start| self.check_start(start.pressure.view())).transpose()?;
        let load = self.units().drive(drive).load;
        let watch = &mut self.units().shown(watch);
        let coarsest = coarsest(self.length_scale(load), load, budget.tolerance);
        let (solution, ending) = refine(coarsest, budget, start, watch, |length_scale, budget, start, watch| {
            let attempt =
                Attempt { contact: self, load, length_scale, budget, start, watch, effort: Effort::default() };
            let ended = match solver {
                Solver::Auto => dual::solve(attempt, Gradients::Auto)?,
                Solver::PolonskyKeer => dual::solve(attempt, Gradients::PolonskyKeer)?,
                Solver::ProjectedCg => dual::solve(attempt, Gradients::Projected)?,
                Solver::PreconditionedCg => dual::solve(attempt, Gradients::Preconditioned)?,
                Solver::Verlet => dynamics::solve(attempt, Motion::Verlet)?,
                Solver::VerletCritical => dynamics::solve(attempt, Motion::VerletCritical)?,
                Solver::VerletModes => dynamics::solve(attempt, Motion::VerletModes)?,
                Solver::Fire => dynamics::solve(attempt, Motion::Fire)?,
                Solver::Fire2 => dynamics::solve(attempt, Motion::Fire2)?,
                Solver::AugmentedLagrangian => dynamics::solve(attempt, Motion::AugmentedLagrangian)?,
                Solver::Newton => return Err(Refusal::Solver { found: solver, allowed: self.solvers() }),
            };
            let FoundPressure { pressure, displacement } = ended.reached;
            let mut solution = match displacement {
                None => self.certified(pressure, load),
                Some(displacement) => {
                    let sinking = self.sinking(&pressure);
                    self.state_of((pressure, displacement), sinking, load)
                }
            };
            solution.effort.iterations = ended.effort.iterations;
            solution.effort.transform_pairs += ended.effort.transform_pairs;
            Ok((solution, ended.ending))
        })?;
        if solution.length_scale < coarsest {
            self.scaled.check_heights(drive.load, solution.length_scale, budget.tolerance)?;
        }
        let solution = self.given_units(solution);
        Units::check_pressure(solution.mean_pressure)?;
        if let Load::Approach(_) = load {
            let softest = self.response.stiffness_range()[0] * self.units().stiffness();
            let what = "mean pressure of this approach";
            self.surface().check_traction(what, solution.mean_pressure, softest, budget.tolerance)?;
        }
        judge(solution, ending, budget.tolerance)
    }
}
