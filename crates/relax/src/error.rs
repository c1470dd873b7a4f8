//! What can go wrong, with what was found and what is allowed.

use crate::{Status, Stop};

/// Why a relaxation did not start or did not end well. The state stays with the caller in every case.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RelaxError {
    /// A vector does not fit the problem.
    #[error("{what} have {found} entries, the problem has {allowed}")]
    Length {
        /// Which vector.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length of the problem.
        allowed: usize,
    },
    /// A bound is NaN, or a lower bound exceeds its upper one.
    #[error("entry {index} must lie between {lower:e} and {upper:e}, which no value does")]
    Bounds {
        /// Which entry.
        index: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// A non-negative variable starts negative, infinite or as NaN.
    #[error("variable {index} starts at {found:e}; it must be finite and not negative")]
    Start {
        /// Index of the variable.
        index: usize,
        /// Its value.
        found: f64,
    },
    /// Every variable starts at zero although their mean is prescribed.
    #[error("every variable starts at zero; where the mean is prescribed one of them must be positive")]
    AllZero,
    /// A parameter of a method has no meaning.
    #[error("{name} is {found:e}, allowed is {allowed}")]
    Parameter {
        /// Which parameter.
        name: &'static str,
        /// Its value.
        found: f64,
        /// The values that make sense.
        allowed: &'static str,
    },
    /// The time step is beyond the stability limit (theory.md, section 6.1).
    #[error("the time step {found:e} is unstable, allowed is less than {allowed:e}")]
    TimeStep {
        /// The time step asked for.
        found: f64,
        /// The stability limit.
        allowed: f64,
    },
    /// The steps ran out.
    #[error(
        "not converged after {} steps: residual {:e} (asked {:e}), active bounds unchanged for {} steps (asked {})",
        reached.step, reached.residual, asked.residual, reached.settled, asked.settled
    )]
    NotConverged {
        /// Where the run ended.
        reached: Status,
        /// What was asked.
        asked: Stop,
    },
    /// The run moves away from any solution.
    #[error(
        "diverged at step {}: {reason}; the method is stable up to a stiffness of {stable_up_to:e}, \
         is the problem stiffer?", reached.step
    )]
    Diverged {
        /// Where the run ended.
        reached: Status,
        /// The sign of it.
        reason: Divergence,
        /// Largest stiffness (per mass) that the method can handle with its parameters.
        stable_up_to: f64,
    },
    /// Every step for a long time went uphill (FIRE).
    #[error("{found} steps in a row went uphill, allowed are {allowed}; residual {:e}", reached.residual)]
    Uphill {
        /// Where the run ended.
        reached: Status,
        /// Steps uphill.
        found: u32,
        /// As many as the method puts up with.
        allowed: u32,
    },
    /// An observer could not do its work.
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

/// How a divergence shows.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Divergence {
    /// Displacement, energy or residual is infinite or not a number.
    #[error("displacement, energy or residual is not finite")]
    NotFinite,
    /// The energy is far above its scale at the start.
    #[error("the energy is {found:e}, allowed is {allowed:e}")]
    Energy {
        /// The energy.
        found: f64,
        /// The limit.
        allowed: f64,
    },
}
