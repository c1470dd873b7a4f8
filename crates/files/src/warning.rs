//! Warnings on a result, which are written into every file of a run.

use std::borrow::Cow;
use std::fmt::{self, Display};
use std::sync::{Arc, Mutex, PoisonError};

/// Warning on a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Short stable name, for programs.
    pub code: Cow<'static, str>,
    /// Warning in words, one line.
    pub text: String,
}

impl Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}: {}", self.code, self.text)
    }
}

/// Warnings of a run, in order. Clones share the list, so a file contains all warnings added before it is finished.
#[derive(Clone, Debug, Default)]
pub struct Warnings(Arc<Mutex<Vec<Warning>>>);

impl Warnings {
    /// Adds a warning.
    pub fn add(&self, warning: Warning) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(warning);
    }

    /// Returns the warnings so far.
    pub fn list(&self) -> Vec<Warning> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the warnings so far as text, one line `code: text` each.
    pub fn lines(&self) -> String {
        self.list().iter().map(|warning| format!("{warning}\n")).collect()
    }
}

impl PartialEq for Warnings {
    fn eq(&self, other: &Self) -> bool {
        self.list() == other.list()
    }
}
