use std::ops::ControlFlow;

use crate::Visit;

/// Progress of a running search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Number of iterations or time steps.
    pub iteration: u64,
    /// Estimated distance from the solution, to be compared with the tolerance.
    pub residual: f64,
}

/// Watcher of a search, which may stop it. Closures are watchers, and `()` does nothing.
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
    /// Called in every iteration. `Break` ends the search with [`Ending::Interrupted`](crate::Ending::Interrupted).
    fn see(&mut self, now: &Progress) -> ControlFlow<()>;

    /// Called after [`see`](Self::see) in every step of a dynamic relaxation, with the energy and the variables of the
    /// problem (the displacement of the surface layer). Methods with other unknowns do not call it.
    fn layer(&mut self, energy: f64, u: &[f64]) {
        let _ = (energy, u);
    }

    /// Called between two iterations with a function that visits all variables of the search. A watcher that keeps
    /// checkpoints passes a writing visitor to it. The default does nothing.
    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        let _ = variables;
    }

    /// Returns the checkpoint to resume from, as a reading visitor. Each part of a search reads its own variables at
    /// its start, in the order of [`checkpoint`](Self::checkpoint).
    fn recall(&mut self) -> Option<&mut dyn Visit> {
        None
    }
}

/// Watcher of a part of a search. It adds the iterations before the part and visits the variables of the whole search
/// before the variables of the part.
pub struct InnerWatch<'a, F: FnMut(&mut dyn Visit)> {
    /// Watcher of the whole search.
    pub watch: &'a mut dyn Watch,
    /// Number of iterations before this part.
    pub before: u64,
    /// Function that visits the variables of the whole search.
    pub outer: F,
    /// True if the part has other variables than the problem; [`layer`](Watch::layer) is then not passed on.
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
