use gfmd_relax::{RelaxError, ToleranceError, Why};

use crate::MixedSolution;

/// Why a mixed problem cannot be posed or was not solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MixedError {
    /// A field on another grid, or with another number of components.
    #[error("the {what} have {found:?} components and points along x and y, {expected:?} are needed")]
    Shape {
        /// Which field.
        what: &'static str,
        /// Its shape.
        found: [usize; 3],
        /// The shape of the problem.
        expected: [usize; 3],
    },
    /// A prescribed value that is NaN or infinite.
    #[error("the value prescribed at [component, x, y] = {index:?} is {value}; it must be finite")]
    Value {
        /// Where.
        index: [usize; 3],
        /// What.
        value: f64,
    },
    /// No point is held: a traction alone needs no solver, only the compliance.
    #[error("no displacement is prescribed anywhere; at least one point must be held")]
    NothingHeld,
    /// A component held at every point whose mean traction does nothing, so that it cannot be found.
    #[error(
        "component {component} is held at every point, but a uniform traction along it does not move this body: leave \
         at least one point free"
    )]
    Undetermined {
        /// The index of the component.
        component: usize,
    },
    /// A punch that does not fit into the cell.
    #[error("a punch takes a fraction of the cell between 0 and 1, both excluded; found {0}")]
    Fraction(f64),
    /// A tolerance out of range.
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
    /// Numbers so large or so small that no method can be set up.
    #[error("the search cannot start: {0}")]
    Search(#[from] RelaxError),
    /// The residual did not fall to the tolerance. The state reached is kept.
    #[error("not converged after {} iterations ({why}): residual {:.2e}, asked {asked:e}", solution.iterations, solution.residual)]
    NotConverged {
        /// The state reached, with its residual.
        solution: Box<MixedSolution>,
        /// The tolerance.
        asked: f64,
        /// The reason why the search ended.
        why: Why,
    },
    /// The observer asked to stop. The state reached is kept.
    #[error("interrupted after {} iterations: residual {:.2e}", solution.iterations, solution.residual)]
    Interrupted {
        /// The state reached, with its residual.
        solution: Box<MixedSolution>,
    },
}
