//! Problem requested by the flags: facts that decide which options combine, and rules that need numbers.

use gfmd_contact::{Contact, Solver};
use gfmd_law::LawKind;
use gfmd_problem::{Facts, key};

use super::Args;
use gfmd_input::failure::Failure;
use gfmd_run::series::Asked;

impl Args {
    /// Returns the facts of the series, without the parts of the contact.
    pub(super) fn series(&self) -> Facts {
        Facts {
            approach: self.control.is_approach(),
            flow_threshold: self.flow_threshold,
            history: self.trace.is_wanted(),
            resume: self.resume.resume,
            ..self.measure.of(self.problem.series())
        }
    }

    /// Returns the parts that the flags request.
    ///
    /// # Errors
    /// Returns an error for numbers that cannot be used.
    pub(super) fn asked(&self) -> Result<Asked<'_>, Failure> {
        self.measure.asked(self.problem.asked()?)
    }

    /// Checks that a recorded search has a single load.
    pub(super) fn check_history(&self) -> Result<(), Failure> {
        let loads = self.control.given_values().len();
        if self.trace.is_wanted() && loads > 1 {
            return Err(Failure::input(key("history"), format!("{loads} loads; it records the search for one load")));
        }
        Ok(())
    }

    /// Checks that several processes can share the solver.
    pub(super) fn check_solver_of_several(&self) -> Result<(), Failure> {
        let solver = self.problem.solver.solver;
        let allowed: &[Solver] = match self.problem.law.law {
            LawKind::HardWall => &Contact::FREE_SOLVERS,
            _ => &[Solver::Auto, Solver::Newton],
        };
        if allowed.contains(&solver) {
            return Ok(());
        }
        let names: Vec<&str> = allowed.iter().copied().map(Solver::name).collect();
        Err(Failure::value(key("solver"), solver, format!("one of {} with several processes", names.join(", "))))
    }
}
