//! `results`: writes data/results/limits.json, the tables of docs/results.md and its pages, docs/accuracy.md and
//! README.md, and the figures, from the summaries in data/results.
//!
//! A table stands between `<!-- results: NAME -->` and `<!-- end -->`. The text around it is written by hand.

mod accuracy;
mod axes;
mod finite;
mod kappa;
mod limits;
mod loads;
mod source;
mod summary;

use std::fmt;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_input::failure::Failure;
use serde::Serialize;

use summary::Summaries;

/// Flags of `results`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd results
  gfmd results --check")]
pub struct Args {
    /// Read the summaries of sweeps from this folder
    #[arg(long, default_value = "data/results", value_name = "FOLDER")]
    data: PathBuf,
    /// Write the pages and their figures in this folder, README.md in the one above
    #[arg(long, default_value = "docs", value_name = "FOLDER")]
    docs: PathBuf,
    /// Write nothing; fail if a page or a figure is not what the summaries make
    #[arg(long)]
    check: bool,
}

/// Result of the command.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub tables: usize,
    pub figures: usize,
    /// Files that changed.
    pub written: Vec<PathBuf>,
}

/// Table with the names of its page and of its place there.
type Table = (&'static str, &'static str, fn(&Summaries) -> Result<String, Failure>);

/// Figure with the name of its file.
type Figure = (&'static str, fn(&Summaries) -> Result<String, Failure>);

const TABLES: [Table; 18] = [
    ("accuracy", "accuracy", accuracy::table),
    ("../README", "kappa", kappa::sentence),
    ("results", "kappa", kappa::table),
    ("results", "loads", kappa::loads),
    ("results", "seeds", kappa::seeds),
    ("results", "budget", kappa::budget),
    ("results", "between", kappa::between),
    ("results/finite", "percolation", finite::percolation),
    ("results/finite", "reduced", finite::reduced),
    ("results/finite", "long waves", finite::of_long_waves),
    ("results/finite", "above", finite::above),
    ("results/methods", "edge", loads::edge),
    ("results/methods", "one", loads::one),
    ("results/methods", "surfaces", axes::surfaces),
    ("results/others", "table 5.1", limits::table),
    ("results/others", "table 5.2", source::table),
    ("results/others", "cells", source::cells),
    ("results/others", "lines", axes::lines),
];

/// Pages with tables, in the folder of the documents.
const PAGES: [&str; 6] = ["accuracy", "../README", "results", "results/finite", "results/methods", "results/others"];

const FIGURES: [Figure; 5] = [
    ("accuracy", accuracy::figure),
    ("results-nayak", loads::nayak_figure),
    ("results-source", source::figure),
    ("results-slabs", axes::slab_figure),
    ("results-lines", axes::line_figure),
];

/// Runs the command.
///
/// # Errors
/// A summary that is missing or has another form; a page without the place of a table; with `--check` a difference.
pub fn run(args: &Args) -> Result<Report, Failure> {
    let summaries = Summaries::new(&args.data);
    let mut files = Vec::new();
    for page in PAGES {
        let path = args.docs.join(format!("{page}.md"));
        let mut text =
            std::fs::read_to_string(&path).map_err(|error| Failure::input(path.display().to_string(), error))?;
        for (_, name, table) in TABLES.into_iter().filter(|(of, ..)| *of == page) {
            text = filled(&text, name, &table(&summaries)?)?;
        }
        files.push((path, text));
    }
    for (name, figure) in FIGURES {
        files.push((args.docs.join("images").join(format!("{name}.svg")), figure(&summaries)?));
    }
    files.push((args.data.join("limits.json"), kappa::file(&summaries)?));
    let changed = files.into_iter().filter(|(path, text)| std::fs::read_to_string(path).ok().as_ref() != Some(text));
    let changed: Vec<(PathBuf, String)> = changed.collect();
    let written: Vec<PathBuf> = changed.iter().map(|(path, _)| path.clone()).collect();
    if args.check && !written.is_empty() {
        let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
        return Err(Failure::computation(format!("{} is not what the summaries make; run results", names.join(", "))));
    }
    for (path, text) in changed {
        gfmd_files::replace(&path, |file| std::io::Write::write_all(file, text.as_bytes()))?;
    }
    Ok(Report { tables: TABLES.len(), figures: FIGURES.len(), written })
}

/// Returns the page with a table in its place.
pub(crate) fn filled(page: &str, name: &str, table: &str) -> Result<String, Failure> {
    let (start, end) = (format!("<!-- results: {name} -->\n"), "<!-- end -->");
    let missing = || Failure::refused(format!("the page has no place for {name}; it must have {start:?} and {end:?}"));
    let (before, rest) = page.split_once(&start).ok_or_else(missing)?;
    let (_, after) = rest.split_once(end).ok_or_else(missing)?;
    Ok(format!("{before}{start}{table}{end}{after}"))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tables, figures, written } = self;
        writeln!(f, "{tables} tables and {figures} figures from the summaries; {} files changed", written.len())?;
        written.iter().try_for_each(|path| writeln!(f, "written: {}", path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_what_the_summaries_make() {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
        let args = Args { data: root.join("data/results"), docs: root.join("docs"), check: true };
        let report = run(&args).unwrap_or_else(|failure| panic!("{failure}"));
        assert!(report.written.is_empty());
    }

    #[test]
    fn a_table_replaces_what_stands_in_its_place_only() {
        let page = "a\n<!-- results: one -->\nold\n<!-- end -->\nb\n<!-- results: two -->\n<!-- end -->\n";
        let filled_in = filled(page, "one", "new\n").unwrap();
        assert_eq!(filled_in, page.replace("old", "new"));
        assert!(filled(page, "three", "").unwrap_err().to_string().contains("no place for three"));
    }
}
