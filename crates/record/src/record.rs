use std::array::from_fn;
use std::collections::{BTreeMap, BTreeSet};

use crate::column::{LIMIT, State, Subject};
use crate::columns::columns;
use crate::digits::with_limit;
use crate::{Cell, Column, Origin, StateContext};

/// The numbers of one result: the columns of its problem, and their values.
#[derive(Clone, Debug)]
pub struct Record<S: Subject = State> {
    pub(crate) cells: Vec<(&'static Column<S>, Cell)>,
}

impl Record {
    /// Computes all columns of a state.
    pub fn of(at: &StateContext) -> Self {
        Self::compute(at.facts, at)
    }
}

impl<S: Subject> Record<S> {
    /// Computes all columns that a result of a problem with these `facts` has.
    pub fn compute(facts: &S::Facts, at: &S::Context<'_>) -> Self {
        Self { cells: columns(facts).map(|column: &'static Column<S>| (column, column.cell(facts, at))).collect() }
    }

    /// Returns the columns, in their order, with their cells.
    pub fn cells(&self) -> impl Iterator<Item = (&'static Column<S>, &Cell)> {
        self.cells.iter().map(|(column, cell)| (*column, cell))
    }

    /// The cell of a column; `None` if the problem does not have it.
    pub fn get(&self, name: &str) -> Option<&Cell> {
        self.cells.iter().find(|(column, _)| column.name == name).map(|(_, cell)| cell)
    }

    /// The number of a column; NaN without a value, or without the column.
    pub fn number(&self, name: &str) -> f64 {
        self.get(name).map_or(f64::NAN, Cell::number)
    }

    /// The number of a column; `None` without a value, or without the column.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.get(name).filter(|cell| !matches!(cell, Cell::Undefined(_))).map(Cell::number)
    }

    /// A number times a `factor` as its error by the grid leaves it ([`with_limit`]); `None` for a column
    /// without a limit.
    pub(crate) fn with_limit(&self, name: &str, factor: f64) -> Option<String> {
        let limit = format!("{name}{LIMIT}");
        let error = || self.number(&format!("{limit}_error"));
        self.has(&limit).then(|| with_limit(factor * self.number(name), factor * self.number(&limit), factor * error()))
    }

    /// The numbers of the columns `name_x` and `name_y`.
    pub fn vector(&self, name: &str) -> [f64; 2] {
        ["x", "y"].map(|axis| self.number(&format!("{name}_{axis}")))
    }

    /// True if the record has the column.
    pub fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// True if the flag of a column is set.
    pub fn is(&self, name: &str) -> bool {
        self.get(name) == Some(&Cell::Flag(true))
    }

    /// The columns without a value, each with its reason.
    pub fn undefined(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.cells.iter().filter_map(|(column, cell)| match cell {
            Cell::Undefined(reason) => Some((column.name, &**reason)),
            _ => None,
        })
    }

    /// The largest residual; NaN if one is NaN.
    pub fn worst(&self) -> f64 {
        self.worst_of("residual")
    }

    /// The largest of the columns whose names begin so; NaN if one is NaN.
    pub fn worst_of(&self, prefix: &str) -> f64 {
        let residuals = self.cells.iter().filter(|(column, _)| column.name.starts_with(prefix));
        residuals.map(|(_, cell)| cell.number()).fold(0.0, |worst: f64, residual| {
            if residual.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(residual) }
        })
    }

    /// The first number that is neither finite nor without a value for a reason: it is out of the range of numbers.
    pub fn overflow(&self) -> Option<(&'static str, f64)> {
        let found = self.cells.iter().find(|(_, cell)| matches!(cell, Cell::Real(value) if !value.is_finite()));
        found.filter(|(column, _)| column.name != "seconds").map(|(column, cell)| (column.name, cell.number()))
    }

