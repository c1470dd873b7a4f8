//! Labels of rows and columns in a matrix, and matrices that may be something else.

use super::axis::Axis;
use super::header::Header;
use super::number::{is_missing, number};
use super::points::{AS_MATRIX, MANY, MOST_COLUMNS, is_monotonic};
use super::{Rows, separator, words};
use crate::format::Map;

/// Smallest number of labels without a word that can be distinguished from heights.
const FEWEST: usize = 3;

/// Smallest number of values that may be line numbers; coordinates need one more.
const DOUBTFUL: usize = 4;

/// Largest number of columns in many lines that may be points instead of a matrix.
const MOST_LIST: usize = 6;

/// Largest number of lines in which two columns are not checked for a lattice.
const LATTICE: usize = 5;

/// Smallest number of lines, and largest number of columns, for a column of unevenly spaced coordinates.
const LONG: usize = 8;

/// Reads a matrix with labels of the columns above and of the rows before it; `None` if there are none. If both are 0,
/// 1, 2, ... or 1, 2, 3, ..., they are numbers of rows and columns; others are coordinates, which give the size.
///
/// # Errors
/// Labels at uneven distances.
pub(super) fn labelled(rows: &Rows, header: &Header) -> Result<Option<Map>, String> {
    let Some((above, digit, first)) = above(rows, header).filter(|_| rows.columns > 2) else { return Ok(None) };
    let left: Vec<f64> = rows.column(0).skip(first).collect();
    let are_numbers = are_numbers(&above) && are_numbers(&left);
    // Two heights are always evenly spaced.
    if left.is_empty() || first == 1 && above.len().min(left.len()) < FEWEST && !are_numbers {
        return Ok(None);
    }
    let even = Axis::is_progression(&above, digit) && (left.len() == 1 || Axis::is_progression(&left, rows.digit(0)));
    if !even {
        let rise = is_monotonic(above.iter().copied()) && is_monotonic(left.iter().copied()) && left.len() > 1;
        return match rise {
            true => {
                Err("the labels of rows and columns are not at even distances; they must be, or nan in the corner \
                         if they are heights"
                    .into())
            }
            false => Ok(None),
        };
    }
    let mut heights = ndarray::Array2::zeros((rows.columns - 1, left.len()));
    for ((i, j), height) in heights.indexed_iter_mut() {
        *height = rows.values[(first + j) * rows.columns + i + 1];
    }
    for (axis, labels) in [&above, &left].into_iter().enumerate() {
        if labels.first() > labels.last() {
            heights.invert_axis(ndarray::Axis(axis));
        }
    }
    let mut map = Map { heights, ..Map::default() };
    if are_numbers || left.len() == 1 {
        map.notes.push("the first line and the first column number the others; they are left out".into());
        return Ok(Some(map));
    }
    let length = |labels: &[f64], digits: [f64; 2], name: &str| {
        let mut rising = labels.to_vec();
        rising.sort_by(f64::total_cmp);
        match Axis::rising(&rising, digits).map_err(|reason| format!("the labels of {name} are not even: {reason}"))? {
            Some(axis) if axis.count == labels.len() => Ok(axis.length()),
            _ => Err(format!("the labels of {name} have gaps; all must be there, at even distances")),
        }
    };
    map.lengths = Some([length(&above, digit, "columns")?, length(&left, rows.digit(0), "rows")?]);
    map.notes.push("the first line and the first column are x and y, which give the size".into());
    Ok(Some(map))
}

/// Returns true if all lines except the first rise or fall evenly.
fn is_plane(rows: &Rows, digit: [f64; 2]) -> bool {
    rows.values.chunks(rows.columns).skip(1).all(|line| Axis::is_progression(line, digit))
}

/// Returns true for 0, 1, 2, ... and for 1, 2, 3, ...
fn are_numbers(labels: &[f64]) -> bool {
    [0.0, 1.0].iter().any(|start| labels.iter().enumerate().all(|(index, label)| *label == start + index as f64))
}

