//! Lists of points: `x y z` on a lattice in any order, with or without all its points, and `x z` at even distances.

use ndarray::Array2;

use super::Rows;
use super::header::Header;
use crate::format::Map;
use crate::unit::Sides;

/// The largest distance of a coordinate from its lattice point, in spacings, that counts as rounding.
const OFF: f64 = 0.05;

/// The smallest number of lines that may be a list of points.
const FEWEST: usize = 4;

/// The number of lines of three numbers above which they are not silently taken as a matrix.
const MANY: usize = 16;

/// The largest ratio of the points of a lattice to those in the list.
const SPARSEST: usize = 4;

/// The height map in a list of points; `None` if the rows are a matrix.
///
/// # Errors
/// Points that are not on a lattice, where the rows can hardly be a matrix.
pub(super) fn list(rows: &Rows, header: &Header) -> Result<Option<Map>, String> {
    let units = header.column_units(rows.columns);
    let unit = |column: usize| units.get(column).cloned().flatten();
    // The columns of x, of y if there is one, and of the heights.
    let with_units = |mut map: Map, [x, y]: [Option<usize>; 2], height: usize| {
        let [along_x, along_y] = map.lengths.unwrap_or([1.0; 2]);
        let sides = Sides::of((along_x, x.and_then(unit)), y.map(|y| (along_y, unit(y))))?;
        (map.lengths, map.length_unit, map.notes) = (Some(sides.lengths), sides.unit, sides.notes);
        map.height_unit = unit(height);
        Ok(Some(map))
    };
    match rows.columns {
        _ if rows.rows < FEWEST => Ok(None),
        3 if header.has_validity => {
            let heights = rows.column(1).zip(rows.column(2)).map(|(z, valid)| if valid == 0.0 { f64::NAN } else { z });
            profile(rows.column(0).collect(), heights).and_then(|map| with_units(map, [Some(0), None], 1))
        }
        2 if is_monotonic(rows.column(0)) => {
            profile(rows.column(0).collect(), rows.column(1)).and_then(|map| with_units(map, [Some(0), None], 1))
        }
        // Separators at the ends of the lines make empty columns.
        3 if is_monotonic(rows.column(0)) && rows.column(2).all(f64::is_nan) => {
            profile(rows.column(0).collect(), rows.column(1)).and_then(|map| with_units(map, [Some(0), None], 1))
        }
        3 => match surface(rows) {
            Some(map) => with_units(map, [Some(0), Some(1)], 2),
            // A number of the point in the first column.
            None if is_monotonic(rows.column(0)) && is_monotonic(rows.column(1)) => {
                profile(rows.column(1).collect(), rows.column(2)).and_then(|map| with_units(map, [Some(1), None], 2))
            }
            None if rows.rows < MANY => Ok(None),
            None => Err(format!(
                "the {} lines of three numbers are not the points x y z of a lattice; a matrix with three columns must \
                 have a header with Width and Height",
                rows.rows
            )),
        },
        _ => Ok(None),
    }
}

fn is_monotonic(column: impl Iterator<Item = f64> + Clone) -> bool {
    let next = column.clone().skip(1);
    column.zip(next).all(|(here, next)| next > here)
}

/// The profile of heights at even distances.
fn profile(x: Vec<f64>, heights: impl Iterator<Item = f64>) -> Result<Map, String> {
    let axis = Axis::of(&x)
        .filter(|axis| axis.count == x.len())
        .ok_or_else(|| format!("the {} points x z are not at even distances; they must be", x.len()))?;
    let heights: Vec<f64> = heights.collect();
    let heights = Array2::from_shape_vec((x.len(), 1), heights).map_err(|error| error.to_string())?;
    Ok(Map { heights, lengths: Some([axis.step * axis.count as f64, 1.0]), ..Map::default() })
}

/// The surface through points x y z on a lattice; lattice points missing from the list are undefined.
fn surface(rows: &Rows) -> Option<Map> {
    let axis = |column: usize| Axis::of(&rows.column(column).collect::<Vec<_>>());
    let (x, y) = (axis(0)?, axis(1)?);
    if x.count < 2 || y.count < 2 || x.count.checked_mul(y.count)? > SPARSEST * rows.rows {
        return None;
    }
    let mut heights = Array2::from_elem((x.count, y.count), f64::NAN);
    let mut seen = Array2::from_elem((x.count, y.count), false);
    for ((at_x, at_y), z) in rows.column(0).zip(rows.column(1)).zip(rows.column(2)) {
        let place = [x.index(at_x), y.index(at_y)];
        if std::mem::replace(&mut seen[place], true) {
            return None;
        }
        heights[place] = z;
    }
    let lengths = [x.step * x.count as f64, y.step * y.count as f64];
    Some(Map { heights, lengths: Some(lengths), ..Map::default() })
}

/// Evenly spaced coordinates.
struct Axis {
    first: f64,
    step: f64,
    count: usize,
}

impl Axis {
    /// The lattice of coordinates, each of which occurs any number of times. `None` if there is none.
    fn of(coordinates: &[f64]) -> Option<Self> {
        let mut sorted = coordinates.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (first, last) = (*sorted.first()?, *sorted.last()?);
        if !(last - first).is_finite() || last <= first {
            return None;
        }
        // Steps far below the largest are rounding between points of one column.
        let steps = || sorted.windows(2).map(|pair| pair[1] - pair[0]);
        let largest = steps().fold(0.0, f64::max);
        let smallest = steps().filter(|step| *step > 0.1 * largest).fold(f64::INFINITY, f64::min);
        let single = || steps().filter(|step| *step > 0.1 * largest && *step < 1.5 * smallest);
        let mean = single().sum::<f64>() / single().count() as f64;
        let intervals = ((last - first) / mean).round();
        if intervals > coordinates.len() as f64 {
            return None;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from zero to the number of coordinates"
        )]
        let axis = Self { first, step: (last - first) / intervals, count: intervals as usize + 1 };
        let off = |x: f64| (x - first) / axis.step - ((x - first) / axis.step).round();
        sorted.iter().all(|&x| off(x).abs() <= OFF).then_some(axis)
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a coordinate of the axis, which begins at the first"
    )]
    fn index(&self, coordinate: f64) -> usize {
        (((coordinate - self.first) / self.step).round() as usize).min(self.count - 1)
    }
}
