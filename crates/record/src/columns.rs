//! All columns, each once, in a file of its subject.

mod contact;
mod energy;
mod flow;
mod limits;
mod load;
mod lower;
mod measured;
mod patches;
mod punch;
mod search;
mod sliding;
mod special;
mod surface;
mod undefined;

use self::limits::LIMITS;
use self::measured::MEASURED;
use crate::column::{State, Subject};

pub use self::limits::{FEWEST_WAVES, UNRESOLVED, not_calibrated};
pub use self::punch::{Punch, PunchContext, PunchFacts};
pub use self::sliding::{SLIDING_FIELDS, Sliding, SlidingContext, SlidingFacts, SlidingField};
pub use self::surface::{Surface, SurfaceContext, SurfaceDetail, SurfaceFacts};

/// Column of a state.
type Column = crate::Column<State>;

/// All columns of states, in the order in which they are printed.
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

/// Returns the columns that results of a problem have.
pub fn columns<S: Subject>(facts: &S::Facts) -> impl Iterator<Item = &'static crate::Column<S>> {
    S::COLUMNS.iter().filter(move |column| (column.present)(facts))
}

/// Returns the columns as a table in Markdown: name in a file, place in JSON if it differs, unit, definitions. The two
/// errors of a limit share its row.
pub fn page<S: Subject>() -> String {
    let is_error = |name: &str| name.ends_with("_limit_error") || name.ends_with("_grid_error");
    let row = |column: &crate::Column<S>| {
        let mut meanings: Vec<&str> = column.meanings.iter().rev().map(|(_, meaning)| *meaning).collect();
        meanings.dedup();
        let order =
            column.order.map_or_else(String::new, |order| format!("; error of order {order} in the grid spacing"));
        let json = match column.json {
            "" => " -".into(),
            same if same == column.name => String::new(),
            other => format!(" `{other}`"),
        };
        let errors = if column.name.ends_with("_limit") { ", `.._error`, `.._grid_error`" } else { "" };
        let file = format!("`{}`{errors}", column.name);
        format!("| {file} |{json} | {} | {}{order} |\n", column.unit, meanings.join("; or: ").replace('|', "\\|"))
    };
    let head = "| HDF5 | JSON | unit | definition |\n|---|---|---|---|\n";
    let rows = S::COLUMNS.iter().filter(|column| !is_error(column.name));
    rows.fold(head.to_owned(), |page, column| page + &row(column))
}
