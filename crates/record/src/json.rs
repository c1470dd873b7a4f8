//! Records as JSON: nested as printed, or flat with the names of a file.

use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};
use serde_json::Value;

use crate::column::Subject;
use crate::columns::columns;
use crate::{Cell, Column, Record};

/// Key of the reasons.
const UNDEFINED: &str = "undefined";

/// Error: JSON that is not a record of a problem.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Text that is not JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// Value of another type.
    #[error("{column} is {found}; it must be a number, true, false or null")]
    Value {
        /// Name of the column.
        column: &'static str,
        /// Value found.
        found: String,
    },
}

/// Nested JSON in column order. Numeric keys are places in a list; gaps in the list are `null`.
#[derive(Default)]
struct Tree<'a>(Vec<(&'static str, Branch<'a>)>);

enum Branch<'a> {
    Leaf(&'a Cell),
    Tree(Tree<'a>),
}

impl<'a> Tree<'a> {
    fn put(&mut self, path: &'static str, cell: &'a Cell) {
        let Some((key, rest)) = path.split_once('.') else {
            self.0.push((path, Branch::Leaf(cell)));
            return;
        };
        let place = self.0.iter().position(|(other, _)| *other == key).unwrap_or_else(|| {
            self.0.push((key, Branch::Tree(Tree::default())));
            self.0.len() - 1
        });
        if let Branch::Tree(tree) = &mut self.0[place].1 {
            tree.put(rest, cell);
        }
    }

    fn entries<S: Serializer>(&self, map: &mut S::SerializeMap) -> Result<(), S::Error> {
        self.0.iter().try_for_each(|(key, branch)| match branch {
            Branch::Leaf(cell) => map.serialize_entry(key, cell),
            Branch::Tree(tree) => map.serialize_entry(key, tree),
        })
    }

    /// Returns the length of the tree as a list; `None` if it is not a list.
    fn length(&self) -> Option<usize> {
        self.0.iter().map(|(key, _)| key.parse::<usize>().ok().map(|place| place + 1)).max()?
    }

    /// Writes a list of `length` entries.
    fn list<S: Serializer>(&self, serializer: S, length: usize) -> Result<S::Ok, S::Error> {
        // Inner lists share one length.
        let inner = self.0.iter().filter_map(|(_, branch)| match branch {
            Branch::Tree(tree) => tree.length(),
            Branch::Leaf(_) => None,
        });
        let inner = inner.max();
        let mut list = serializer.serialize_seq(Some(length))?;
        for place in 0..length {
            let entry = self.0.iter().find(|(key, _)| key.parse() == Ok(place));
            match entry.map(|(_, branch)| branch) {
                Some(Branch::Leaf(cell)) => list.serialize_element(cell)?,
                Some(Branch::Tree(tree)) => list.serialize_element(&Padded(tree, inner))?,
                None => list.serialize_element(&())?,
            }
        }
        list.end()
    }
}

/// Tree that is written as a list of at least this length.
struct Padded<'t, 'a>(&'t Tree<'a>, Option<usize>);

impl Serialize for Padded<'_, '_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match (self.0.length(), self.1) {
            (Some(own), padded) => self.0.list(serializer, own.max(padded.unwrap_or(0))),
            (None, _) => self.0.serialize(serializer),
        }
    }
}

impl Serialize for Tree<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if let Some(length) = self.length() {
            return self.list(serializer, length);
        }
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        self.entries::<S>(&mut map)?;
        map.end()
    }
}

/// Returns each reason once, with the names of the numbers that it leaves without a value.
pub fn by_reason<'n, 'r>(undefined: impl Iterator<Item = (&'n str, &'r str)>) -> Vec<(&'r str, Vec<&'n str>)> {
    let mut all: Vec<(&str, Vec<&str>)> = Vec::new();
    for (name, reason) in undefined {
        match all.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, names)) => names.push(name),
            None => all.push((reason, vec![name])),
        }
    }
    all
}

/// Returns the reason why a number of a record, or of another object with reasons, has no value.
pub fn reason_for<'a>(record: &'a Value, name: &str) -> Option<&'a str> {
    record.get(UNDEFINED)?.as_object()?.iter().find_map(|(key, value)| match value {
        Value::Array(names) => names.iter().any(|other| other == name).then_some(&**key),
        // Records of earlier versions have a reason under each name.
        Value::String(reason) => (key == name).then_some(&**reason),
        _ => None,
    })
}

/// Map from reasons to names of numbers.
struct Reasons<'a>(Vec<(&'a str, Vec<&'a str>)>);

impl Serialize for Reasons<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(reason, names)| (reason, names)))
    }
}

impl<T: Subject> Record<T> {
    fn tree(&self) -> Tree<'_> {
        let mut tree = Tree::default();
        let printed = self.cells.iter().filter(|(column, _)| !column.json.is_empty());
        printed.for_each(|(column, cell)| tree.put(column.json, cell));
        tree
    }

    /// Serializes the numbers without the reasons, for a report that has all of its reasons in one place.
    ///
    /// # Errors
    /// Returns an error of the serializer.
    pub fn serialize_numbers<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.tree().serialize(serializer)
    }
}

