use gfmd_law::LawError;

use crate::{FrictionState, Residual, State};

/// Why an interface cannot be posed or was not brought to rest.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InterfaceError {
    /// Heights on another grid than the elastic response.
    #[error("the heights are {found:?} points, the elastic surface has {expected:?}")]
    Shape {
        /// Shape of the heights.
        found: [usize; 2],
        /// Shape of the grid.
        expected: [usize; 2],
    },
    /// A height that is NaN or infinite.
    #[error("the height at {index:?} is {value}; heights must be finite")]
    Height {
        /// Where, `[i, j]`.
        index: [usize; 2],
        /// What.
        value: f64,
    },
    /// A law whose traction is not the gradient of an energy.
    #[error("this law has no energy with these parameters; the Newton method needs one, dynamics does not")]
    NoEnergy,
    /// A mean that is held while points are held back at a wall.
    #[error(
        "dynamics cannot hold the mean of a half-space at a wall; prescribe the mean pressure, or use Newton's method"
    )]
    NoDynamics,
    /// A load, approach or lateral displacement that is not a finite number.
    #[error("the {what} is {found}; it must be finite")]
    Drive {
        /// Which.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// An approach at which the mean of the surface would have to be compressed.
    #[error("the approach is {found}; this body would be in full contact at the mean clearance {limit}")]
    Approach {
        /// What was asked.
        found: f64,
        /// The mean clearance.
        limit: f64,
    },
    /// A tolerance outside 1e-14 … 0.1.
    #[error("the tolerance is {found:e}; allowed are 1e-14 to 0.1")]
    Tolerance {
        /// What was asked.
        found: f64,
    },
    /// A state to start from on another grid, or with other components.
    #[error("the state to start from has {found} values of displacement, {expected} are needed")]
    Start {
        /// Its length.
        found: usize,
        /// That of this problem.
        expected: usize,
    },
    /// Nothing holds the surfaces together against the pull. The last state on the way is kept.
    #[error("the surfaces part under a mean pressure of {mean_pressure}: the attraction cannot balance the pull")]
    Detached {
        /// The mean pressure asked for, negative.
        mean_pressure: f64,
        /// A state on the way apart.
        state: Box<State>,
    },
    /// The residuals did not fall to the tolerance. The state reached is kept.
    #[error("not converged after {} iterations ({reason}): {}, asked {asked:e}", state.iterations, state.residual)]
    NotConverged {
        /// The state reached, with its residuals.
        state: Box<State>,
        /// The tolerance.
        asked: f64,
        /// What ended the search.
        reason: &'static str,
    },
    /// A frictional contact whose residuals did not fall to the tolerance. The state reached is kept.
    #[error("not converged after {} iterations ({reason}): {}, asked {asked:e}", state.iterations, state.residual)]
    FrictionNotConverged {
        /// The state reached, with its residuals.
        state: Box<FrictionState>,
        /// The tolerance.
        asked: f64,
        /// What ended the search.
        reason: &'static str,
    },
    /// The observer of a frictional contact asked to stop. The state reached is kept.
    #[error("interrupted after {} iterations: {}", state.iterations, state.residual)]
    FrictionInterrupted {
        /// The state reached, with its residuals.
        state: Box<FrictionState>,
    },
    /// Friction without contact.
    #[error("the {what} is {found}; friction needs contact, it must be positive")]
    NotPressed {
        /// Mean pressure or approach.
        what: &'static str,
        /// What was asked.
        found: f64,
    },
    /// Heights that do not vary.
    #[error("the heights are all equal; a contact needs a surface that varies")]
    Flat,
    /// Parameters that make no law.
    #[error(transparent)]
    Law(LawError),
    /// The observer asked to stop. The state reached is kept.
    #[error("interrupted after {} iterations: {}", state.iterations, state.residual)]
    Interrupted {
        /// The state reached, with its residuals.
        state: Box<State>,
    },
}

impl InterfaceError {
    /// Whether the observer asked to stop.
    pub(crate) fn is_interruption(&self) -> bool {
        matches!(self, Self::Interrupted { .. } | Self::FrictionInterrupted { .. })
    }
}

impl std::fmt::Display for Residual {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { equilibrium, penetration, wall_tension, load } = self;
        write!(
            f,
            "equilibrium {equilibrium:.2e}, penetration {penetration:.2e}, wall tension {wall_tension:.2e}, load {load:.2e}"
        )
    }
}
