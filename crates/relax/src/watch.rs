use std::ops::ControlFlow;

use crate::Visit;

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

    /// Is called after [`see`](Self::see) in every step of a dynamics, with the energy and the variables of the problem
    /// (the displacement of the surface layer). Methods with other unknowns do not call it.
    fn layer(&mut self, energy: f64, u: &[f64]) {
        let _ = (energy, u);
    }

    /// Is called between two iterations with a function that visits all variables of the search. A watcher that keeps
    /// checkpoints passes it a visitor that writes; by default nothing happens.
    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        let _ = variables;
    }

    /// Returns the checkpoint from which the search continues, as a visitor that reads. Each part of a search that
    /// writes variables reads its own from it at its start, in the order in which [`checkpoint`](Self::checkpoint)
    /// visits them.
    fn recall(&mut self) -> Option<&mut dyn Visit> {
        None
    }
}

/// A watcher of a part of a search: it counts the iterations before that part, and writes the variables of the whole
/// before those of the part.
pub struct InnerWatch<'a, F: FnMut(&mut dyn Visit)> {
    /// The watcher of the whole search.
    pub watch: &'a mut dyn Watch,
    /// Number of iterations before this part.
    pub before: u64,
    /// Visits the variables of the whole.
    pub outer: F,
    /// True if the variables of the part are not those of the problem, and [`layer`](Watch::layer) is not passed on.
    pub hides_layer: bool,
}

impl<F: FnMut(&mut dyn Visit)> Watch for InnerWatch<'_, F> {
    fn see(&mut self, now: &Progress) -> ControlFlow<()> {
        self.watch.see(&Progress { iteration: self.before + now.iteration, ..*now })
    }

    fn layer(&mut self, energy: f64, u: &[f64]) {
        if !self.hides_layer {
            self.watch.layer(energy, u);
        }
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        let Self { watch, outer, .. } = self;
        watch.checkpoint(&mut |visitor| {
            outer(visitor);
            variables(visitor);
        });
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        self.watch.recall()
    }
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
