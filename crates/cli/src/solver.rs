//! The flags of a contact solver: method, tolerance and iteration limit.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use gfmd_contact::{Budget, Solver};
use serde::{Serialize, Serializer};

/// Flags of a contact solver.
#[derive(Args, Clone, Copy, Debug, Serialize)]
pub struct SolverArgs {
    /// The method (docs/solvers.md)
    #[arg(long, value_parser = solvers(), default_value_t = Solver::Auto)]
    #[serde(serialize_with = "by_name")]
    pub solver: Solver,
    /// Largest residual of a converged state
    #[arg(long, default_value_t = 1e-8, value_name = "TOL", allow_negative_numbers = true)]
    pub tol: f64,
    /// Largest number of iterations, or time steps, for one load
    #[arg(long, default_value_t = 100_000, value_name = "N")]
    pub max_iter: u64,
}

impl SolverArgs {
    /// The tolerance and the iteration limit.
    pub fn budget(&self) -> Budget {
        Budget { tolerance: self.tol, max_iterations: self.max_iter }
    }
}

/// Parses the name of a solver; the help lists all names with their meanings.
pub fn solvers() -> impl TypedValueParser<Value = Solver> {
    let names = Solver::ALL.map(|solver| PossibleValue::new(solver.name()).help(solver.meaning()));
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Solver>())
}

fn by_name<S: Serializer>(solver: &Solver, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(solver.name())
}
