use gfmd_relax::Why;

use crate::Heated;

/// Error of a flash temperature computation.
#[derive(Debug, thiserror::Error)]
pub enum HeatError {
    /// Conductivity that is not positive and finite.
    #[error("the conductivity is {0}; it must be positive and finite")]
    Conductivity(f64),
    /// Diffusivity that is not positive and finite.
    #[error("the diffusivity is {0}; it must be positive and finite")]
    Diffusivity(f64),
    /// Velocity that is not finite.
    #[error("the velocity is {0:?}; it must be finite")]
    Velocity([f64; 2]),
    /// Field with a different number of points than the grid.
    #[error("the heat flux has {found} points; it must have {expected}, as the grid")]
    Points {
        /// Number of points of the field.
        found: usize,
        /// Number of points of the grid.
        expected: usize,
    },
    /// Negative or non-finite heat flux.
    #[error("the heat flux is {0} at a point; it must be at least 0 and finite")]
    Flux(f64),
    /// Tolerance out of range.
    #[error(transparent)]
    Tolerance(#[from] gfmd_relax::ToleranceError),
    /// Temperatures of the two bodies that differ by more than the tolerance.
    #[error(
        "the temperatures differ by {residual:e} of the largest rise, more than the tolerance {tolerance:e}: {why}"
    )]
    NotConverged {
        /// Relative difference; see [`Heated::residual`].
        residual: f64,
        /// Requested tolerance.
        tolerance: f64,
        /// Reason for the failure.
        why: Why,
        /// State reached.
        state: Box<Heated>,
    },
    /// Search interrupted by its [`Watch`](crate::Watch).
    #[error("interrupted")]
    Interrupted {
        /// State reached.
        state: Box<Heated>,
    },
}

impl HeatError {
    /// Returns the state reached, if the error carries one.
    pub fn into_state(self) -> Option<Heated> {
        match self {
            Self::NotConverged { state, .. } | Self::Interrupted { state } => Some(*state),
            _ => None,
        }
    }
}
