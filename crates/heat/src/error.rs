use gfmd_relax::Why;

use crate::Heated;

/// Error: heat without a temperature.
#[derive(Debug, thiserror::Error)]
pub enum HeatError {
    /// A conductivity that is not positive.
    #[error("the conductivity is {0}; it must be positive and finite")]
    Conductivity(f64),
    /// A diffusivity that is not positive.
    #[error("the diffusivity is {0}; it must be positive and finite")]
    Diffusivity(f64),
    /// A velocity that is not finite.
    #[error("the velocity is {0:?}; it must be finite")]
    Velocity([f64; 2]),
    /// A field of another size than the grid.
    #[error("the heat flux has {found} points; it must have {expected}, those of the grid")]
    Points {
        /// The number of points of the field.
        found: usize,
        /// The number of points of the grid.
        expected: usize,
    },
    /// A negative heat flux.
    #[error("the heat flux is {0} at a point; it must be at least 0 and finite")]
    Flux(f64),
    /// A tolerance that is out of range.
    #[error(transparent)]
    Tolerance(#[from] gfmd_relax::ToleranceError),
    /// Temperatures of the two bodies that differ by more than the tolerance.
    #[error(
        "the temperatures differ by {residual:e} of the largest rise, more than the tolerance {tolerance:e}: {why}"
    )]
    NotConverged {
        /// The difference.
        residual: f64,
        /// The tolerance.
        tolerance: f64,
        /// The reason.
        why: Why,
        /// The state reached.
        state: Box<Heated>,
    },
    /// A search that was told to stop.
    #[error("interrupted")]
    Interrupted {
        /// The state reached.
        state: Box<Heated>,
    },
}

impl HeatError {
    /// The state reached, if there is one.
    pub fn into_state(self) -> Option<Heated> {
        match self {
            Self::NotConverged { state, .. } | Self::Interrupted { state } => Some(*state),
            _ => None,
        }
    }
}
