//! Journals: append-only files of records with checksums, which preserve finished work if the process is killed at any
//! moment.
//!
//! The first record, the head, identifies the work. Records are appended and never changed; each is on the disk before
//! [`Journal::append`] returns. An incomplete record at the end is left by a killed process; opening the journal
//! removes it. Any other record with a wrong checksum is an error, and the file is not changed.
//!
//! A record is a line of fixed length, `length checksum check` in hexadecimal (16, 64 and 8 digits; `check` guards the
//! first two), then the bytes, then a line break.

mod records;

use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::Input;
use crate::output::{folder, is_same_file, sync_folder};
use records::{Records, Unusable};

/// Reason why a journal cannot be opened, read or continued.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// A record is damaged, or unusable for the reader of the journal.
    #[error("{}, record {record}: {reason}", path.display())]
    Record {
        /// Path of the journal.
        path: PathBuf,
        /// Number of the record; the head is 1.
        record: usize,
        /// Reason in words.
        reason: String,
    },
    /// The file has no head of a journal.
    #[error("{}: this is not a journal", path.display())]
    NoJournal {
        /// Path of the file.
        path: PathBuf,
    },
    /// The journal belongs to other work.
    #[error(
        "{}: the journal belongs to a run of another configuration, input or version; finish that run, or delete it",
        path.display()
    )]
    Other {
        /// Path of the journal.
        path: PathBuf,
    },
    /// The operating system reported an error.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// Attempted operation.
        action: &'static str,
        /// Path of the journal.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

/// Open journal.
pub struct Journal {
    path: PathBuf,
    records: Mutex<Records<File>>,
}

impl Journal {
    /// Opens the journal at `path` of the work identified by `head`, or starts one.
    ///
    /// # Errors
    /// A journal of other work, or a damaged one, which is not changed; a file that cannot be read or written.
    pub fn open(path: &Path, head: &[u8]) -> Result<Self, JournalError> {
        let failed = |source| JournalError::Io { action: "open", path: path.into(), source };
        let file = OpenOptions::new().read(true).append(true).create(true).open(path).map_err(failed)?;
        sync_folder(folder(path)).map_err(failed)?;
        Self::of(path, Records::open(file, head))
    }

    /// Reads the journal at `path` of the work identified by `head`, even while another process writes to it, and
    /// changes nothing. Nothing can be appended.
    ///
    /// # Errors
    /// A journal of other work, or a damaged one; a file that cannot be read.
    pub fn look(path: &Path, head: &[u8]) -> Result<Self, JournalError> {
        let failed = |source| JournalError::Io { action: "open", path: path.into(), source };
        Self::of(path, Records::look(Input::open(path).and_then(|input| input.handle()).map_err(failed)?, head))
    }

    fn of(path: &Path, records: Result<Records<File>, Unusable>) -> Result<Self, JournalError> {
        let records = records.map_err(|unusable| match unusable {
            Unusable::Io(source) => JournalError::Io { action: "open", path: path.into(), source },
            Unusable::NoJournal => JournalError::NoJournal { path: path.into() },
            Unusable::Other => JournalError::Other { path: path.into() },
            Unusable::Damaged { record } => {
                JournalError::Record { path: path.into(), record, reason: "the record is damaged".into() }
            }
        })?;
        Ok(Self { path: path.into(), records: Mutex::new(records) })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of records after the head.
    pub fn len(&self) -> usize {
        self.locked().len()
    }

    /// Returns true if there is no record after the head.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Reads record `index`, counted from 0 after the head.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read(&self, index: usize) -> Result<Vec<u8>, JournalError> {
        self.locked().read(index).map_err(|source| JournalError::Io { action: "read", path: self.path.clone(), source })
    }

    /// Returns the error for a complete record that the reader cannot use.
    pub fn unusable(&self, index: usize, reason: impl Into<String>) -> JournalError {
        JournalError::Record { path: self.path.clone(), record: index + 2, reason: reason.into() }
    }

    /// Appends records; they are on the disk when this function returns.
    ///
    /// # Errors
    /// A file that cannot be written, or that no longer has its name.
    pub fn append<R: AsRef<[u8]>>(&self, records: &[R]) -> Result<(), JournalError> {
        let mut open = self.locked();
        let written = if is_same_file(open.file(), &self.path) {
            open.append(records)
        } else {
            Err(io::Error::new(io::ErrorKind::NotFound, "the file was removed or replaced"))
        };
        written.map_err(|source| JournalError::Io { action: "write", path: self.path.clone(), source })
    }

    /// Removes all records after the head except the first `count`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep_first(&self, count: usize) -> Result<(), JournalError> {
        let cut = self.locked().keep_first(count);
        cut.map_err(|source| JournalError::Io { action: "write", path: self.path.clone(), source })
    }

    /// Removes the file after the work is complete and stored elsewhere.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn remove(self) -> Result<(), JournalError> {
        std::fs::remove_file(&self.path).map_err(|source| JournalError::Io {
            action: "remove",
            path: self.path,
            source,
        })
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, Records<File>> {
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
