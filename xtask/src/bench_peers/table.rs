//! Tables of a report, and their files.

use std::fmt;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use gfmd_input::failure::Failure;

use crate::results::filled;

/// A table with a title and a header row.
pub(super) struct Table {
    pub(super) title: String,
    pub(super) head: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Table {
    fn lines(&self) -> impl Iterator<Item = &Vec<String>> {
        std::iter::once(&self.head).chain(&self.rows)
    }

    fn widths(&self) -> Vec<usize> {
        let width =
            |column: usize| self.lines().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max();
        (0..self.head.len()).map(|column| width(column).unwrap_or(0)).collect()
    }

    /// Returns the table as a section of a page.
    pub(super) fn markdown(&self) -> String {
        let widths = self.widths();
        let row = |cells: &Vec<String>| {
            let cells = cells.iter().zip(&widths).map(|(cell, width)| format!(" {cell:>width$} |"));
            format!("|{}\n", cells.collect::<String>())
        };
        let rule =
            format!("|{}\n", widths.iter().map(|width| format!("{}:|", "-".repeat(width + 1))).collect::<String>());
        format!("## {}\n\n{}{rule}{}", self.title, row(&self.head), self.rows.iter().map(row).collect::<String>())
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        let widths = self.widths();
        for line in self.lines() {
            let cells: Vec<String> = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
            writeln!(f, "{}", cells.join("  "))?;
        }
        Ok(())
    }
}

/// Writes a file beside `file` and renames it, so that `file` is never incomplete.
pub(super) fn write_beside(file: &Path, text: &str) -> Result<(), Failure> {
    let mut beside = file.as_os_str().to_owned();
    beside.push(".part");
    let write = || -> std::io::Result<()> {
        let mut opened = File::create(&beside)?;
        opened.write_all(text.as_bytes())?;
        opened.sync_all()?;
        std::fs::rename(&beside, file)
    };
    write().map_err(|error| Failure::computation(format!("cannot write {}: {error}", file.display())))
}

/// Writes a section into its `place` on a page, between the markers of the place.
pub(super) fn fill(page: &Path, place: &str, section: &str) -> Result<(), Failure> {
    let text =
        std::fs::read_to_string(page).map_err(|error| Failure::computation(format!("{}: {error}", page.display())))?;
    write_beside(page, &filled(&text, place, section)?)
}

/// Returns the largest difference between the contact areas of two courses; NaN if one lacks a load.
pub(super) fn areas_differ(own: &[f64], theirs: Option<&[f64]>) -> f64 {
    match theirs {
        Some(theirs) if theirs.len() == own.len() => {
            gfmd_relax::worst(own.iter().zip(theirs).map(|(own, theirs)| (own - theirs).abs()))
        }
        _ => f64::NAN,
    }
}

pub(super) fn in_words(threads: usize) -> String {
    if threads == 1 { "1 thread".into() } else { format!("{threads} threads") }
}

/// Returns the median of the values; NaN if there are none.
pub(super) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}
