//! The problem that the flags ask for: the facts that decide what goes together, and the rules that need numbers.

use gfmd_contact::{Contact, Factors, Solver};
use gfmd_problem::{Facts, Lower, MovedBase, Task, Unknown};

use super::Args;
use gfmd_problem::options::DampedBy;
use gfmd_problem::options::values::numbers;
use gfmd_run::failure::Failure;

impl Args {
    /// The facts of the contact, whose surface may be a `line`.
    pub(super) fn facts(&self, line: bool) -> Facts {
        Facts {
            task: Task::Loads,
            law: self.law.law,
            hardness: self.hardness.is_some(),
            friction: None,
            boundary: self.boundary,
            unknown: self.components,
            finite_slope: self.finite_slope,
            lower: match (&self.lower.lower_surface, self.lower.lower_seed) {
                (Some(_), _) => Some(Lower::Surface),
                (_, Some(_)) => Some(Lower::Seed),
                _ => None,
            },
            moved_base: match (&self.base.base_displacement, &self.base.base_traction) {
                (Some(_), _) => Some(MovedBase::Displacement),
                (_, Some(_)) => Some(MovedBase::Traction),
                _ => None,
            },
            line,
            approach: !self.control.displacement.is_empty(),
            lateral: false,
            statistics: self.statistics,
            flow: self.flow,
            flow_threshold: self.flow_threshold,
            history: self.trace.is_wanted(),
            resume: self.resume.resume,
            ..self.body.facts()
        }
    }

    /// Checks time step, damping and record of the dynamics.
    pub(super) fn check_dynamics(&self) -> Result<(), Failure> {
        self.dynamics.check(match self.solver.solver {
            Solver::VerletCritical => DampedBy::Numbers,
            Solver::VerletModes => DampedBy::Modes,
            _ => DampedBy::Other,
        })?;
        if let (Factors::Components(factors), true) = (self.dynamics.factors()?, self.components != Unknown::All) {
            return Err(Failure::value("--damping", format!("{factors:?}"), "one number without --components all"));
        }
        let loads: usize = self.control.given().into_iter().map(|(_, values)| numbers(values).count()).sum();
        if self.trace.is_wanted() && loads > 1 {
            return Err(Failure::Input(format!("--history: {loads} loads; it records the search for one load")));
        }
        Ok(())
    }

    /// Checks that several processes can share the method.
    pub(super) fn check_solver_of_several(&self) -> Result<(), Failure> {
        let solver = self.solver.solver;
        if Contact::FREE_SOLVERS.contains(&solver) {
            return Ok(());
        }
        let names: Vec<&str> = Contact::FREE_SOLVERS.iter().copied().map(Solver::name).collect();
        Err(Failure::value("--solver", solver, format!("one of {} with several processes", names.join(", "))))
    }
}
