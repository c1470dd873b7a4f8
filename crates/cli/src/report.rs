//! `report`: a result file as one page of HTML that needs no network and no program but a browser.

use std::fmt;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args as ClapArgs;
use gfmd_files::legible::line;
use gfmd_files::{FileError, Output, Reader, SCHEMA_VERSION};
use gfmd_problem::key;
use serde::Serialize;

use crate::check;
use crate::checking::Check;
use crate::kinds::kinds;
use crate::session::list_files;
use gfmd_check::result::ResultKind;
use gfmd_input::failure::Failure;
use gfmd_input::memory::check_file;
use gfmd_input::session::Session;
use gfmd_report::{Page, check_replaceable, quoted};

/// Flags of `report`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd report kappa.h5
  gfmd report contact.h5 --out contact-page.html")]
pub struct Args {
    /// Result of contact, path, slide, punch, body, kappa-sweep or study
    #[arg(value_name = "FILE.h5")]
    file: PathBuf,
    /// Write the page to this file; default: beside the result, with the ending .html
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
}

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub file: PathBuf,
    pub kind: ResultKind,
    /// Number of figures in the page.
    pub figures: usize,
    /// Warnings of the run, and parts missing in the file.
    pub remarks: Vec<String>,
    pub out: PathBuf,
}

/// Returns the figures of the page about a result as names and SVG, in the order of the page.
///
/// # Errors
/// Returns an error if the file cannot be read, is not a result, or is damaged.
pub fn figures(file: &Path, session: &Session) -> Result<Vec<(String, String)>, Failure> {
    let (reader, kind, _) = opened(file, session)?;
    Ok(page_of(&reader, kind, session)?.into_figures())
}

/// Writes the page about a result.
///
/// # Errors
/// Fails like [`run`].
pub fn write_page(file: &Path, out: &Path, session: &Session) -> Result<Report, Failure> {
    run(&Args { file: file.to_owned(), out: Some(out.to_owned()) }, session)
}

/// Opens a result file that is not damaged; returns its kind, and true if its checksum holds (`None` without one).
fn opened(file: &Path, session: &Session) -> Result<(Reader, ResultKind, Option<bool>), Failure> {
    let reader = Reader::open(file).map_err(|error| Failure::refused(error.to_string()))?;
    let kinds = "contact, path, slide, punch, body, kappa-sweep or study";
    let kind = ResultKind::of(&reader).ok_or_else(|| {
        let name = file.display();
        let surface = reader.contains("/surface/height");
        let other = format!("; gfmd surface --surface {name} --report PAGE.html makes the page of a surface");
        let other = if surface { &*other } else { "" };
        Failure::refused(format!("{name} is not a result file; it must be one of {kinds}{other}"))
    })?;
    check_file(&reader)?;
    // Numbers of a damaged file are not shown.
    let intact = reader.is_intact_until(&|| session.is_interrupted()).unwrap_or(Some(false));
    if session.is_interrupted() {
        return Err(Failure::interrupted("interrupted"));
    }
    if intact == Some(false) {
        let text = format!("{} is damaged, or was changed; gfmd check says where", file.display());
        return Err(Failure::computation(text));
    }
    // The reader refuses results of this program with another version; this file may name another program.
    let schema = reader.number("/", "schema_version").unwrap_or(f64::NAN);
    if schema != f64::from(SCHEMA_VERSION) {
        let error = FileError::Layout { path: file.to_owned(), found: schema };
        return Err(Failure::refused(error.to_string()));
    }
    Ok((reader, kind, intact))
}

/// Returns the contents of the page about a result.
fn page_of(reader: &Reader, kind: ResultKind, session: &Session) -> Result<Page, Failure> {
    match kind {
        ResultKind::Contact => gfmd_report::contact::page(reader, kinds()),
        ResultKind::Path => gfmd_report::path::page(reader, kinds()),
        ResultKind::KappaSweep => gfmd_report::kappa::page(reader, session),
        ResultKind::Slide => gfmd_report::slide::page(reader, kinds()),
        ResultKind::Punch => gfmd_report::punch::page(reader),
        ResultKind::Body => gfmd_report::body::page(reader),
        ResultKind::Study => gfmd_report::study::page(reader),
    }
}

/// Runs the command.
///
/// # Errors
/// Returns an error if the file cannot be read, is not a result or is damaged, or if the page cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let file = &args.file;
    let (reader, kind, intact) = opened(file, session)?;
    let out = args.out.clone().unwrap_or_else(|| file.with_extension("html"));
    let output = Output::claim(&out).map_err(|error| Failure::input(key("out"), error))?;
    let same = |a: &Path| std::fs::canonicalize(a).ok();
    if same(output.path()).is_some_and(|out| Some(out) == same(file)) {
        return Err(Failure::value(key("out"), out.display(), "another file than the result"));
    }
    check_replaceable("out", output.path())?;
    let mut page = page_of(&reader, kind, session)?;
    page.remarks.splice(0..0, gfmd_report::warnings(&reader));
    let text = gfmd_report::whole_page(&page, &reader, kind, intact, &again(kind, &reader)).into_string();
    output.write(|file| file.write_all(text.as_bytes()))?;
    let out = output.path().to_path_buf();
    Ok(Report { file: file.clone(), kind, figures: page.figures(), remarks: page.remarks, out })
}

/// Returns the command that repeats the run of a result, or the reason why no command does.
fn again(kind: ResultKind, reader: &Reader) -> Result<String, String> {
    let text = reader.text("/", "config").unwrap_or_default();
    let Some(Check { read, .. }) = check::of(kind) else {
        return Ok(match kind {
            ResultKind::Study => "gfmd study study.toml --out again.h5",
            _ => "gfmd kappa-sweep --config sweep.toml --out again.h5",
        }
        .into());
    };
    let config = read(kind, &text).map_err(|error| format!("No command repeats it: {error}."))?;
    if let Some(key) = config.array() {
        let name = key.replace('_', " ");
        return Err(format!("The {name} was an array in the memory of a program: no command line makes it again."));
    }
    let words: Vec<String> = config.words().iter().map(|word| quoted(word)).collect();
    Ok(format!("gfmd {} {} --out again.h5", kind.name(), words.join(" ")))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, kind, figures, remarks, out } = self;
        let plural = if *figures == 1 { "" } else { "s" };
        writeln!(f, "{}, a result of {}: a page with {figures} figure{plural}", file.display(), kind.name())?;
        remarks.iter().try_for_each(|remark| writeln!(f, "note: {}", line(remark)))?;
        list_files(f, Some(out), &[])
    }
}
