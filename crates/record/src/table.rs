use crate::column::{Column, Form, Head, Importance, Subject, Table};
use crate::digits::with_limit;
use crate::record::Record;
use gfmd_unit::{DisplayUnit, Units};

/// Returns the columns of a table in order, with their places in it. Tables other than [`Table::State`] and
/// [`Table::Energy`] begin with the key of the subject.
pub fn heads<S: Subject>(table: Table) -> impl Iterator<Item = (&'static Column<S>, Head)> {
    let key = (!matches!(table, Table::State | Table::Energy)).then_some(S::KEY);
    let of =
        move |column: &'static Column<S>| column.head.filter(|head| head.table == table || key == Some(column.name));
    S::COLUMNS.iter().filter_map(move |column| Some((column, of(column)?)))
}

/// Column of a printed table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Printed {
    /// Word above the numbers.
    pub word: String,
    /// Head, then a cell for each row.
    pub cells: Vec<String>,
    /// Importance, by which columns are left out.
    pub importance: Importance,
}

impl Printed {
    /// Returns the number of characters of a line that the column takes.
    fn width(&self) -> usize {
        self.cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0) + 2
    }
}

/// Printed table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sheet {
    /// Line of heads, then a line for each row. Empty without a column.
    pub lines: Vec<String>,
    /// Words of the columns that the width has no room for.
    pub left_out: Vec<String>,
}

impl Sheet {
    /// Aligns columns. If they are wider than `width`, the most important columns that fit stay, the first one always;
    /// none of them is less important than one that is left out.
    pub fn of(columns: Vec<Printed>, width: Option<usize>) -> Self {
        let mut room = width.map(|width| width.saturating_sub(columns.first().map_or(0, Printed::width)));
        let mut stays = vec![true; columns.len()];
        let mut is_full = false;
        for importance in [Importance::Main, Importance::Usual, Importance::Detail, Importance::Effort] {
            let was_full = is_full;
            for (index, column) in columns.iter().enumerate().skip(1) {
                let Some(room) = room.as_mut().filter(|_| column.importance == importance) else { continue };
                stays[index] = !was_full && column.width() <= *room;
                if stays[index] {
                    *room -= column.width();
                }
                is_full |= !stays[index];
            }
        }
        let mut sheet = Self {
            lines: vec![String::new(); columns.first().map_or(0, |column| column.cells.len())],
            ..Self::default()
        };
        for (column, stays) in columns.into_iter().zip(stays) {
            if stays {
                let width = column.width();
                sheet.lines.iter_mut().zip(&column.cells).for_each(|(line, cell)| *line += &format!("{cell:>width$}"));
            } else {
                sheet.left_out.push(column.word);
            }
        }
        sheet
    }

    /// Returns the line that names the columns left out; `None` if there are none.
    pub fn footnote(&self) -> Option<String> {
        (!self.left_out.is_empty()).then(|| format!("left out: {} (--wide shows all)", self.left_out.join(", ")))
    }
}

/// Writes states as tables of text: a line of heads, then one line per state, in readable units if the units of the
/// problem are known. Only columns with a number in some row appear. The last column is the largest residual; the table
/// of the lower face has its own. Lines are at most `width` long ([`Sheet::of`]). Empty if the states have no column of
/// the tables.
pub fn table_of<S: Subject>(rows: &[Record<S>], tables: &[Table], units: &Units, width: Option<usize>) -> Sheet {
    Sheet::of(columns_of(rows, tables, units), width)
}

/// Returns the columns of [`table_of`]: each has its head, with the unit, and a number for each state. Empty if the
/// states have no column of the tables.
pub fn columns_of<S: Subject>(rows: &[Record<S>], tables: &[Table], units: &Units) -> Vec<Printed> {
    let has = |column: &Column<S>, head: Head| {
        rows.iter().any(|row| match row.value(column.name) {
            Some(value) => !value.is_nan() && (head.form != Form::SizeUnlessZero || value != 0.0),
            None => false,
        })
    };
    let heads = tables.iter().flat_map(|table| heads::<S>(*table)).filter(|(column, head)| has(column, *head));
    let heads: Vec<(&Column<S>, Head)> = heads.collect();
    if !heads.iter().any(|(_, head)| tables.contains(&head.table)) {
        return Vec::new();
    }
    let columns = heads.iter().map(|(column, Head { word, form, importance, .. })| {
        let unit = readable(column, heads.iter().map(|(beside, _)| *beside), rows, units);
        let cells = rows.iter().map(|row| shown(row, column.name, *form, unit.as_ref()));
        let head = unit.as_ref().map_or_else(|| (*word).to_owned(), |unit| format!("{word} / {}", unit.divisor()));
        Printed {
            word: (*word).to_owned(),
            cells: std::iter::once(head).chain(cells).collect(),
            importance: *importance,
        }
    });
    let residual = match tables {
        [Table::State, ..] => Some("residual"),
        [Table::LowerFace, ..] => Some("lower_residual"),
        _ => None,
    };
    // A law at both faces has one residual, in the table of the state.
    let is_known = |prefix: &&str| rows.iter().any(|row| row.cells.iter().any(|(of, _)| of.name.starts_with(prefix)));
    let residual = residual.filter(|prefix| tables[0] == Table::State || is_known(prefix));
    let residuals = residual.map(|prefix| {
        let word = "residual".to_owned();
        let cells = rows.iter().map(|row| format!("{:.1e}", row.worst_of(prefix)));
        Printed { cells: std::iter::once(word.clone()).chain(cells).collect(), word, importance: Importance::Effort }
    });
    columns.chain(residuals).collect()
}