/// Returns the labels above the columns, the units of their last digits, and the first row of heights.
fn above(rows: &Rows, header: &Header) -> Option<(Vec<f64>, [f64; 2], usize)> {
    let digit = rows.all_digits();
    if let Some(labels) = &rows.above {
        return Some((labels.clone(), digit, 0));
    }
    let corner = rows.values.first()?;
    if corner.is_nan() && (rows.has_empty_corner || rows.rows > FEWEST) {
        return Some((rows.values[1..rows.columns].to_vec(), digit, 1));
    }
    let title = header.columns.trim();
    let separator = rows.separator.filter(|separator| title.contains(*separator)).unwrap_or(separator(title));
    let mut found = words(title, separator);
    let corner = found.next()?;
    let labels: Vec<&str> = found.collect();
    if labels.len() + 1 != rows.columns || number(corner, 0, 0).is_ok() || labels.iter().any(|word| is_missing(word)) {
        return None;
    }
    let numbers: Option<Vec<f64>> = labels.iter().map(|word| number(word, 0, 0).ok()).collect();
    let digits = labels.iter().map(|word| [super::number::last_digit(word); 2]);
    let digit = digits.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default();
    numbers.map(|numbers| (numbers, digit, 0))
}

/// Checks that a matrix without a size is not a list, profile or table with labels.
///
/// # Errors
/// A matrix that may be one of these.
pub(super) fn check(rows: &Rows) -> Result<(), String> {
    let (columns, lines) = (rows.columns, rows.rows);
    let column = |column: usize| rows.column(column).collect::<Vec<_>>();
    let line = |line: usize| &rows.values[line * columns..(line + 1) * columns];
    let digit = rows.all_digits();
    let is_even = |numbers: &[f64], digit: [f64; 2]| {
        let least = DOUBTFUL + usize::from(!are_numbers(numbers));
        numbers.len() >= least && Axis::is_progression(numbers, digit)
    };
    let first_column = || is_even(&column(0), rows.digit(0));
    let first_line = || is_even(line(0), digit);
    let behind = |numbers: &[f64], digit| numbers.len() > DOUBTFUL && Axis::is_progression(&numbers[1..], digit);
    if columns > 1 && behind(line(0), digit) && behind(&column(0), rows.digit(0)) && !is_plane(rows, digit) {
        return Err(format!(
            "the first line and the first column rise or fall evenly, as labels do; the corner must be left empty, or \
             both left out; {AS_MATRIX}"
        ));
    }
    // A plane, or a matrix made of lines, is even in all its columns or lines.
    if columns > 1 && first_column() && !(1..columns).all(|k| Axis::is_progression(&column(k), digit)) {
        return Err(format!(
            "the first column rises or falls evenly, as x or labels of rows do; it must be left out, or the points \
             must be x z or x y z; {AS_MATRIX}"
        ));
    }
    let is_list = (3..=MOST_COLUMNS).contains(&columns) && lines > LATTICE;
    if let Some([x, y]) = is_list.then(|| super::points::lattice(rows, |_| true)).flatten() {
        return Err(format!(
            "the columns {} and {} of {columns} are x and y of a lattice, and it is unclear which one is z; a line \
             above must name x, y and z; {AS_MATRIX}",
            x + 1,
            y + 1
        ));
    }
    let narrow = columns > 1 && columns <= LONG.min(MOST_COLUMNS) && lines >= LONG.max(2 * columns);
    if let Some(found) = (0..columns).find(|k| narrow && is_monotonic(rows.column(*k)))
        && !(0..columns).all(|k| is_monotonic(rows.column(k)))
    {
        return Err(format!(
            "column {} of {columns} rises or falls all along the {lines} lines, as x does; a list must have the \
             columns x y z or x z, and several profiles a file each; {AS_MATRIX}",
            found + 1
        ));
    }
    if (3..=MOST_LIST).contains(&columns) && lines >= MANY.max(4 * columns) {
        return Err(format!(
            "the {lines} lines of {columns} numbers may be points or a matrix; a line above them must name the columns \
             x, y and z, or x and z, of points; {AS_MATRIX}"
        ));
    }
    if lines > 2 && first_line() && !(1..lines).all(|k| Axis::is_progression(line(k), digit)) {
        return Err(format!(
            "the first line of numbers rises or falls evenly, as labels of columns or x do; it must be left out, or x \
             z be columns; {AS_MATRIX}"
        ));
    }
    if lines == 2 && columns >= LONG && is_monotonic(line(0).iter().copied()) {
        return Err(format!("the first of two lines rises or falls as x does; x z must be columns; {AS_MATRIX}"));
    }
    if lines == 3 && columns > FEWEST && super::points::is_lattice(line(0), line(1)) {
        return Err(format!(
            "the first two of three lines are x and y of a lattice; x y z must be columns; {AS_MATRIX}"
        ));
    }
    Ok(())
}
