//! `verify`: runs all checks of `gfmd-tests`, each with its value and its bound; writes docs/validation.md.

mod document;
mod figures;

use std::fmt;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_cli::progress::Progress;
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::session::Session;
use gfmd_tests::{Bound, Reference, TOPICS, Topic, ValidationError};
use rayon::prelude::*;
use serde::Serialize;

/// Flags of `verify`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd verify
  gfmd verify --topic punch --json
  gfmd verify --write-docs")]
pub struct Args {
    /// Read the reference values from this folder instead of data/reference
    #[arg(long, value_name = "FOLDER")]
    reference: Option<PathBuf>,
    /// Run the checks of this topic only
    #[arg(long, value_name = "NAME", value_parser = TOPICS.map(|topic| topic.name), conflicts_with = "write_docs")]
    topic: Option<String>,
    /// Write FOLDER/validation.md and its figures
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = "docs")]
    write_docs: Option<PathBuf>,
}

/// Result of the command.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub topics: Vec<TopicReport>,
    pub checks: usize,
    pub failed: usize,
    pub written: Vec<PathBuf>,
}

/// Checks of one topic.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct TopicReport {
    pub title: &'static str,
    pub checks: Vec<CheckReport>,
}

/// Result of one check. The bound is `at_most` for an error, `at_least` for an order of convergence.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct CheckReport {
    pub name: String,
    pub source: &'static str,
    pub value: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    pub passed: bool,
}

/// Runs the command.
///
/// # Errors
/// A reference file that cannot be read; an interruption; files that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    let reference = args.reference.as_ref().map_or_else(Reference::default, Reference::new);
    if let Some(folder) = args.write_docs.as_ref().filter(|folder| !folder.is_dir()) {
        return Err(Failure::refused(format!("--write-docs is {}; it must be an existing folder", folder.display())));
    }
    let is_chosen = |topic: &&Topic| args.topic.as_ref().is_none_or(|name| name == topic.name);
    let chosen: Vec<&Topic> = TOPICS.iter().filter(is_chosen).collect();
    let progress = Progress::new(session, "topics", chosen.len());
    let reports = chosen.into_par_iter().map(|topic| {
        if session.is_interrupted() {
            return Err(Failure::interrupted("interrupted; no results were kept"));
        }
        let report = TopicReport::of(topic, &reference)?;
        progress.advance(1.0, topic.title);
        Ok(report)
    });
    let topics = reports.collect::<Result<Vec<_>, _>>()?;
    progress.finish();
    let all = || topics.iter().flat_map(|topic| &topic.checks);
    let failed: Vec<String> = all().filter(|check| !check.passed).map(|check| check.name.clone()).collect();
    let mut report = Report { checks: all().count(), failed: failed.len(), topics, written: Vec::new() };
    if let Some(folder) = &args.write_docs {
        report.written = document::write(folder, &report, &reference)?;
    }
    let failure = (!failed.is_empty()).then(|| {
        Failure::computation(format!("{} of {} checks failed: {}", failed.len(), report.checks, failed.join("; ")))
    });
    Ok(Outcome { report, failure })
}

impl TopicReport {
    fn of(topic: &Topic, reference: &Reference) -> Result<Self, Failure> {
        let checks = (topic.checks)(reference).map_err(|error| match error {
            ValidationError::Reference { .. } => Failure::refused(error.to_string()),
            error => Failure::computation(format!("{}: {error}", topic.title)),
        })?;
        let checks = checks.into_iter().map(|check| {
            let (at_most, at_least) = match check.bound {
                Bound::AtMost(bound) => (Some(bound), None),
                Bound::AtLeast(bound) => (None, Some(bound)),
            };
            let passed = check.passes();
            CheckReport { name: check.name, source: check.source, value: check.value, at_most, at_least, passed }
        });
        Ok(Self { title: topic.title, checks: checks.collect() })
    }
}

impl CheckReport {
    /// Returns the value and its bound as text.
    fn words(&self) -> [String; 2] {
        match (self.at_most, self.at_least) {
            (Some(bound), _) => [format!("{:.2e}", self.value), format!("≤ {bound:e}")],
            (None, Some(bound)) => [format!("{:.2}", self.value), format!("≥ {bound}")],
            (None, None) => [format!("{:.2e}", self.value), String::new()],
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for topic in &self.topics {
            writeln!(f, "{}", topic.title)?;
            for check in &topic.checks {
                let [value, bound] = check.words();
                let mark = if check.passed { "ok" } else { "FAILED" };
                writeln!(f, "  {:<74} {value:>8} {bound:>9}  {mark:<6}  {}", check.name, check.source)?;
            }
            writeln!(f)?;
        }
        writeln!(f, "{} checks, {} failed", self.checks, self.failed)?;
        for file in &self.written {
            writeln!(f, "written: {}", file.display())?;
        }
        Ok(())
    }
}