/// Formats a number for a table; `-` without a value. A number with a grid error appears as its limit on fine grids
/// with the certain digits, or as two digits and `~` if the limit is unknown.
fn shown<S: Subject>(row: &Record<S>, name: &str, form: Form, unit: Option<&DisplayUnit>) -> String {
    let Some(value) = row.value(name).filter(|value| !value.is_nan()) else { return "-".into() };
    let factor = unit.map_or(1.0, |unit| unit.factor);
    row.with_limit(name, factor).unwrap_or_else(|| match form {
        Form::Size | Form::SizeUnlessZero if unit.is_some() => significant(value * factor),
        Form::Size | Form::SizeUnlessZero => format!("{value:.4e}"),
        Form::Rough => format!("{:.1e}", value * factor),
        Form::Share => format!("{value:.6}"),
        Form::Ratio => format!("{value:.4}"),
        Form::Whole if value.fract() == 0.0 => format!("{value:.0}"),
        Form::Whole => format!("{value:.1}"),
        Form::Unsure => with_limit(value * factor, f64::NAN, f64::NAN),
        Form::Flag => if value == 0.0 { "no" } else { "yes" }.into(),
    })
}

/// Returns a readable unit for a column of a table; `None` if it has no unit, or the units of the problem are unknown.
fn readable<'a, S: Subject>(
    column: &Column<S>,
    table: impl Iterator<Item = &'a Column<S>>,
    rows: &[Record<S>],
    units: &Units,
) -> Option<DisplayUnit> {
    let of = |column: &Column<S>| largest(rows.iter().filter_map(|row| row.value(column.name)));
    units.shown(column.unit, size_for_unit(of(column), || table.filter(|other| other.unit == column.unit).map(of)))
}

/// Returns the largest size of finite numbers; 0 without one.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let finite = values.into_iter().filter(|value| value.is_finite());
    finite.fold(0.0, |largest: f64, value| largest.max(value.abs()))
}

/// Returns the size that chooses the unit of numbers up to `own`: zeros have the unit of the largest number of their
/// kind beside them.
pub fn size_for_unit<I: Iterator<Item = f64>>(own: f64, beside: impl FnOnce() -> I) -> f64 {
    if own > 0.0 { own } else { largest(beside()) }
}

