//! All columns, each once, in a file of its subject.

mod contact;
mod energy;
mod flow;
mod limits;
mod load;
mod lower;
mod measured;
mod patches;
mod search;
mod special;
mod undefined;

use gfmd_problem::Facts;

use self::limits::LIMITS;
use self::measured::MEASURED;
use crate::column::Column;

pub use self::limits::{FEWEST_WAVES, UNRESOLVED, not_calibrated};

/// All columns, in the order in which they are printed.
pub const COLUMNS: &[Column] = &ALL;

static ALL: [Column; count(MEASURED) + count(&[LIMITS.as_flattened()])] = {
    let mut all = [MEASURED[0][0]; count(MEASURED) + count(&[LIMITS.as_flattened()])];
    let (mut place, mut table) = (0, 0);
    while table <= MEASURED.len() {
        let columns = if table < MEASURED.len() { MEASURED[table] } else { LIMITS.as_flattened() };
        let (_, rest) = all.split_at_mut(place);
        rest.split_at_mut(columns.len()).0.copy_from_slice(columns);
        place += columns.len();
        table += 1;
    }
    all
};

/// The number of columns of several tables.
const fn count(tables: &[&[Column]]) -> usize {
    let (mut count, mut table) = (0, 0);
    while table < tables.len() {
        count += tables[table].len();
        table += 1;
    }
    count
}

/// The columns of a problem.
pub fn columns(facts: &Facts) -> impl Iterator<Item = &'static Column> {
    COLUMNS.iter().filter(move |column| (column.present)(facts))
}

/// The columns as a table in Markdown: name in a file, place in JSON, unit, definitions.
pub fn page() -> String {
    let row = |column: &Column| {
        let mut meanings: Vec<&str> = column.meanings.iter().rev().map(|(_, meaning)| *meaning).collect();
        meanings.dedup();
        let order =
            column.order.map_or_else(String::new, |order| format!("; of order {order} in the distance of the points"));
        let json = if column.json.is_empty() { "-".into() } else { format!("`{}`", column.json) };
        let file = format!("`{}`", column.name);
        format!("| {file} | {json} | {} | {}{order} |\n", column.unit, meanings.join("; or: "))
    };
    let head = "| HDF5 | JSON | unit | definition |\n|---|---|---|---|\n";
    COLUMNS.iter().fold(head.to_owned(), |page, column| page + &row(column))
}
