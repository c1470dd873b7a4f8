//! The method that solves a contact, its tolerance and its patience, as flags.

use clap::{Args, ValueEnum};
use gfmd_contact::{Budget, Solver};
use serde::Serialize;

/// How to solve.
#[derive(Args, Clone, Copy, Debug, Serialize)]
pub struct SolverArgs {
    /// The method (docs/solvers.md)
    #[arg(long, value_enum, default_value_t = SolverName::Auto)]
    pub solver: SolverName,
    /// Largest residual of a converged state
    #[arg(long, default_value_t = 1e-8, value_name = "TOL", allow_negative_numbers = true)]
    pub tol: f64,
    /// Iterations, or time steps, after which a load is given up
    #[arg(long, default_value_t = 100_000, value_name = "N")]
    pub max_iter: u64,
}

/// The names of the methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverName {
    /// The fastest that is safe
    Auto,
    /// Polonsky-Keer constrained conjugate gradients
    Cg,
    /// Conjugate gradients without restarts
    ProjectedCg,
    /// The same, preconditioned on the contact
    PreconditionedCg,
    /// Position Verlet with the best scalar damping
    Verlet,
    /// Position Verlet with the softest mode critically damped
    VerletCritical,
    /// Fast inertial relaxation engine
    Fire,
    /// The same, version 2.0
    Fire2,
    /// Dynamics with inertia that follows the stiffness
    AugmentedLagrangian,
}

impl From<SolverName> for Solver {
    fn from(name: SolverName) -> Self {
        match name {
            SolverName::Auto => Self::Auto,
            SolverName::Cg => Self::PolonskyKeer,
            SolverName::ProjectedCg => Self::ProjectedCg,
            SolverName::PreconditionedCg => Self::PreconditionedCg,
            SolverName::Verlet => Self::Verlet,
            SolverName::VerletCritical => Self::VerletCritical,
            SolverName::Fire => Self::Fire,
            SolverName::Fire2 => Self::Fire2,
            SolverName::AugmentedLagrangian => Self::AugmentedLagrangian,
        }
    }
}

impl SolverArgs {
    /// Tolerance and iterations.
    pub fn budget(&self) -> Budget {
        Budget { tolerance: self.tol, max_iterations: self.max_iter }
    }
}
