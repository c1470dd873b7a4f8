use crate::Divergence;

/// Ending of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The tolerance is met.
    Converged,
    /// The watcher asked to stop.
    Interrupted,
    /// The tolerance is not met.
    GaveUp(Why),
}

/// Reason why a search was given up.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Why {
    /// The maximum number of iterations was reached.
    #[error("the iteration limit")]
    Iterations,
    /// The required residual of the method is below the rounding error.
    #[error("rounding keeps the recomputed residuals above the tolerance")]
    Rounding,
    /// The residuals recomputed from the final fields exceed the solver residuals.
    #[error("the recomputed residuals are larger than those of the solver")]
    Certificate,
    /// The function does not decrease, or has no curvature, along a search direction.
    #[error("no descent, or no curvature, along the search direction")]
    Direction,
    /// The function cannot decrease further in this precision.
    #[error("the function cannot be decreased any further in this precision")]
    NoDescent,
    /// The search returns to earlier points.
    #[error("the search returns to earlier points")]
    Circles,
    /// An intermediate problem, for example the contact with a displaced surface, has no solution.
    #[error("the contact of the displaced surface has no solution")]
    Displaced,
    /// A body yields in the lowest of its cells, and below it cannot.
    #[error("the lowest cell yields, and the body below it cannot")]
    LowestCell,
    /// Too many steps in a row went uphill.
    #[error("{found} steps in a row went uphill; at most {allowed} are allowed")]
    Uphill {
        /// Number of steps uphill.
        found: u32,
        /// Largest allowed number.
        allowed: u32,
    },
    /// The motion does not come to rest with any of the tried time steps.
    #[error("the motion does not settle")]
    Unsettled,
    /// The search diverged, or a value is not finite.
    #[error("diverged: {0}")]
    Diverged(Divergence),
}
