use crate::Divergence;

/// The way in which a search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The tolerance is met.
    Converged,
    /// The watcher asked to stop.
    Interrupted,
    /// The tolerance is not met.
    GaveUp(Why),
}

/// The reason why a search was given up.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Why {
    /// The limit of iterations was reached.
    #[error("the iteration limit")]
    Iterations,
    /// The target of the method would have to be below the rounding error.
    #[error("rounding keeps the recomputed residuals above the tolerance")]
    Rounding,
    /// The residuals recomputed from the final fields exceed the estimate of the method.
    #[error("the recomputed residuals are larger than those of the solver")]
    Certificate,
    /// The function does not decrease, or has no curvature, along a search direction.
    #[error("no descent, or no curvature, along the search direction")]
    Direction,
    /// The function cannot be decreased any further in this precision.
    #[error("the function cannot be decreased any further in this precision")]
    NoDescent,
    /// The search returns to earlier points.
    #[error("the search returns to earlier points")]
    Circles,
    /// An intermediate problem has no solution, such as the contact with a displaced surface.
    #[error("the contact of the displaced surface has no solution")]
    Displaced,
    /// Too many steps in a row went uphill.
    #[error("{found} steps in a row went uphill; at most {allowed} are allowed")]
    Uphill {
        /// Steps uphill.
        found: u32,
        /// Largest number that the method accepts.
        allowed: u32,
    },
    /// The motion does not come to rest with any time step that was tried.
    #[error("the motion does not settle")]
    Unsettled,
    /// The search diverges, or numbers are not finite.
    #[error("diverged: {0}")]
    Diverged(Divergence),
}
