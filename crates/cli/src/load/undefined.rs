//! The reasons why columns of a load have no value.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// The columns of a load that have no value (null in JSON, NaN in HDF5), by name, each with its reason.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Undefined(BTreeMap<String, String>);

impl Undefined {
    /// True if every column has a value.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// True if the column has no value.
    pub fn has(&self, column: &str) -> bool {
        self.0.contains_key(column)
    }

    /// The names of the columns, each with its reason.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(column, reason)| (&**column, &**reason))
    }

    /// Gives the reason why a column has no value.
    pub fn insert(&mut self, column: &str, reason: impl Into<String>) {
        self.0.insert(column.into(), reason.into());
    }

    /// The reason for one column of several loads: the attribute `undefined` of its dataset. A reason that does not hold
    /// for all loads begins with their indices.
    pub fn of_column<'a>(loads: impl IntoIterator<Item = &'a Self>, column: &str) -> Option<String> {
        Self::of_rows(loads, column, ["load", "loads"])
    }

    /// As [`of_column`](Self::of_column), for rows that have a `name`, in singular and plural.
    pub fn of_rows<'a>(rows: impl IntoIterator<Item = &'a Self>, column: &str, name: [&str; 2]) -> Option<String> {
        let mut reasons: Vec<(&str, Vec<usize>)> = Vec::new();
        let mut count_of_rows = 0;
        for (index, row) in rows.into_iter().enumerate() {
            count_of_rows += 1;
            let Some(reason) = row.0.get(column) else { continue };
            match reasons.iter_mut().find(|(known, _)| known == reason) {
                Some((_, indices)) => indices.push(index),
                None => reasons.push((reason, vec![index])),
            }
        }
        let text = |(reason, indices): &(&str, Vec<usize>)| match indices.len() {
            all if all == count_of_rows => (*reason).to_owned(),
            count => {
                let indices: Vec<String> = indices.iter().map(ToString::to_string).collect();
                format!("{} {}: {reason}", name[usize::from(count > 1)], indices.join(", "))
            }
        };
        (!reasons.is_empty()).then(|| reasons.iter().map(text).collect::<Vec<_>>().join("; "))
    }

    /// The lines below a table of rows that have a `name`, in singular and plural: a reason once, with all columns that
    /// it leaves without a value.
    pub fn lines<'a>(rows: impl IntoIterator<Item = &'a Self> + Clone, name: [&str; 2]) -> Vec<String> {
        let columns: BTreeSet<&str> = rows.clone().into_iter().flat_map(Self::iter).map(|(column, _)| column).collect();
        let mut reasons: Vec<(String, Vec<&str>)> = Vec::new();
        for column in columns {
            let Some(reason) = Self::of_rows(rows.clone(), column, name) else { continue };
            match reasons.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, columns)) => columns.push(column),
                None => reasons.push((reason, vec![column])),
            }
        }
        reasons.into_iter().map(|(reason, columns)| format!("no {}: {reason}", columns.join(", "))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_one_reason_share_a_line() {
        let row = |entries: &[(&str, &str)]| {
            let mut undefined = Undefined::default();
            entries.iter().for_each(|(column, reason)| undefined.insert(column, *reason));
            undefined
        };
        let rows = [
            row(&[("stiffness", "full"), ("stiffness_error", "full"), ("energy", "level"), ("approach", "level")]),
            row(&[("stiffness", "law"), ("energy", "level"), ("approach", "level")]),
        ];
        let lines = Undefined::lines(&rows, ["load", "loads"]);
        let wanted = [
            "no approach, energy: level",
            "no stiffness: load 0: full; load 1: law",
            "no stiffness_error: load 0: full",
        ];
        assert_eq!(lines, wanted);
        assert!(Undefined::lines(&[Undefined::default()], ["load", "loads"]).is_empty());
    }
}
