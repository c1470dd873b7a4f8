//! Observers of a relaxation.

use std::{io, ops::ControlFlow};

use crate::{Status, Visit};

/// Observer of a run. It reads the state without changing it and may stop the run. Logs, traces, checkpoint files and
/// the handling of Ctrl-C are observers outside this crate.
///
/// An observer is called before every step and once after the last. A resumed run shows its first state again, so
/// output should be keyed by [`Status::step`]. Closures are observers, `()` does nothing, and a pair of observers calls
/// both.
///
/// ```
/// use gfmd_relax::{Observer, Status};
/// use std::ops::ControlFlow;
///
/// let mut seen = 0;
/// let mut watch = |_: &Status, _: &()| {
///     seen += 1;
///     Ok(if seen < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) })
/// };
/// let now = Status { step: 0, energy: 1.0, residual: 0.5, settled: 0, evaluations: 1 };
/// assert!(watch.observe(&now, &())?.is_continue());
/// assert!(watch.observe(&now, &())?.is_break());
/// # Ok::<(), std::io::Error>(())
/// ```
pub trait Observer<S> {
    /// Observes the state of one step. `Break` ends the run with [`Outcome::Interrupted`](crate::Outcome::Interrupted).
    fn observe(&mut self, progress: &Status, state: &S) -> io::Result<ControlFlow<()>>;

    /// Called before [`observe`](Self::observe) with a function that visits all variables of the run.
    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        let _ = variables;
    }
}

impl<S> Observer<S> for () {
    fn observe(&mut self, _: &Status, _: &S) -> io::Result<ControlFlow<()>> {
        Ok(ControlFlow::Continue(()))
    }
}

impl<S, F: FnMut(&Status, &S) -> io::Result<ControlFlow<()>>> Observer<S> for F {
    fn observe(&mut self, progress: &Status, state: &S) -> io::Result<ControlFlow<()>> {
        self(progress, state)
    }
}

impl<S, A: Observer<S>, B: Observer<S>> Observer<S> for (A, B) {
    fn observe(&mut self, progress: &Status, state: &S) -> io::Result<ControlFlow<()>> {
        let first = self.0.observe(progress, state)?;
        let second = self.1.observe(progress, state)?;
        Ok(if first.is_break() { first } else { second })
    }
}

/// Observer that calls `inner` at multiples of `steps` only; never if `steps` is zero.
#[derive(Clone, Copy, Debug)]
pub struct Every<O> {
    /// Number of steps between two calls.
    pub steps: u64,
    /// Inner observer.
    pub inner: O,
}

impl<S, O: Observer<S>> Observer<S> for Every<O> {
    fn observe(&mut self, progress: &Status, state: &S) -> io::Result<ControlFlow<()>> {
        if progress.step.checked_rem(self.steps) == Some(0) {
            self.inner.observe(progress, state)
        } else {
            Ok(ControlFlow::Continue(()))
        }
    }
}
