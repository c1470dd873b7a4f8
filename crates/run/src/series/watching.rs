//! Progress, interruptions and checkpoints during the solve of a part.

use std::ops::ControlFlow;

use gfmd_contact::{Visit, Watch};

use crate::convergence::History;
use crate::progress::Progress;
use crate::resume::UnfinishedRun;
use crate::trace::Tracer;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;

/// Watcher of one part: progress, history, interruption, and copies of the solve.
pub struct Watching<'a, 'k> {
    place: String,
    progress: &'a dyn Progress,
    session: &'a Session,
    /// Residuals so far.
    pub history: History,
    /// Recorder of the search, if requested.
    pub tracer: Option<Tracer>,
    kept: Option<&'a mut UnfinishedRun<'k>>,
    /// True after an interruption, which waits for the next copy.
    closing: bool,
    pub(super) failed: Option<Failure>,
}

impl<'a, 'k> Watching<'a, 'k> {
    /// Creates the watcher of a solve at a place such as "load 3", which keeps nothing.
    pub fn new(place: String, progress: &'a dyn Progress, session: &'a Session) -> Self {
        let history = History::default();
        Self { place, progress, session, history, tracer: None, kept: None, closing: false, failed: None }
    }

    /// Adds a record of the search, and copies of it.
    #[must_use]
    pub fn with(self, tracer: Option<Tracer>, kept: Option<&'a mut UnfinishedRun<'k>>) -> Self {
        Self { tracer, kept, ..self }
    }
}

impl Watch for Watching<'_, '_> {
    fn see(&mut self, now: &gfmd_contact::Progress) -> ControlFlow<()> {
        let gfmd_contact::Progress { iteration, residual } = *now;
        let note = format!("{}, iteration {iteration}, residual {residual:.1e}", self.place);
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
        if let Some(kept) = self.kept.as_deref_mut()
            && kept.is_due(self.closing)
        {
            self.failed = kept.checkpoint(variables).err();
        }
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        let running = self.kept.as_deref_mut()?.running()?;
        Some(running)
    }
}
