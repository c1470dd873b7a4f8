use crate::Divergence;

/// The end of a search that could be started.
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
    /// The iterations ran out.
    #[error("the iteration limit")]
    Iterations,
    /// The target of the method would have to be below the rounding error.
    #[error("rounding keeps the recomputed residuals above the tolerance")]
    Rounding,
    /// The residuals recomputed from the final fields exceed the estimate of the method.
    #[error("the recomputed residuals are larger than the solver's")]
    Certificate,
    /// No descent, or no curvature, along a search direction.
    #[error("no descent, or no curvature, along the search direction")]
    Direction,
    /// In this precision the function cannot be lowered any more.
    #[error("no way down: in this precision the function cannot be lowered any more")]
    NoDescent,
    /// The search returns to points where it has been.
    #[error("the search goes in circles")]
    Circles,
    /// Every step for a long time went uphill.
    #[error("{found} steps in a row went uphill, allowed are {allowed}")]
    Uphill {
        /// Steps uphill.
        found: u32,
        /// Largest number that the method accepts.
        allowed: u32,
    },
    /// The motion does not come to rest with any time step that was tried.
    #[error("the motion does not settle")]
    Unsettled,
    /// The search moves away from any solution, or meets numbers that are not finite.
    #[error("diverged: {0}")]
    Diverged(Divergence),
}
