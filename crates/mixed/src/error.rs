use gfmd_relax::{RelaxError, ToleranceError, Why};

use crate::MixedSolution;

/// Reasons why a mixed problem cannot be posed or solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MixedError {
    /// A field on another grid, or with another number of components.
    #[error("the shape [component, x, y] of the {what} is {found:?}; it must be {expected:?}")]
    Shape {
        /// Name of the field.
        what: &'static str,
        /// Shape of the field.
        found: [usize; 3],
        /// Shape of the problem.
        expected: [usize; 3],
    },
    /// A prescribed value that is NaN or infinite.
    #[error("the value prescribed at [component, x, y] = {index:?} is {value}; it must be finite")]
    Value {
        /// Index of the entry.
        index: [usize; 3],
        /// Value of the entry.
        value: f64,
    },
    /// A problem without held points, which needs no solver: the compliance gives its displacement.
    #[error("no displacement is prescribed anywhere; at least one point must be held")]
    NothingHeld,
    /// A component held at every point, with an undetermined mean traction: a uniform traction moves nothing.
    #[error(
        "component {component} is held at every point; at least one point must be free, since a uniform traction along \
         this component does not move the body"
    )]
    Undetermined {
        /// Index of the component.
        component: usize,
    },
    /// A punch that does not fit into the cell.
    #[error("the punch width divided by the cell width is {0}; it must be above 0 and below 1")]
    Fraction(f64),
    /// A tolerance out of range.
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
    /// Numbers too large or too small for a method to start.
    #[error("the search cannot start: {0}")]
    Search(#[from] RelaxError),
    /// The residual did not fall to the tolerance. The state reached is kept.
    #[error(
        "not converged after {} iterations ({why}): residual {:.2e}, asked {asked:e}",
        solution.iterations,
        solution.residual
    )]
    NotConverged {
        /// State reached, with its residual.
        solution: Box<MixedSolution>,
        /// Tolerance.
        asked: f64,
        /// Reason why the search ended.
        why: Why,
    },
    /// The observer asked to stop. The state reached is kept.
    #[error("interrupted after {} iterations: residual {:.2e}", solution.iterations, solution.residual)]
    Interrupted {
        /// State reached, with its residual.
        solution: Box<MixedSolution>,
    },
}
