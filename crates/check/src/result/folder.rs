//! Temporary place for a file that is only compared.

use std::path::PathBuf;

use gfmd_input::failure::Failure;

/// Folder for a file that is only compared. It is removed when the value is dropped.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// Creates the folder.
    ///
    /// # Errors
    /// Returns an error if a temporary folder cannot be created.
    pub fn new() -> Result<Self, Failure> {
        let made = tempfile::tempdir();
        made.map(Self).map_err(|error| Failure::computation(format!("cannot make a folder: {error}")))
    }

    /// Returns the path of the file.
    pub fn file(&self) -> PathBuf {
        self.0.path().join("second.h5")
    }
}
