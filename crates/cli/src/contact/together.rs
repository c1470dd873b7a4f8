//! Problem requested by the flags: facts that decide which options combine, and rules that need numbers.

use gfmd_contact::{Contact, Solver};
use gfmd_problem::{Facts, SIZES, key, words};

use super::Args;
use gfmd_input::failure::Failure;
use gfmd_run::series::Asked;

impl Args {
    /// Returns the facts of the contact; `line` is true for a profile.
    pub(super) fn facts(&self, line: bool) -> Facts {
        Facts {
            approach: self.control.is_approach(),
            statistics: self.statistics,
            flow: self.flow,
            conducts: !self.conductivity.is_empty(),
            gas: self.gas.is_given(),
            leak: self.fluid.viscosity.is_some(),
            flow_threshold: self.flow_threshold,
            history: self.trace.is_wanted(),
            resume: self.resume.resume,
            ..self.problem.facts(line)
        }
    }

    /// Returns the parts that the flags request.
    ///
    /// # Errors
    /// Returns an error for numbers that cannot be used.
    pub(super) fn asked(&self) -> Result<Asked<'_>, Failure> {
        let (fluid, conductivity) = (self.fluid.fluid(self.flow)?, self.series_conductivity()?);
        Ok(Asked { fluid, conductivity, gas: self.gas.given()?, ..self.problem.asked()? })
    }

    /// Returns the conductivity of both conductors in series, 1/(1/k1 + 1/k2); `None` if it is not given.
    fn series_conductivity(&self) -> Result<Option<f64>, Failure> {
        let option = key("conductivity");
        match self.conductivity[..] {
            [] => Ok(None),
            _ if !self.statistics => {
                Err(Failure::value(option, "given", words!["left out without ", key("statistics")]))
            }
            [first, second] if [first, second].iter().all(|k| SIZES.contains(k)) => {
                Ok(Some(1.0 / (1.0 / first + 1.0 / second)))
            }
            [_, _] => Err(Failure::value(option, format!("{:?}", self.conductivity), "positive and finite")),
            _ => Err(Failure::value(option, format!("{:?}", self.conductivity), "two numbers, of both conductors")),
        }
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
        if Contact::FREE_SOLVERS.contains(&solver) {
            return Ok(());
        }
        let names: Vec<&str> = Contact::FREE_SOLVERS.iter().copied().map(Solver::name).collect();
        Err(Failure::value(key("solver"), solver, format!("one of {} with several processes", names.join(", "))))
    }
}
