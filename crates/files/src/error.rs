//! What can go wrong with result files, one clear line each.

use std::io;
use std::path::{Path, PathBuf};

/// Why a file cannot be claimed, written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// Another process holds the target.
    #[error("{} is being written by another process; wait for it to end or choose another file", path.display())]
    Busy {
        /// The target.
        path: PathBuf,
    },
    /// The target cannot be a file.
    #[error("cannot write {}: {reason}", path.display())]
    Target {
        /// The target.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// On which file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// The HDF5 library could not write.
    #[error("cannot write {variable} to {}: {reason}", path.display())]
    Write {
        /// The part file.
        path: PathBuf,
        /// The variable or attribute.
        variable: String,
        /// The innermost message of the library.
        reason: String,
    },
    /// The HDF5 library could not read.
    #[error("cannot read {variable} from {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The variable or attribute.
        variable: String,
        /// The innermost message of the library.
        reason: String,
    },
    /// Not an HDF5 file.
    #[error("cannot open {} as HDF5: {reason}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// The innermost message of the library.
        reason: String,
    },
    /// A name that the file does not have.
    #[error("{} has no {variable}; its group has: {}", path.display(), listed(present))]
    Missing {
        /// The file.
        path: PathBuf,
        /// What was asked for.
        variable: String,
        /// What the group contains.
        present: Vec<String>,
    },
    /// Values that do not fill the dimensions.
    #[error("{variable} has {found} values for the shape {shape:?}")]
    Length {
        /// The variable.
        variable: String,
        /// Number of values.
        found: usize,
        /// Lengths of the dimensions.
        shape: Vec<usize>,
    },
    /// A slab that does not fit.
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
    /// Two dimensions of one name in a group.
    #[error("dimension {dimension} in group {group} was written before with other coordinates")]
    Dimension {
        /// The group.
        group: String,
        /// The name.
        dimension: String,
    },
    /// A text that HDF5 cannot hold.
    #[error("{variable} contains a zero byte, which HDF5 text cannot hold")]
    Text {
        /// The variable or attribute.
        variable: String,
    },
    /// Used after an error closed the file.
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

    pub(crate) fn read(path: &Path, variable: &str, error: &hdf5::Error) -> Self {
        Self::Read { path: path.into(), variable: variable.into(), reason: reason(error) }
    }
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "nothing".into() } else { names.join(", ") }
}

/// The innermost message of the library, with the operating system's words alone where it quotes them.
pub(crate) fn reason(error: &hdf5::Error) -> String {
    let text = match error.stack().as_deref().and_then(|frames| frames.last()) {
        Some(innermost) => innermost.desc().to_owned(),
        None => error.to_string(),
    };
    let quoted = text.split_once("error message = '").and_then(|(_, rest)| rest.split_once('\''));
    quoted.map_or(text.clone(), |(message, _)| message.to_owned())
}
