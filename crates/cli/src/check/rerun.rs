//! A run that is repeated from the configuration in its file.

use std::path::Path;

use gfmd_files::Reader;

use gfmd_run::failure::Failure;
use gfmd_run::result::{Against, Comparison, Configuration, Folder, Kind, Pair};
use gfmd_run::session::Session;

/// A file whose run is repeated.
pub(crate) struct Rerun<'a> {
    pub(crate) reader: &'a Reader,
    pub(crate) kind: Kind,
    pub(crate) config: &'a Configuration,
    pub(crate) session: &'a Session,
}

impl Rerun<'_> {
    /// Runs the command again, which writes the file that it is given, and compares all variables.
    ///
    /// # Errors
    /// A run that cannot be repeated.
    pub(crate) fn compare(
        &self,
        comparison: &mut Comparison,
        again: fn(&Reader, &Configuration, &Path, &Session) -> Result<bool, Failure>,
    ) -> Result<(), Failure> {
        let folder = Folder::new()?;
        let out = folder.file();
        if !again(self.reader, self.config, &out, self.session)? {
            return Ok(());
        }
        let second = Reader::open(&out)?;
        Pair { kind: self.kind, first: self.reader, second: &second, against: Against::Run }.compare(comparison)
    }
}
