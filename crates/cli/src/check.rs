//! `check`: recomputes the certificates of a result file from its own stored inputs, runs its configuration again on
//! request, and compares number by number.

#[cfg(test)]
mod configuration;

use std::fmt;
use std::path::{Path, PathBuf};

use clap::Args as ClapArgs;
use gfmd_files::legible::line;
use gfmd_files::{Checksum, Reader};
use serde::Serialize;

use crate::checking::{Check, Checking};
use crate::{body, contact, kappa_sweep, path, punch, slide, study};
use gfmd_check::result::{Comparison, Difference, ResultKind, printable};
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::memory::check_file;
use gfmd_input::session::Session;

/// Flags of `check`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd check contact.h5
  gfmd check sweep.h5 --rerun --sample 20
  gfmd check path.h5 --rerun --json")]
pub struct Args {
    /// Result of contact, path, slide, punch, body, kappa-sweep or study
    #[arg(value_name = "FILE.h5")]
    file: PathBuf,
    /// Run the stored configuration again and compare every number
    #[arg(long)]
    rerun: bool,
    /// With --rerun, number of sweep runs or study members to recompute, evenly spread; default: all
    #[arg(long, requires = "rerun", value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    sample: Option<u64>,
}

/// State of the surface file of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum InputState {
    /// The file has the checksum stored in the result.
    Unchanged,
    /// The file has another checksum.
    Changed,
    /// The file does not exist.
    Missing,
}

/// Input of a run.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Input {
    pub file: String,
    pub sha256: String,
    pub state: InputState,
}

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub file: PathBuf,
    pub kind: ResultKind,
    /// True if the checksum of the content holds, `None` for a file without one.
    pub intact: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<Input>,
    /// Second surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_input: Option<Input>,
    pub rerun: bool,
    /// Number of compared numbers.
    pub compared: u64,
    /// Number of numbers that are equal up to rounding on another processor.
    pub rounded: u64,
    /// Number of numbers that differ.
    pub differing: u64,
    /// Differing variables, with their largest difference.
    pub differences: Vec<Difference>,
}

/// Largest number of differences named in the message of a failure.
const LISTED: usize = 20;

/// Runs the command.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a result.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    let file = &args.file;
    let reader = Reader::open(file).map_err(|error| Failure::refused(error.to_string()))?;
    let kinds = "a result of contact, path, slide, punch, body, kappa-sweep or study";
    let kind = ResultKind::of(&reader)
        .ok_or_else(|| Failure::refused(format!("{} is not a result file; it must be {kinds}", file.display())))?;
    check_file(&reader)?;
    // A file that the library cannot read to its end is damaged.
    let intact = reader.is_intact_until(&|| session.is_interrupted()).unwrap_or(Some(false));
    if session.is_interrupted() {
        return Err(Failure::interrupted("interrupted"));
    }
    let mut comparison = Comparison::default();
    let input_of = |name| input(&reader, kind, name);
    let (input, second_input) = (input_of("file")?, input_of("second_file")?);
    for Input { file, .. } in input.iter().chain(&second_input).filter(|input| input.state == InputState::Changed) {
        comparison.differ("input", format!("the checksum of {} differs from the input of the run", printable(file)));
    }
    match intact {
        Some(true) => {}
        Some(false) => comparison.differ("content_sha256", "the content differs from what was written".into()),
        None => comparison.differ("content_sha256", "it is missing; every version writes it".into()),
    }
    let recomputed = recompute(args, kind, &reader, &mut comparison, session);
    match recomputed {
        Ok(()) => {}
        // A damaged file may have unusable inputs; the damage itself is reported.
        Err(failure @ (Failure::Input(_) | Failure::Computation(_))) if intact == Some(false) => {
            comparison.differ("content", failure.to_string());
        }
        Err(failure) => return Err(failure),
    }
    let (compared, rounded, differing) = comparison.counts();
    let report = Report {
        file: file.clone(),
        kind,
        intact,
        input,
        second_input,
        rerun: args.rerun,
        compared,
        rounded,
        differing,
        differences: comparison.into_differences(),
    };
    let failure = (!report.differences.is_empty()).then(|| {
        let names = report.differences.iter().map(|difference| difference.name.as_str());
        let names = names.take(LISTED).collect::<Vec<_>>().join(", ");
        let rest = report.differences.len().saturating_sub(LISTED);
        let rest = if rest == 0 { String::new() } else { format!(" and {rest} others") };
        Failure::computation(format!("{} differs in {names}{rest}", file.display()))
    });
    Ok(Outcome { report, failure })
}

