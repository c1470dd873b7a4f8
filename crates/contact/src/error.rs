use gfmd_field::ShapeError;

use crate::{Residual, Solution};

/// Why a contact problem cannot be posed or was not solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ContactError {
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
    /// Heights that do not vary: every pressure closes the gap at once and no residual has a scale.
    #[error("the heights are all equal to {value}; a contact needs a surface that varies")]
    Flat {
        /// The common height.
        value: f64,
    },
    /// A load that does not press.
    #[error("the mean pressure is {found}; it must be positive and finite")]
    MeanPressure {
        /// What was asked.
        found: f64,
    },
    /// An approach that does not touch, or that no pressure can reach.
    #[error("the approach is {found}; it must be positive (first touch is 0){}", limit_text(*limit))]
    Approach {
        /// What was asked.
        found: f64,
        /// Where the mean surface would have to be compressed: on a half-space, or an incompressible slab, the approach
        /// stays below the mean clearance.
        limit: Option<f64>,
    },
    /// A tolerance outside 1e-15 … 0.1.
    #[error("the tolerance is {found:e}; allowed are 1e-15 to 0.1")]
    Tolerance {
        /// What was asked.
        found: f64,
    },
    /// A starting pressure that cannot be used.
    #[error("unusable starting pressure: {reason}")]
    Start {
        /// What is wrong with it.
        reason: String,
    },
    /// The residuals did not fall to the tolerance. The state reached is kept.
    #[error("not converged after {} iterations ({reason}): {}, asked {asked:e}", solution.iterations, solution.residual)]
    NotConverged {
        /// The state reached, with its residuals.
        solution: Box<Solution>,
        /// The tolerance.
        asked: f64,
        /// What ended the search.
        reason: String,
    },
    /// The observer asked to stop. The state reached is kept.
    #[error("interrupted after {} iterations: {}", solution.iterations, solution.residual)]
    Interrupted {
        /// The state reached, with its residuals.
        solution: Box<Solution>,
    },
    /// A field of the wrong length.
    #[error(transparent)]
    Field(#[from] ShapeError),
}

fn limit_text(limit: Option<f64>) -> String {
    limit.map_or_else(String::new, |limit| {
        format!(" and less than the mean clearance {limit}, where this body would be in full contact")
    })
}

impl std::fmt::Display for Residual {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "complementarity {:.2e}, penetration {:.2e}, negative pressure {:.2e}, load {:.2e}",
            self.complementarity, self.penetration, self.negative_pressure, self.load
        )
    }
}
