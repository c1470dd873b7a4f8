//! Progress of a run.

/// Display of the progress of a run.
pub trait Progress: Sync {
    /// Counts a finished piece, in the unit of the whole; `note` describes the state of the work.
    fn advance(&self, piece: f64, note: &str);
}

/// Nothing is shown.
impl Progress for () {
    fn advance(&self, _: f64, _: &str) {}
}
