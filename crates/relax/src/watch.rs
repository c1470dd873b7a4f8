use std::ops::ControlFlow;

/// Progress of a running search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Number of iterations or time steps.
    pub iteration: u64,
    /// Estimate of the distance from the solution by the method, to be compared with the tolerance.
    pub residual: f64,
}

/// A watcher of a search, which may ask to stop. Closures are watchers, and `()` is a silent one.
///
/// ```
/// use gfmd_relax::{Progress, Watch};
/// use std::ops::ControlFlow;
///
/// let mut last = 0;
/// let mut watch = |now: &Progress| {
///     last = now.iteration;
///     if last < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
/// };
/// assert!(watch.see(&Progress { iteration: 1, residual: 0.5 }).is_continue());
/// assert!(watch.see(&Progress { iteration: 2, residual: 0.4 }).is_break());
/// assert!(().see(&Progress { iteration: 2, residual: 0.4 }).is_continue());
/// ```
pub trait Watch {
    /// Is called in every iteration. `Break` ends the search with [`Ending::Interrupted`](crate::Ending::Interrupted).
    fn see(&mut self, now: &Progress) -> ControlFlow<()>;
}

impl Watch for () {
    fn see(&mut self, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(&Progress) -> ControlFlow<()>> Watch for F {
    fn see(&mut self, now: &Progress) -> ControlFlow<()> {
        self(now)
    }
}
