//! A place for a file that is only compared.

use std::path::PathBuf;

use crate::failure::Failure;

/// A folder for a file that is only compared. It is removed when the value is dropped.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// Makes the folder.
    ///
    /// # Errors
    /// A temporary folder that cannot be made.
    pub fn new() -> Result<Self, Failure> {
        let made = tempfile::tempdir();
        made.map(Self).map_err(|error| Failure::Computation(format!("cannot make a folder: {error}")))
    }

    /// The path of the file.
    pub fn file(&self) -> PathBuf {
        self.0.path().join("second.h5")
    }
}
