//! The check of a result: the work that commands have in common, and that which each adds.

use std::path::PathBuf;

use clap::Args;
use gfmd_contact::Boundary;
use gfmd_files::{Output, Reader};
use gfmd_run::failure::Failure;
use gfmd_run::result::{
    Against, Comparison, Configuration, Folder, Kind, Pair, compare_heights, layout, regenerated, repeated_problem,
    stored_problem,
};
use gfmd_run::series::{Chosen, Prepared, StateFile};
use gfmd_run::session::Session;
use serde::de::DeserializeOwned;

/// A result that is checked.
#[derive(Clone, Copy)]
pub(crate) struct Checking<'a> {
    pub(crate) reader: &'a Reader,
    pub(crate) kind: Kind,
    pub(crate) config: &'a Configuration,
    pub(crate) session: &'a Session,
}

/// Flags of a command whose results can be checked.
pub(crate) trait Checked: Args + DeserializeOwned {
    /// Recomputes the numbers that others in the file determine, and compares.
    ///
    /// # Errors
    /// A file that cannot be recomputed.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure>;

    /// The problem of the file, to be solved again; `None` if it is not at hand.
    ///
    /// # Errors
    /// A configuration that poses no problem.
    fn repeated(checking: Checking) -> Result<Option<Self>, Failure> {
        repeated_problem(checking.reader, checking.config).map(Some)
    }

    /// Runs the command with the output `out`.
    ///
    /// # Errors
    /// The errors of the command.
    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure>;
}

/// The check of the results of a command.
pub(crate) struct Check {
    /// Reads the configuration of a result.
    pub(crate) read: fn(Kind, &str) -> Result<Configuration, Failure>,
    /// Recomputes the numbers that others in the file determine.
    pub(crate) check: fn(Checking, &mut Comparison) -> Result<(), Failure>,
    /// Runs the configuration again, and compares all variables.
    pub(crate) again: fn(Checking, &mut Comparison) -> Result<(), Failure>,
}

impl Check {
    pub(crate) fn of<A: Checked>() -> Self {
        Self { read: Configuration::read::<A>, check: A::check, again: again::<A> }
    }
}

/// Runs the command again, which writes a file, and compares all variables.
fn again<A: Checked>(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
    let folder = Folder::new()?;
    let Some(args) = A::repeated(checking)? else { return Ok(()) };
    let Checking { reader: first, kind, session, .. } = checking;
    args.write(folder.file(), session)?;
    let second = Reader::open(folder.file())?;
    Pair { kind, first, second: &second, against: Against::Run }.compare(comparison)
}

impl Checking<'_> {
    /// The problem of a result with the surface that stands in it, whose heights are compared with their checksum, and
    /// with those that are generated again.
    pub(crate) fn problem<A: Checked>(
        self,
        boundary: impl FnOnce(&A) -> Boundary,
        comparison: &mut Comparison,
    ) -> Result<A, Failure> {
        compare_heights(self.reader, comparison)?;
        let args = stored_problem(self.reader, self.config)?;
        regenerated(self.reader, self.config, boundary(&args), comparison, self.session)?;
        Ok(args)
    }

    /// Compares the layout of a result with that which `write` writes.
    pub(crate) fn layout(
        self,
        comparison: &mut Comparison,
        write: impl FnOnce(&Output) -> Result<PathBuf, Failure>,
    ) -> Result<(), Failure> {
        layout(self.kind, self.reader, comparison, write)
    }

    /// Compares the layout of a file with so many states, which `finish` writes to its end.
    pub(crate) fn layout_of_states(
        self,
        (prepared, states, chosen): (&Prepared, usize, Chosen),
        comparison: &mut Comparison,
        finish: impl FnOnce(StateFile) -> Result<Option<PathBuf>, Failure>,
    ) -> Result<(), Failure> {
        self.layout(comparison, |output| {
            let provenance = self.session.provenance(String::new());
            let file = StateFile::of(Some(output), &provenance, prepared, states, (chosen, self.session))?;
            finish(file)?.ok_or_else(|| Failure::Computation("the layout was not written".into()))
        })
    }
}
