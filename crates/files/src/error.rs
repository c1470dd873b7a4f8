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
        /// Target.
        path: PathBuf,
    },
    /// The target is not a valid file path.
    #[error("cannot write {}: {reason}", path.display())]
    Target {
        /// Target.
        path: PathBuf,
        /// Reason in words.
        reason: String,
    },
    /// The operating system reported an error.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// Attempted operation.
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The HDF5 library could not write a variable or attribute.
    #[error("cannot write {variable} to {}: {reason}", path.display())]
    Write {
        /// Part file.
        path: PathBuf,
        /// Variable or attribute.
        variable: String,
        /// Innermost message of the library.
        reason: String,
    },
    /// A variable or attribute could not be read.
    #[error("cannot read {variable} from {}: {reason}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Variable or attribute.
        variable: String,
        /// Innermost message of the library.
        reason: String,
    },
    /// The file is not an HDF5 file.
    #[error("cannot open {} as HDF5: {reason}", path.display())]
    Open {
        /// Path of the file.
        path: PathBuf,
        /// Innermost message of the library.
        reason: String,
    },
    /// The file is a result with another layout.
    #[error("{} has the schema_version {found}; this program reads {}", path.display(), crate::SCHEMA_VERSION)]
    Layout {
        /// Path of the file.
        path: PathBuf,
        /// Version of its layout.
        found: f64,
    },
    /// The file has no variable or attribute of this name.
    #[error("{} has no {variable}; its group has: {}", path.display(), listed(present))]
    Missing {
        /// Path of the file.
        path: PathBuf,
        /// Requested name.
        variable: String,
        /// Names in its group.
        present: Vec<String>,
    },
    /// The number of values does not match the dimensions.
    #[error("{variable} has {found} values for the shape {shape:?}")]
    Length {
        /// Variable.
        variable: String,
        /// Number of values.
        found: usize,
        /// Lengths of the dimensions.
        shape: Vec<usize>,
    },
    /// A slab does not match its variable.
    #[error("slab {index} of {variable} has {found} values; the variable has the shape {shape:?}")]
    Slab {
        /// Variable.
        variable: String,
        /// Entry along the first dimension.
        index: usize,
        /// Number of values.
        found: usize,
        /// Shape of the variable.
        shape: Vec<usize>,
    },
    /// A group has two dimensions with the same name.
    #[error("dimension {dimension} in group {group} was already written with other coordinates")]
    Dimension {
        /// Group.
        group: String,
        /// Name.
        dimension: String,
    },
    /// A text contains a zero byte.
    #[error("{variable} contains a zero byte, which HDF5 text cannot hold")]
    Text {
        /// Variable or attribute.
        variable: String,
    },
    /// A variable in memory exceeds the remaining room.
    #[error("{variable} needs {:.1} GiB in memory; {:.1} GiB are available", gib(*needed), gib(*available))]
    Memory {
        /// Variable.
        variable: String,
        /// Size of its numbers in bytes.
        needed: u64,
        /// Remaining bytes.
        available: u64,
    },
    /// The file was closed after an error.
    #[error("{} is closed", path.display())]
    Closed {
        /// Target.
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

/// Returns the innermost message of the library, or the message of the operating system if the library quotes one.
pub(crate) fn reason(error: &hdf5::Error) -> String {
    let text = match error.stack().as_deref().and_then(|frames| frames.last()) {
        Some(innermost) => innermost.desc().to_owned(),
        None => error.to_string(),
    };
    let quoted = text.split_once("error message = '").and_then(|(_, rest)| rest.split_once('\''));
    quoted.map_or(text.clone(), |(message, _)| message.to_owned())
}
