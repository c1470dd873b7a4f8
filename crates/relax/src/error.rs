//! Errors, with the found and the allowed values.

use crate::{Status, Stop};

/// Reason why a relaxation did not start or failed. The caller keeps the state in every case.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RelaxError {
    /// The length of a vector differs from the length of the problem.
    #[error("{what} have {found} entries; they must have {allowed}")]
    Length {
        /// Name of the vector.
        what: &'static str,
        /// Length of the vector.
        found: usize,
        /// Length of the problem.
        allowed: usize,
    },
    /// A bound is NaN, or a lower bound exceeds the upper bound.
    #[error("the bounds of entry {index} are {lower:e} and {upper:e}; the lower must be at most the upper")]
    Bounds {
        /// Index of the entry.
        index: usize,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// The start value of a non-negative variable is negative, infinite or NaN.
    #[error("variable {index} starts at {found:e}; it must be finite and not negative")]
    Start {
        /// Index of the variable.
        index: usize,
        /// Value found.
        found: f64,
    },
    /// Every variable starts at zero although the mean is prescribed.
    #[error("every variable starts at zero; at least one must be positive if the mean is prescribed")]
    AllZero,
    /// A parameter of a method is invalid.
    #[error("{name} is {found:e}; it must be {allowed}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value found.
        found: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// The time step is beyond the stability limit (theory.md, section 6.1).
    #[error("the time step is {found:e}; it must be less than {allowed:e} for stability")]
    TimeStep {
        /// Time step.
        found: f64,
        /// Stability limit.
        allowed: f64,
    },
    /// The maximum number of steps was reached.
    #[error(
        "not converged after {} steps: residual {:e} (asked {:e}), active bounds unchanged for {} steps (asked {})",
        reached.step, reached.residual, asked.residual, reached.settled, asked.settled
    )]
    NotConverged {
        /// Status at the end of the run.
        reached: Status,
        /// End criteria.
        asked: Stop,
    },
    /// The run diverges.
    #[error(
        "diverged at step {}: {reason}; the method is stable up to a stiffness of {stable_up_to:e}, \
         is the problem stiffer?", reached.step
    )]
    Diverged {
        /// Status at the end of the run.
        reached: Status,
        /// Criterion of the divergence.
        reason: Divergence,
        /// Largest stiffness per mass for which the method is stable with its parameters.
        stable_up_to: f64,
    },
    /// Too many steps in a row went uphill (FIRE).
    #[error("{found} steps in a row went uphill; at most {allowed} are allowed; residual {:e}", reached.residual)]
    Uphill {
        /// Status at the end of the run.
        reached: Status,
        /// Number of steps uphill.
        found: u32,
        /// Largest allowed number.
        allowed: u32,
    },
    /// An observer failed.
    #[error("an observer failed")]
    Observer(#[from] std::io::Error),
}

impl RelaxError {
    pub(crate) fn check_length(what: &'static str, found: usize, allowed: usize) -> Result<(), Self> {
        if found == allowed { Ok(()) } else { Err(Self::Length { what, found, allowed }) }
    }

    pub(crate) fn check_parameter(name: &'static str, found: f64, ok: bool, allowed: &'static str) -> Result<(), Self> {
        if ok { Ok(()) } else { Err(Self::Parameter { name, found, allowed }) }
    }
}

/// Criterion of a divergence.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Divergence {
    /// Displacement, energy or residual is infinite or NaN.
    #[error("displacement, energy or residual is not finite")]
    NotFinite,
    /// The energy is far above its scale at the start.
    #[error("the energy is {found:e}; it must be at most {allowed:e}")]
    Energy {
        /// Energy.
        found: f64,
        /// Energy limit.
        allowed: f64,
    },
}
