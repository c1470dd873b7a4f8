//! Comparison of a result with another file, part by part, following the table of [`trust`](super::trust).

use std::path::PathBuf;

use gfmd_files::{Attribute, Output, Reader};
use gfmd_unit::Dimension;

use super::ResultKind;
use super::comparison::Comparison;
use super::folder::Folder;
use super::trust::{Coverage, Row, row_of};
use gfmd_input::failure::Failure;

/// Largest depth of nested groups. Results have one level; a group of a file may contain itself.
const DEEPEST: usize = 4;

/// Longest text in a message.
const LONGEST: usize = 200;

/// Kind of the second file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// Layout that the configuration gives, with coordinates but without values.
    Layout,
    /// File with values computed from the first file.
    Values,
    /// File of a second run.
    Run,
}

/// Result, and the file with which it is compared.
pub struct Pair<'a> {
    /// Kind of both results.
    pub kind: ResultKind,
    /// Result.
    pub first: &'a Reader,
    /// File with which the result is compared.
    pub second: &'a Reader,
    /// Kind of that file.
    pub against: Against,
}

/// Compares the layout of a result with the layout that `write` writes.
///
/// # Errors
/// Returns an error if a file cannot be written or read.
pub fn layout(
    kind: ResultKind,
    first: &Reader,
    comparison: &mut Comparison,
    write: impl FnOnce(&Output) -> Result<PathBuf, Failure>,
) -> Result<(), Failure> {
    let folder = Folder::new()?;
    let output = Output::claim(folder.file())?.layout();
    let second = Reader::open(write(&output)?)?;
    Pair { kind, first, second: &second, against: Against::Layout }.compare(comparison)
}

impl Pair<'_> {
    /// Compares names, shapes, attributes, coordinates and values.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read.
    pub fn compare(&self, comparison: &mut Comparison) -> Result<(), Failure> {
        self.group("", DEEPEST, comparison)
    }

    fn group(&self, group: &str, depth: usize, comparison: &mut Comparison) -> Result<(), Failure> {
        let Self { kind, first, second, .. } = self;
        self.attributes(group, comparison)?;
        let names = |reader: &Reader| reader.names(if group.is_empty() { "/" } else { group });
        let (stored, found) = (names(first), names(second));
        for name in stored.iter().chain(found.iter().filter(|name| !stored.contains(name))) {
            let path = format!("{group}/{name}");
            match (first.contains(&path), second.contains(&path)) {
                (false, false) if depth > 0 => self.group(&path, depth - 1, comparison)?,
                (false, false) => {
                    comparison.differ(group, format!("it has more than {DEEPEST} groups inside each other"))
                }
                (true, true) => self.variable(&path, comparison)?,
                (true, false) => match row_of(*kind, &path) {
                    // The variable belongs to the search, which is not repeated.
                    Some(Row { plain: Coverage::Checksum, .. }) if self.against == Against::Layout => {}
                    // The steps that prepare a scan are not repeated, since the heights are stored.
                    Some(Row { rerun: Coverage::Checksum, .. }) if self.against == Against::Run => {}
                    _ => comparison.differ(&path, format!("{} has no such variable", self.words())),
                },
                (false, true) => comparison.differ(&path, format!("it is missing; {} has it", self.words())),
            }
        }
        Ok(())
    }

    fn variable(&self, path: &str, comparison: &mut Comparison) -> Result<(), Failure> {
        let Self { kind, first, second, against } = self;
        self.attributes(path, comparison)?;
        let (a, b) = (first.shape(path)?, second.shape(path)?);
        if a != b {
            comparison.differ(path, format!("its shape is {a:?}; recomputed is {b:?}"));
            return Ok(());
        }
        let is_compared = second.is_coordinate(path)
            || match against {
                Against::Layout => false,
                Against::Values => true,
                Against::Run => row_of(*kind, path).is_none_or(|row| row.rerun != Coverage::Checksum),
            };
        if !is_compared {
            return Ok(());
        }
        match (first.values::<f64>(path), second.values::<f64>(path)) {
            (Ok(stored), Ok(found)) => comparison.values(path, &stored, &found, 0.0),
            _ => {
                if first.texts(path)? != second.texts(path)? {
                    comparison.differ(path, "its text differs".into());
                }
            }
        }
        Ok(())
    }

    /// Compares the attributes of the group or variable at `path`; the root is empty.
    fn attributes(&self, path: &str, comparison: &mut Comparison) -> Result<(), Failure> {
        let at = if path.is_empty() { "/" } else { path };
        // A group that is missing in one of the files has no attributes there.
        let of = |reader: &Reader| reader.attributes(at).unwrap_or_default();
        let (stored, found) = (of(self.first), of(self.second));
        let get = |all: &[(String, Attribute)], name: &str| {
            all.iter().find(|(other, _)| other == name).map(|(_, value)| value.clone())
        };
        let new = found.iter().filter(|(name, _)| get(&stored, name).is_none());
        for (name, _) in stored.iter().chain(new).filter(|(name, _)| name != "content_sha256") {
            let part = format!("{path}@{name}");
            let Some(row) = row_of(self.kind, &part) else {
                comparison.differ(&part, format!("a result of {} has no such attribute", self.kind.name()));
                continue;
            };
            let coverage = if self.against == Against::Run { row.rerun } else { row.plain };
            if coverage != Coverage::Verified {
                continue;
            }
            match (get(&stored, name), get(&found, name)) {
                (Some(stored), Some(found)) => match (number(&stored), number(&found)) {
                    (Some(stored), Some(found)) => comparison.number(&part, stored, found, 0.0),
                    // Files of earlier versions have the kind of quantity instead of its unit.
                    _ if stored == found || (name == "units" && is_kind(&stored)) => comparison.count(),
                    _ => comparison.differ(&part, format!("it is {}; it must be {}", shown(&stored), shown(&found))),
                },
                (None, Some(found)) => comparison.differ(&part, format!("it is missing; it must be {}", shown(&found))),
                (Some(_), None) => comparison.differ(&part, format!("{} has no such attribute", self.words())),
                (None, None) => {}
            }
        }
        Ok(())
    }

    /// Returns the second file in words.
    fn words(&self) -> String {
        match self.against {
            Against::Layout | Against::Values => format!("a result of {} with this configuration", self.kind.name()),
            Against::Run => "the file of the second run".into(),
        }
    }
}

/// Returns true for the kind of a quantity with a dimension, such as `stress*length`.
fn is_kind(attribute: &Attribute) -> bool {
    matches!(attribute, Attribute::Text(text) if Dimension::of(text).is_some_and(|found| found != Dimension::NONE))
}

fn number(attribute: &Attribute) -> Option<f64> {
    match attribute {
        Attribute::Real(number) => Some(*number),
        Attribute::Integer(number) => Some(*number as f64),
        Attribute::Natural(number) => Some(*number as f64),
        Attribute::Text(_) => None,
    }
}

fn shown(attribute: &Attribute) -> String {
    match (attribute, number(attribute)) {
        (Attribute::Text(text), _) => format!("{:?}", text.chars().take(LONGEST).collect::<String>()),
        (_, number) => number.unwrap_or(f64::NAN).to_string(),
    }
}
