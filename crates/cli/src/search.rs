//! Flags of the search for one state.

use clap::Args;
use gfmd_contact::Budget;
use gfmd_problem::options::Options;
use serde::{Deserialize, Serialize};

/// Flags of the search for one state of a series.
#[derive(Args, Options, Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Solver")]
pub(crate) struct SearchArgs {
    /// Largest residual of a converged state
    #[arg(long, alias = "tol", default_value_t = 1e-8, value_name = "TOL", allow_negative_numbers = true)]
    pub(crate) tolerance: f64,
    /// Largest number of iterations for one step
    #[arg(long, alias = "max-iter", default_value_t = 100_000, value_name = "N")]
    max_iterations: u64,
}

impl SearchArgs {
    pub(crate) fn budget(self) -> Budget {
        Budget { tolerance: self.tolerance, max_iterations: self.max_iterations }
    }
}