    /// The record of a problem from the numbers of a file, each with the reason why it has no value, if there is one.
    pub fn stored(facts: &S::Facts, mut number: impl FnMut(&'static Column<S>) -> (f64, Option<String>)) -> Self {
        let cells = columns(facts).map(|column| match number(column) {
            (_, Some(reason)) => (column, Cell::undefined(reason)),
            (value, None) => (column, column.stored(value)),
        });
        Self { cells: cells.collect() }
    }
}

/// The reason why a column of several rows has no value: the attribute `undefined` of its dataset. A reason that does
/// not hold for all rows begins with their indices; `name` is that of a row, in singular and plural.
pub fn reasons<'a, S: Subject>(
    rows: impl IntoIterator<Item = &'a Record<S>>,
    column: &str,
    name: [&str; 2],
) -> Option<String> {
    let mut reasons: Vec<(&str, Vec<usize>)> = Vec::new();
    let mut count_of_rows = 0;
    for (index, row) in rows.into_iter().enumerate() {
        count_of_rows += 1;
        let Some(Cell::Undefined(reason)) = row.get(column) else { continue };
        match reasons.iter_mut().find(|(known, _)| *known == &**reason) {
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

/// The reason of one row in the attribute `undefined` of a dataset ([`reasons`]).
pub fn reason_of(text: &str, row: usize) -> Option<String> {
    let numbered = |part: &str| -> Option<(Vec<usize>, String)> {
        let (head, reason) = part.split_once(": ")?;
        let (_, indices) =
            head.split_once(' ').filter(|(name, _)| matches!(*name, "load" | "loads" | "step" | "steps"))?;
        let indices = indices.split(", ").map(|index| index.parse().ok()).collect::<Option<_>>()?;
        Some((indices, reason.to_owned()))
    };
    let mut found: Vec<(Option<Vec<usize>>, String)> = Vec::new();
    for part in text.split("; ") {
        match (numbered(part), found.last_mut()) {
            (Some((indices, reason)), _) => found.push((Some(indices), reason)),
            // A reason may have a semicolon itself.
            (None, Some((_, reason))) => *reason = format!("{reason}; {part}"),
            (None, None) => found.push((None, part.to_owned())),
        }
    }
    let of_row = |(indices, _): &(Option<Vec<usize>>, String)| indices.as_ref().is_none_or(|all| all.contains(&row));
    found.into_iter().find(of_row).map(|(_, reason)| reason)
}

/// The meaning of the sign behind a number.
pub const ROUGH: &str = "two digits and ~: the grid error of the number is not known";

/// The meaning of digits in brackets behind a number.
pub const BRACKETS: &str = "digits in brackets: the grid error of the number in units of its last digit";

/// Returns the lines below a table of rows: the meaning of brackets and `~`, if a number has them, and each reason
/// once, with all the `shown` columns that it leaves without a value. `name` is what a row is called, in singular and
/// plural.
/// The columns of the grid error of a number are named by the number.
pub fn lines<S: Subject>(rows: &[Record<S>], name: [&str; 2], shown: impl Fn(&str) -> bool) -> Vec<String> {
    let cells = || rows.iter().flat_map(|row| &row.cells);
    let all_limited: BTreeSet<&str> = cells().filter_map(|(column, _)| column.limit_of()).collect();
    let undefined = cells().filter(|(column, cell)| matches!(cell, Cell::Undefined(_)) && shown(column.name));
    let undefined: BTreeMap<&str, &'static Column<S>> = undefined.map(|(column, _)| (column.name, *column)).collect();
    // A reason, with its columns and the numbers whose error by the grid is not known.
    let mut listed: Vec<(String, [Vec<&str>; 2])> = Vec::new();
    for column in undefined.into_values() {
        let (list, named) = match (column.origin, column.limit_of()) {
            (Origin::Grid, None) => continue,
            (_, Some(number)) => (1, number),
            (_, None) => (0, column.name),
        };
        let Some(reason) = reasons(rows, column.name, name) else { continue };
        match listed.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, columns)) => columns[list].push(named),
            None => listed.push((reason, from_fn(|other| if other == list { vec![named] } else { Vec::new() }))),
        }
    }
    // Shown with brackets, or with two digits and `~`.
    let is_in_a_table = |name: &str| S::COLUMNS.iter().any(|column| column.name == name && column.head.is_some());
    let limited = |row: &Record<S>, column: &Column<S>| {
        let shown = column.limit_of().filter(|number| is_in_a_table(number));
        shown.and_then(|number| row.with_limit(number, 1.0))
    };
    let limited: Vec<String> =
        rows.iter().flat_map(|row| row.cells.iter().filter_map(|(column, _)| limited(row, column))).collect();
    let legends = [('(', BRACKETS), ('~', ROUGH)].into_iter();
    let legends = legends.filter(|(sign, _)| limited.iter().any(|shown| shown.contains(*sign)));
    let line = |(reason, [columns, limits]): (String, [Vec<&str>; 2])| {
        let limits = match limits.len() {
            0 => None,
            all if all == all_limited.len() => Some("grid error".to_owned()),
            _ => Some(format!("grid error of {}", limits.join(", "))),
        };
        let named: Vec<String> = columns.into_iter().map(ToOwned::to_owned).chain(limits).collect();
        format!("no {}: {reason}", named.join(", "))
    };
    legends.map(|(_, legend)| legend.to_owned()).chain(listed.into_iter().map(line)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::COLUMNS;

    fn row(cells: &[(&str, Cell)]) -> Record {
        let column = |name: &str| COLUMNS.iter().find(|column| column.name == name).unwrap();
        Record { cells: cells.iter().map(|(name, cell)| (column(name), cell.clone())).collect() }
    }

    #[test]
    fn reasons_have_their_rows_and_columns_of_one_reason_share_a_line() {
        let no = |reason: &'static str| Cell::undefined(reason);
        let rows = [
            row(&[("stiffness", no("all")), ("stiffness_error", no("all")), ("kappa", Cell::Real(1.0))]),
            row(&[("stiffness", no("all")), ("stiffness_error", no("all")), ("kappa", no("pulled"))]),
            row(&[("stiffness", no("all")), ("stiffness_error", no("all")), ("kappa", no("pulled"))]),
        ];
        let listed = |name: &str| reasons(&rows, name, ["load", "loads"]);
        assert_eq!(listed("stiffness").as_deref(), Some("all"));
        assert_eq!(listed("kappa").as_deref(), Some("loads 1, 2: pulled"));
        assert_eq!(reasons(&rows[1..2], "kappa", ["load", "loads"]).as_deref(), Some("pulled"));
        assert_eq!(listed("mean_gap"), None);
        let mixed = "load 0: closed; a remark; loads 1, 2: pulled: far";
        assert_eq!(reason_of(mixed, 0).as_deref(), Some("closed; a remark"));
        assert_eq!(reason_of(mixed, 2).as_deref(), Some("pulled: far"));
        assert_eq!(reason_of(mixed, 3), None);
        assert_eq!(reason_of("infinite: in full contact", 3).as_deref(), Some("infinite: in full contact"));
        let listed = lines(&rows, ["load", "loads"], |_| true);
        assert_eq!(listed, ["no kappa: loads 1, 2: pulled", "no stiffness, stiffness_error: all"]);
        assert_eq!(lines(&rows, ["load", "loads"], |column| column == "kappa").len(), 1);
        assert!(rows[0].overflow().is_none() && row(&[("kappa", Cell::Real(f64::NAN))]).overflow().is_some());
    }
}
