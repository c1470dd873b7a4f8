//! Remarks on a result, which stand in every file of a run.

use std::sync::{Arc, Mutex, PoisonError};

/// A remark on a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// A short name that does not change, for programs.
    pub code: &'static str,
    /// The remark in words, one line.
    pub text: String,
}

/// The remarks of one run, in the order in which they were made. Clones share the list, so that a file contains the remarks
/// made until it is finished.
#[derive(Clone, Debug, Default)]
pub struct Warnings(Arc<Mutex<Vec<Warning>>>);

impl Warnings {
    /// Adds a remark.
    pub fn add(&self, warning: Warning) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(warning);
    }

    /// The remarks so far.
    pub fn list(&self) -> Vec<Warning> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The remarks so far as text, one line `code: text` each.
    pub fn lines(&self) -> String {
        self.list().iter().map(|Warning { code, text }| format!("{code}: {text}\n")).collect()
    }
}

impl PartialEq for Warnings {
    fn eq(&self, other: &Self) -> bool {
        self.list() == other.list()
    }
}