/// Writes the record as printed: nested, with the reasons of numbers without a value.
impl<T: Subject> Serialize for Record<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let tree = self.tree();
        let reasons = Reasons(by_reason(self.undefined()));
        let mut map = serializer.serialize_map(None)?;
        tree.entries::<S>(&mut map)?;
        if !reasons.0.is_empty() {
            map.serialize_entry(UNDEFINED, &reasons)?;
        }
        map.end()
    }
}

/// Record as kept in a journal: flat, with the names of a file.
struct Flat<'a, S: Subject>(&'a Record<S>);

impl<T: Subject> Serialize for Flat<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let reasons = Reasons(by_reason(self.0.undefined()));
        let mut map = serializer.serialize_map(None)?;
        self.0.cells.iter().try_for_each(|(column, cell)| map.serialize_entry(column.name, cell))?;
        map.serialize_entry(UNDEFINED, &reasons)?;
        map.end()
    }
}

/// Writes the record as one line; [`from_line`](Self::from_line) restores it to the last bit.
impl<S: Subject> Record<S> {
    ///
    /// # Errors
    /// Does not fail for numbers.
    pub fn to_line(&self) -> Result<String, RecordError> {
        Ok(serde_json::to_string(&Flat(self))?)
    }

    /// Reads the record of a problem from its line.
    ///
    /// # Errors
    /// Returns an error if `line` is not the line of a record.
    pub fn from_line(facts: &S::Facts, line: &str) -> Result<Self, RecordError> {
        Self::read(facts, &serde_json::from_str(line)?, |column| column.name)
    }

    /// Reads the record of a problem from its nested JSON. Missing numbers become NaN.
    ///
    /// # Errors
    /// Returns an error if a value is not a number.
    pub fn from_json(facts: &S::Facts, value: &Value) -> Result<Self, RecordError> {
        Self::read(facts, value, |column| column.json)
    }

    fn read(facts: &S::Facts, value: &Value, place: fn(&Column<S>) -> &'static str) -> Result<Self, RecordError> {
        let cells = columns(facts).map(|column| {
            let found = place(column).split('.').try_fold(value, |value, key| match key.parse::<usize>() {
                Ok(index) => value.get(index),
                Err(_) => value.get(key),
            });
            let reason = reason_for(value, column.name);
            let cell = match (found, reason) {
                (_, Some(reason)) => Cell::undefined(reason.to_owned()),
                (None | Some(Value::Null), None) => Cell::Real(f64::NAN),
                (Some(Value::Bool(flag)), None) => Cell::Flag(*flag),
                (Some(Value::Number(number)), None) => match (number.as_u64(), number.as_f64()) {
                    (Some(count), _) => Cell::Count(count),
                    (None, found) => Cell::Real(found.unwrap_or(f64::NAN)),
                },
                (Some(other), None) => {
                    return Err(RecordError::Value { column: column.name, found: other.to_string() });
                }
            };
            Ok((column, cell))
        });
        Ok(Self { cells: cells.collect::<Result<_, _>>()? })
    }
}

#[cfg(test)]
mod tests {
    use gfmd_problem::Facts;

    use super::*;
    use crate::COLUMNS;

    #[test]
    fn a_reason_is_written_once_and_read_in_both_forms() {
        let column = |name: &str| COLUMNS.iter().find(|column| column.name == name).unwrap();
        let no = |reason: &'static str| Cell::undefined(reason);
        let names = ["area_fraction", "kappa", "stiffness", "stiffness_error", "mean_gap"];
        let cells = [Cell::Real(0.5), no("pulled"), no("full contact"), no("full contact"), no("pulled")];
        let record = Record { cells: names.map(column).into_iter().zip(cells).collect() };
        let nested = serde_json::to_value(&record).unwrap();
        let wanted =
            serde_json::json!({"pulled": ["kappa", "mean_gap"], "full contact": ["stiffness", "stiffness_error"]});
        assert_eq!(nested[UNDEFINED], wanted);
        let line = record.to_line().unwrap();
        assert_eq!(line.matches("full contact").count(), 1, "{line}");
        let facts = Facts::default();
        let older = serde_json::json!({"area_fraction": 0.5, "undefined": {
            "kappa": "pulled", "stiffness": "full contact", "stiffness_error": "full contact", "mean_gap": "pulled"
        }});
        let of = |read: Record| names.map(|name| read.get(name).cloned());
        let wanted = names.map(|name| record.get(name).cloned());
        assert_eq!(of(Record::from_line(&facts, &line).unwrap()), wanted);
        assert_eq!(of(Record::from_json(&facts, &nested).unwrap()), wanted);
        assert_eq!(of(Record::from_json(&facts, &older).unwrap()), wanted);
        assert_eq!(["kappa", "area_fraction"].map(|name| reason_for(&older, name)), [Some("pulled"), None]);
    }
}
