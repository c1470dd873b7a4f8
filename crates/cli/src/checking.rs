//! Check of a result: the common part and the part of each command.

use std::path::PathBuf;

use clap::Args;
use gfmd_check::result::{
    Against, Comparison, Configuration, Folder, Pair, ResultKind, compare_heights, layout, regenerated,
    repeated_problem, stored_problem,
};
use gfmd_contact::Boundary;
use gfmd_files::{Output, Reader};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::Surface;
use gfmd_run::series::{Chosen, Prepared, StateFile};
use ndarray::Array2;
use serde::de::DeserializeOwned;

/// Result to check.
#[derive(Clone, Copy)]
pub(crate) struct Checking<'a> {
    pub(crate) reader: &'a Reader,
    pub(crate) kind: ResultKind,
    pub(crate) config: &'a Configuration,
    pub(crate) session: &'a Session,
}

/// Flags of a command with results that can be checked.
pub(crate) trait Checked: Args + DeserializeOwned {
    /// Recomputes the numbers that follow from others in the file, and compares them.
    ///
    /// # Errors
    /// Returns an error if the file cannot be recomputed.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure>;

    /// Returns the problem of the file, to be solved again; `None` if it is not available.
    ///
    /// # Errors
    /// Returns an error if the configuration does not define a problem.
    fn repeated(checking: Checking) -> Result<Option<Self>, Failure> {
        repeated_problem(checking.reader, checking.config).map(Some)
    }

    /// Runs the command with the output `out`.
    ///
    /// # Errors
    /// Returns the errors of the command.
    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure>;
}

/// Check of the results of a command.
pub(crate) struct Check {
    /// Reads the configuration of a result.
    pub(crate) read: fn(ResultKind, &str) -> Result<Configuration, Failure>,
    /// Recomputes the numbers that follow from others in the file.
    pub(crate) check: fn(Checking, &mut Comparison) -> Result<(), Failure>,
    /// Runs the configuration again and compares all variables.
    pub(crate) again: fn(Checking, &mut Comparison) -> Result<(), Failure>,
}

impl Check {
    pub(crate) fn of<A: Checked>() -> Self {
        Self { read: Configuration::read::<A>, check: A::check, again: again::<A> }
    }
}

/// Runs the command again, writing a file, and compares all variables.
fn again<A: Checked>(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
    let folder = Folder::new()?;
    let Some(args) = A::repeated(checking)? else { return Ok(()) };
    let Checking { reader: first, kind, session, .. } = checking;
    args.write(folder.file(), session)?;
    let second = Reader::open(folder.file())?;
    Pair { kind, first, second: &second, against: Against::Run }.compare(comparison)
}

impl Checking<'_> {
    /// Returns the problem of a result with its stored surface. Compares the heights with their checksum and with
    /// regenerated heights.
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

    /// Compares the layout of a result with the output of `write`.
    pub(crate) fn layout(
        self,
        comparison: &mut Comparison,
        write: impl FnOnce(&Output) -> Result<PathBuf, Failure>,
    ) -> Result<(), Failure> {
        layout(self.kind, self.reader, comparison, write)
    }

    /// Compares the layout of a file with this number of states, completed by `finish`.
    pub(crate) fn layout_of_states(
        self,
        (prepared, states, chosen): (&Prepared, usize, Chosen),
        comparison: &mut Comparison,
        finish: impl FnOnce(StateFile) -> Result<Option<PathBuf>, Failure>,
    ) -> Result<(), Failure> {
        self.layout(comparison, |output| {
            let provenance = self.session.provenance(String::new());
            let file = StateFile::of(Some(output), &provenance, prepared, states, (chosen, self.session))?;
            finish(file)?.ok_or_else(|| Failure::computation("the layout was not written"))
        })
    }
}

/// Compares the stored effect of a base that moves with its effect on the body.
pub(crate) fn check_base(
    reader: &Reader,
    lift: Option<&Array2<f64>>,
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    if let Some(lift) = lift {
        let lift: Vec<f64> = lift.iter().copied().collect();
        comparison.values("/base/lift", &reader.values::<f64>("/base/lift")?, &lift, 0.0);
    }
    Ok(())
}

/// Compares the second surface of a slab with its stored checksum.
pub(crate) fn check_lower(reader: &Reader, lower: Option<&Surface>, comparison: &mut Comparison) {
    if let Some(lower) = lower
        && let Ok(stated) = reader.text("/lower", "height_sha256")
        && lower.checksum() != stated
    {
        comparison.differ("/lower/height", "its checksum does not hold".into());
    }
}
