//! Errors of reading and writing files; each message is one line.

use std::io;
use std::path::{Path, PathBuf};

/// Reason why a file cannot be claimed, written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// Another process holds the target.
    #[error("{} is being written by another process; wait for it to end or choose another file", path.display())]
    Busy {
        /// The target.
        path: PathBuf,
    },
    /// The target is not a valid path of a file.
    #[error("cannot write {}: {reason}", path.display())]
    Target {
        /// The target.
        path: PathBuf,
        /// Reason in words.
        reason: String,
    },
    /// The operating system reported an error.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// The attempted operation.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The HDF5 library could not write a variable or attribute.
    #[error("cannot write {variable} to {}: {reason}", path.display())]
    Write {
        /// The part file.
        path: PathBuf,
        /// The variable or attribute.
        variable: String,
        /// The innermost message of the library.
        reason: String,
    },
    /// A variable or attribute could not be read.
    #[error("cannot read {variable} from {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The variable or attribute.
        variable: String,
        /// The innermost message of the library.
        reason: String,
    },
    /// The file is not an HDF5 file.
    #[error("cannot open {} as HDF5: {reason}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// The innermost message of the library.
        reason: String,
    },
    /// The file has no variable or attribute of this name.
    #[error("{} has no {variable}; its group has: {}", path.display(), listed(present))]
    Missing {
        /// The file.
        path: PathBuf,
        /// The requested name.
        variable: String,
        /// The names in its group.
        present: Vec<String>,
    },
    /// The number of values does not match the dimensions.
    #[error("{variable} has {found} values for the shape {shape:?}")]
    Length {
        /// The variable.
        variable: String,
        /// Number of values.
        found: usize,
        /// Lengths of the dimensions.
        shape: Vec<usize>,
    },
    /// A slab does not match its variable.
    #[error("slab {index} of {variable} has {found} values; the variable has the shape {shape:?}")]
    Slab {
        /// The variable.
        variable: String,
        /// Entry along the first dimension.
        index: usize,
        /// Number of values.
        found: usize,
        /// Shape of the variable.
        shape: Vec<usize>,
    },
    /// A group has two dimensions of one name.
    #[error("dimension {dimension} in group {group} was already written with other coordinates")]
    Dimension {
        /// The group.
        group: String,
        /// The name.
        dimension: String,
    },
    /// A text contains a zero byte.
    #[error("{variable} contains a zero byte, which HDF5 text cannot hold")]
    Text {
        /// The variable or attribute.
        variable: String,
    },
    /// A variable in memory that is larger than what is left of it.
    #[error("{variable} needs {:.1} GiB in memory; {:.1} GiB are available", gib(*needed), gib(*available))]
    Memory {
        /// The variable.
        variable: String,
        /// The bytes of its numbers.
        needed: u64,
        /// The bytes that are left.
        available: u64,
    },
    /// The file was closed after an error.
    #[error("{} is closed", path.display())]
    Closed {
        /// The target.
        path: PathBuf,
    },
}

impl FileError {
    pub(crate) fn create(path: &Path, error: &hdf5::Error) -> Self {
        Self::Target { path: path.into(), reason: reason(error) }
    }

    pub(crate) fn write(path: &Path, variable: &str, error: &hdf5::Error) -> Self {
        Self::Write { path: path.into(), variable: variable.into(), reason: reason(error) }
    }
}

fn gib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 30)
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "nothing".into() } else { names.join(", ") }
}

/// The innermost message of the library, or the message of the operating system if the library quotes one.
pub(crate) fn reason(error: &hdf5::Error) -> String {
    let text = match error.stack().as_deref().and_then(|frames| frames.last()) {
        Some(innermost) => innermost.desc().to_owned(),
        None => error.to_string(),
    };
    let quoted = text.split_once("error message = '").and_then(|(_, rest)| rest.split_once('\''));
    quoted.map_or(text.clone(), |(message, _)| message.to_owned())
}
