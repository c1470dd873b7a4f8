//! A run that is repeated from the configuration in its file.

use std::path::{Path, PathBuf};

use clap::{Args, FromArgMatches};
use gfmd_files::Reader;

use super::{Against, Comparison, Configuration, Kind, Pair};
use crate::failure::Failure;
use crate::session::Session;

/// Parses the flags of a command.
///
/// # Errors
/// Words that are no flags of the command.
pub(crate) fn parsed<A: Args + FromArgMatches>(words: &[String]) -> Result<A, Failure> {
    let command = A::augment_args(clap::Command::new("gfmd").no_binary_name(true));
    // A default that is written out may be refused beside other flags.
    let is_default = |word: &&String| {
        let (flag, value) = word.trim_start_matches('-').split_once('=').unwrap_or((word, ""));
        let argument = command.get_arguments().find(|argument| argument.get_long() == Some(flag));
        argument.is_some_and(|argument| argument.get_default_values() == [value])
    };
    let words: Vec<&String> = words.iter().filter(|word| !is_default(word)).collect();
    let parsed = command.try_get_matches_from(words).and_then(|matches| A::from_arg_matches(&matches));
    parsed.map_err(|error| {
        Failure::input(
            "config of the file",
            error.to_string().lines().map(str::trim).take(2).collect::<Vec<_>>().join(" "),
        )
    })
}

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

/// A folder for a file that is only compared. It is removed when the value is dropped.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Result<Self, Failure> {
        let made = tempfile::tempdir();
        made.map(Self).map_err(|error| Failure::Computation(format!("cannot make a folder: {error}")))
    }

    /// The path of the file.
    pub(crate) fn file(&self) -> PathBuf {
        self.0.path().join("second.h5")
    }
}
