//! Progress of a run.

/// Display of the progress of a run.
pub trait Progress: Sync {
    /// Counts a finished piece, in units of the whole; `note` describes the state of the work.
    fn advance(&self, piece: f64, note: &str);
}

/// Shows nothing.
impl Progress for () {
    fn advance(&self, _: f64, _: &str) {}
}
