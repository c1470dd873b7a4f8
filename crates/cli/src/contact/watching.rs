//! Progress, interruptions and checkpoints while a load is solved.

use std::ops::ControlFlow;

use gfmd_contact::{Visit, Watch};

use crate::convergence::History;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::resume::Kept;
use crate::session::Session;
use crate::trace::Tracer;

/// The watcher of one load: progress, history, interruption, and copies of the solve.
pub(super) struct Watching<'a, 'k> {
    pub(super) index: usize,
    pub(super) progress: &'a Progress,
    pub(super) session: &'a Session,
    pub(super) history: History,
    pub(super) tracer: Option<Tracer>,
    pub(super) kept: Option<&'a mut Kept<'k>>,
    /// True after an interruption, which waits for the next copy.
    pub(super) closing: bool,
    pub(super) failed: Option<Failure>,
}

impl Watch for Watching<'_, '_> {
    fn see(&mut self, now: &gfmd_contact::Progress) -> ControlFlow<()> {
        let gfmd_contact::Progress { iteration, residual } = *now;
        let note = format!("load {}, iteration {iteration}, residual {residual:.1e}", self.index);
        self.progress.advance(0.0, &note);
        self.history.see(iteration, residual);
        if let Some(tracer) = &mut self.tracer {
            tracer.see(iteration, residual);
        }
        if self.failed.is_some() || self.closing || (self.session.is_interrupted() && self.kept.is_none()) {
            return ControlFlow::Break(());
        }
        self.closing = self.session.is_interrupted();
        ControlFlow::Continue(())
    }

    fn layer(&mut self, energy: f64, u: &[f64]) {
        if let Some(tracer) = &mut self.tracer {
            tracer.layer(energy, u);
        }
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        let Some(kept) = self.kept.as_deref_mut().filter(|kept| self.closing || kept.is_due()) else { return };
        self.failed = kept.checkpoint(variables).err();
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        let running = self.kept.as_deref_mut()?.running()?;
        Some(running)
    }
}