/// Formats a number that is not much larger than 1000 with five significant digits.
pub fn significant(value: f64) -> String {
    let decade = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    match decade {
        -3.0..=4.0 => format!("{value:.*}", (4.0 - decade) as usize),
        _ => format!("{value:.4e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{COLUMNS, Cell};

    fn row(cells: &[(&str, Cell)]) -> Record {
        let column = |name: &str| COLUMNS.iter().find(|column| column.name == name).unwrap();
        Record { cells: cells.iter().map(|(name, cell)| (column(name), cell.clone())).collect() }
    }

    #[test]
    fn tables_have_the_columns_with_a_number_below_their_heads() {
        let rows = [
            row(&[
                ("p_star", Cell::Real(0.1)),
                ("lateral_x", Cell::Real(0.0)),
                ("area_fraction", Cell::Real(0.25)),
                ("stiffness", Cell::undefined("full contact")),
                ("iterations", Cell::Count(12)),
                ("residual_load", Cell::Real(2e-9)),
            ]),
            row(&[
                ("p_star", Cell::Real(0.2)),
                ("lateral_x", Cell::Real(0.0)),
                ("area_fraction", Cell::undefined("a reason")),
                ("stiffness", Cell::undefined("full contact")),
                ("iterations", Cell::Count(1234)),
                ("residual_load", Cell::Real(f64::NAN)),
            ]),
        ];
        let wanted = [
            "         p*      area  steps  residual",
            "  1.0000e-1  0.250000     12    2.0e-9",
            "  2.0000e-1         -   1234       NaN",
        ];
        let tables = [Table::State, Table::Energy];
        assert_eq!(
            table_of(&rows, &tables, &Units::default(), None),
            Sheet { lines: wanted.map(Into::into).into(), left_out: Vec::new() }
        );
        assert_eq!(table_of(&rows, &[Table::Patches], &Units::default(), None), Sheet::default());
        for (width, length, left_out) in [
            (38, 38, vec![]),
            (37, 28, vec!["residual"]),
            (28, 28, vec!["residual"]),
            (27, 21, vec!["steps", "residual"]),
            (5, 11, vec!["area", "steps", "residual"]),
        ] {
            let sheet = table_of(&rows, &tables, &Units::default(), Some(width));
            assert_eq!(sheet.lines, wanted.map(|line| &line[..length]), "{width}");
            assert_eq!(sheet.left_out, left_out);
        }
    }

    #[test]
    fn a_narrow_table_keeps_its_most_important_columns() {
        let column = |word: &str, width: usize, importance| Printed {
            word: word.into(),
            cells: vec![word.into(), "1".repeat(width - 2)],
            importance,
        };
        let columns = [
            column("a", 10, Importance::Detail),
            column("b", 10, Importance::Detail),
            column("c", 5, Importance::Detail),
            column("d", 10, Importance::Main),
            column("e", 10, Importance::Usual),
            column("f", 3, Importance::Effort),
        ];
        for (width, left_out) in [
            (48, ""),
            (47, "f"),
            (45, "f"),
            (44, "c, f"),
            (39, "b, f"),
            (34, "b, c, f"),
            (29, "b, c, e, f"),
            (19, "b, c, d, e, f"),
            (1, "b, c, d, e, f"),
        ] {
            let sheet = Sheet::of(columns.to_vec(), Some(width));
            assert_eq!(sheet.left_out.join(", "), left_out, "{width}");
            assert!(sheet.lines[0].len() <= width.max(10));
            assert_eq!(sheet.footnote().is_some(), !left_out.is_empty());
        }
        let whole = Sheet::of(columns.to_vec(), None);
        assert_eq!(whole, Sheet::of(columns.to_vec(), Some(48)));
        assert_eq!(Sheet::of(Vec::new(), Some(5)), Sheet::default());
    }

    #[test]
    fn a_sheet_beside_that_of_the_state_begins_with_the_load_and_shows_errors_in_brackets() {
        let flow = [
            ("p_star", Cell::Real(0.1)),
            ("flow_xx", Cell::Real(0.098)),
            ("flow_xx_limit", Cell::Real(0.101_41)),
            ("flow_xx_limit_error", Cell::Real(0.001_2)),
            ("flow_yy", Cell::Real(0.004_12)),
            ("flow_yy_limit", Cell::undefined("near closing")),
            ("flow_percolates_x", Cell::Flag(false)),
        ];
        let wanted =
            ["         p*     flow xx  flow yy  open along x", "  1.0000e-1  0.1014(12)  0.0041~            no"];
        assert_eq!(table_of(&[row(&flow)], &[Table::Flow], &Units::default(), None).lines, wanted);
    }

    #[test]
    fn numbers_of_a_problem_with_units_are_read_in_those() {
        let of = |gap: f64, limit: Cell| {
            row(&[("p_star", Cell::Real(0.1)), ("mean_gap", Cell::Real(gap)), ("mean_gap_limit", limit)])
        };
        let rows = [of(3.2e-7, Cell::Real(3.214e-7)), of(1.27e-9, Cell::undefined("near closing"))];
        let lines = table_of(&rows, &[Table::State], &Units::new(Some("m"), None), None).lines;
        assert!(lines[0].contains("mean gap / nm"), "{lines:?}");
        assert!(lines[2].contains("1.3~"), "{lines:?}");
        // A leak of zero stands in the unit of the other one.
        let leaks = [row(&[("leak_x", Cell::Real(0.0)), ("leak_y", Cell::Real(2.5e-9))])];
        let lines = table_of(&leaks, &[Table::Flow], &Units::new(Some("m"), None), None).lines;
        assert_eq!(lines, ["  leak x / (µl/s)  leak y / (µl/s)", "           0.0000           2.5000"]);
        let lost = row(&[("dissipated", Cell::Real(0.05)), ("dissipated_error", Cell::Real(2e-3))]);
        let lines = table_of(&[lost], &[Table::Energy], &Units::new(Some("m"), None), None).lines;
        assert!(lines[0].ends_with("+- / (mJ/m²)") && lines[1].ends_with("2.0e0"), "{lines:?}");
        assert_eq!(
            [320.0, 0.0, 1.25, 4e-6, -71.294].map(significant),
            ["320.00", "0.0000", "1.2500", "4.0000e-6", "-71.294"]
        );
    }
}