fn recompute(
    args: &Args,
    kind: ResultKind,
    reader: &Reader,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    let text = reader.text("/", "config").map_err(|error| Failure::refused(error.to_string()))?;
    let Some(Check { read, check, again }) = of(kind) else {
        let check = if kind == ResultKind::Study { study::check } else { kappa_sweep::check };
        return check(reader, &text, args.rerun, args.sample, comparison, session);
    };
    let config = read(kind, &text)?;
    let checking = Checking { reader, kind, config: &config, session };
    check(checking, comparison)?;
    // Fields below a surface have no certificate, so recompute them.
    if args.rerun || kind == ResultKind::Body { again(checking, comparison) } else { Ok(()) }
}

/// Returns the check for results of a kind; `None` for sweeps and studies, which are not configured by flags.
pub(crate) fn of(kind: ResultKind) -> Option<Check> {
    Some(match kind {
        ResultKind::Contact => Check::of::<contact::Args>(),
        ResultKind::Path => Check::of::<path::Args>(),
        ResultKind::Slide => Check::of::<slide::Args>(),
        ResultKind::Punch => Check::of::<punch::Args>(),
        ResultKind::Body => Check::of::<body::Args>(),
        ResultKind::KappaSweep | ResultKind::Study => return None,
    })
}

/// Returns the input file named in an attribute of a result, if any.
fn input(reader: &Reader, kind: ResultKind, name: &str) -> Result<Option<Input>, Failure> {
    let group = if kind == ResultKind::Body { "/input" } else { "/surface" };
    let (Ok(file), Ok(sha256)) = (reader.text(group, name), reader.text(group, &format!("{name}_sha256"))) else {
        return Ok(None);
    };
    let path = Path::new(&file);
    let state = match path.exists() {
        false => InputState::Missing,
        // A file that is not regular may have no end.
        true if Checksum::of_file(path)
            .map_err(|error| Failure::refused(format!("cannot read {}: {error}", path.display())))?
            == sha256 =>
        {
            InputState::Unchanged
        }
        true => InputState::Changed,
    };
    Ok(Some(Input { file, sha256, state }))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, kind, intact, input, second_input, rerun, compared, rounded, differing, differences } = self;
        writeln!(f, "{}, a result of {}", file.display(), kind.name())?;
        let words = match intact {
            Some(true) => "holds",
            Some(false) => "DOES NOT HOLD: the file is damaged, or was changed",
            None => "IS MISSING: every version writes it",
        };
        writeln!(f, "checksum of the content {words}")?;
        for Input { file, state, .. } in input.iter().chain(second_input) {
            let words = match state {
                InputState::Unchanged => "is unchanged",
                InputState::Changed => "HAS CHANGED since the run",
                InputState::Missing => "is not there",
            };
            writeln!(f, "input {} {words}", printable(file))?;
        }
        let how = if *rerun { "recomputed and run again" } else { "recomputed from the stored inputs" };
        writeln!(f, "{compared} numbers {how}: {differing} differ, {rounded} in their last digits only")?;
        if !differences.is_empty() {
            writeln!(f, "\n{:<34} {:>8} {:>24} {:>24}", "variable", "values", "stored", "recomputed")?;
        }
        for Difference { name, values, stored, recomputed, remark } in differences {
            let name = line(name);
            match remark {
                Some(remark) => writeln!(f, "{name:<34} {}", line(remark))?,
                None => writeln!(f, "{name:<34} {values:>8} {stored:>24.16e} {recomputed:>24.16e}")?,
            }
        }
        Ok(())
    }
}
