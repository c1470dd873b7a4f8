//! The flags of a search: method, tolerance and iteration limit.

use clap::Args;
use gfmd_contact::{Budget, Solver};
use serde::{Deserialize, Serialize};

use super::choice::{named, parse_choice};
use crate::options::Options;

/// Flags of a contact solver.
#[derive(Args, Options, Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Solver")]
pub struct SolverArgs {
    /// Solution method (docs/solvers.md)
    #[arg(long, value_parser = parse_choice::<Solver>(), default_value_t = Solver::Auto)]
    #[serde(with = "named")]
    pub solver: Solver,
    /// The end of the search.
    #[command(flatten)]
    #[serde(flatten)]
    pub search: SearchArgs,
}

/// Flags of the end of a search for one state.
#[derive(Args, Options, Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Solver")]
pub struct SearchArgs {
    /// Largest residual of a converged state
    #[arg(long, alias = "tol", default_value_t = 1e-8, value_name = "TOL", allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Largest number of iterations or time steps per state
    #[arg(long, alias = "max-iter", default_value_t = 100_000, value_name = "N")]
    max_iterations: u64,
}

impl SearchArgs {
    /// Returns the tolerance and the iteration limit.
    pub fn budget(&self) -> Budget {
        Budget { tolerance: self.tolerance, max_iterations: self.max_iterations }
    }
}
