//! Lists of points: `x y z` on a lattice in any order, with or without gaps, and `x z` at even distances, among other
//! columns or alone.

use std::collections::BTreeSet;

use ndarray::Array2;

use super::Rows;
use super::axis::{self, Axis};
use super::header::{Header, Role, Title};
use crate::format::Map;
use crate::unit::Sides;

/// Smallest number of lines that may be a list of points without titles.
const FEWEST: usize = 4;

/// Smallest number of lines of three numbers that are not silently taken as a matrix.
pub(super) const MANY: usize = 16;

/// Largest ratio of lattice points to points in the list.
const SPARSEST: usize = 4;

/// Smallest ratio of the points of a list to those that are in it again.
const FEW_AGAIN: usize = 4;

/// Largest number of columns of a list.
pub(super) const MOST_COLUMNS: usize = 16;

/// Advice on how to write a matrix that might be a list.
pub(super) const AS_MATRIX: &str = "a matrix must have a header with Width and Height";

/// Columns of a list of points.
#[derive(Clone, Copy, Debug)]
struct Columns {
    x: usize,
    /// `None` for a profile.
    y: Option<usize>,
    z: usize,
}

/// Reads the height map in a list of points; `None` if the rows are a matrix.
///
/// # Errors
/// Points off a lattice where the rows can hardly be a matrix; titles that name several coordinates.
pub(super) fn list(rows: &Rows, header: &Header) -> Result<Option<Map>, String> {
    let titles = header.titles(rows.columns);
    if header.has_validity && rows.columns == 3 {
        return Columns { x: 0, y: None, z: 1 }.map(rows, &titles, header).map(Some);
    }
    if let Some(columns) = Columns::named(&titles, rows.columns)? {
        return columns.map(rows, &titles, header).map(Some);
    }
    let called = |role: Role| titles.iter().any(|title| title.role == role);
    if rows.columns > 2 && !header.titles_are_comment() && called(Role::X) && !called(Role::Z) {
        return Err("a column is called x, but none z or height; one must be".into());
    }
    // Separators at the ends of lines make empty columns.
    let width =
        (0..rows.columns).rev().find(|column| !rows.column(*column).all(f64::is_nan)).map_or(0, |last| last + 1);
    let profile = |x: usize, z: usize| Columns { x, y: None, z }.map(rows, &titles, header).map(Some);
    match rows.columns {
        2.. if rows.separator == Some(' ') && rows.column(0).all(f64::is_nan) && rows.rows > 1 => {
            Err("each line is a dash and a number, a list of YAML; heights must be a matrix or points x z".into())
        }
        _ if rows.rows < FEWEST => Ok(None),
        2 => profile(0, 1),
        3 if width == 2 && is_monotonic(rows.column(0)) => profile(0, 1),
        3 => {
            let columns = Columns { x: 0, y: Some(1), z: 2 };
            if let Some(map) = columns.surface(rows)? {
                return columns.with_units(map, rows.columns, &titles, header).map(Some);
            }
            let is_number = |start: f64| rows.column(0).enumerate().all(|(row, found)| found == start + row as f64);
            // Number of the point in the first column.
            if rows.column(0).next().is_some_and(is_number) && is_monotonic(rows.column(1)) {
                return profile(1, 2);
            }
            if rows.rows < MANY && !columns.is_full(rows) {
                return Ok(None);
            }
            Err(format!(
                "the {} lines of three numbers are not the points x y z of a lattice{}; they must be, or a line above \
                 must name x and z of a profile; {AS_MATRIX}",
                rows.rows,
                columns.again(rows)
            ))
        }
        4..=MOST_COLUMNS => {
            let Some(columns) = Columns::found(rows)? else { return Ok(None) };
            let Some(map) = columns.surface(rows)? else { return Ok(None) };
            columns.with_units(map, rows.columns, &titles, header).map(Some)
        }
        _ => Ok(None),
    }
}

/// Returns true if the numbers rise or fall strictly.
pub(super) fn is_monotonic(column: impl Iterator<Item = f64> + Clone) -> bool {
    let pairs = || column.clone().zip(column.clone().skip(1));
    pairs().all(|(here, next)| next > here) || pairs().all(|(here, next)| next < here)
}

/// Returns true if the points with these coordinates form a lattice with few missing points.
pub(super) fn is_lattice(x: &[f64], y: &[f64]) -> bool {
    let [count_x, count_y] = [x, y].map(axis::count);
    let is_full = |full: usize| (x.len()..=x.len() + x.len() / 4).contains(&full);
    if count_x.min(count_y) < 2 || !count_x.checked_mul(count_y).is_some_and(is_full) {
        return false;
    }
    let mut points: Vec<_> = x.iter().zip(y).map(|(x, y)| (x.to_bits(), y.to_bits())).collect();
    points.sort_unstable();
    points.windows(2).all(|pair| pair[0] != pair[1])
}

/// Returns the first pair of wanted columns that forms a lattice.
pub(super) fn lattice(rows: &Rows, is_wanted: impl Fn(&[usize; 2]) -> bool) -> Option<[usize; 2]> {
    let columns: Vec<Vec<f64>> = (0..rows.columns).map(|column| rows.column(column).collect()).collect();
    let mut pairs = (0..columns.len()).flat_map(|x| (x + 1..columns.len()).map(move |y| [x, y]));
    pairs.find(|pair| is_wanted(pair) && is_lattice(&columns[pair[0]], &columns[pair[1]]))
}

impl Columns {
    /// Finds the columns by their titles; `None` if the titles name no coordinates.
    ///
    /// # Errors
    /// Several columns with the title of one coordinate.
    fn named(titles: &[Title], columns: usize) -> Result<Option<Self>, String> {
        let with = |role: Role| -> Vec<usize> { (0..titles.len()).filter(|k| titles[*k].role == role).collect() };
        let (x, y, z) = (with(Role::X), with(Role::Y), with(Role::Z));
        let several = |name: &str, found: &[usize]| {
            let names: Vec<&str> = found.iter().map(|column| titles[*column].name.as_str()).collect();
            format!("the columns {} are all called {name}; only one must be", names.join(", "))
        };
        for (name, found) in [("x", &x), ("y", &y)] {
            if found.len() > 1 && !z.is_empty() {
                return Err(several(name, found));
            }
        }
        let is_z = |column: &usize| titles[*column].name.trim().starts_with(['z', 'Z']);
        let height = || match z[..] {
            [height] => Ok(Some(height)),
            [] => Ok(None),
            _ => match z.iter().copied().filter(is_z).collect::<Vec<_>>()[..] {
                [height] => Ok(Some(height)),
                _ => Err(several("z", &z)),
            },
        };
        match (&x[..], &y[..]) {
            ([x], [y]) => match height()? {
                Some(z) => Ok(Some(Self { x: *x, y: Some(*y), z })),
                None if columns == 3 => Ok(Some(Self { x: *x, y: Some(*y), z: 3 - x - y })),
                // The height of a curve is often called y.
                None if columns == 2 => Ok(Some(Self { x: *x, y: None, z: *y })),
                None => Err("columns are called x and y, but none z or height; one must be".into()),
            },
            ([along], []) | ([], [along]) => match height()? {
                Some(z) => Ok(Some(Self { x: *along, y: None, z })),
                None if columns == 2 => Ok(Some(Self { x: *along, y: None, z: 1 - along })),
                None => Ok(None),
            },
            _ => Ok(None),
        }
    }

    /// Finds the pair of neighbouring columns that forms a full lattice, and the column after it.
    ///
    /// # Errors
    /// The errors of an axis.
    fn found(rows: &Rows) -> Result<Option<Self>, String> {
        for x in 0..rows.columns - 2 {
            let (y, z) = (x + 1, x + 2);
            let [along_x, along_y] = [x, y].map(|column| rows.column(column).collect::<Vec<_>>());
            if rows.rows < FEWEST + 2 || !is_lattice(&along_x, &along_y) {
                continue;
            }
            let columns = Self { x, y: Some(y), z };
            if columns.surface(rows)?.is_some() {
                // Two lattices, such as numbers and places of points.
                let is_other = |pair: &[usize; 2]| !pair.contains(&x) && !pair.contains(&y);
                return match lattice(rows, is_other) {
                    None => Ok(Some(columns)),
                    Some([a, b]) => Err(format!(
                        "the columns {}, {} and {}, {} are both those of a lattice; a line above must name x, y and z",
                        x + 1,
                        y + 1,
                        a + 1,
                        b + 1
                    )),
                };
            }
        }
        Ok(None)
    }

    /// Returns true if few points are in the list again, and the others are all points of a lattice.
    fn is_full(self, rows: &Rows) -> bool {
        let Some(y) = self.y else { return false };
        let [x, y] = [self.x, y].map(|column| rows.column(column).collect::<Vec<_>>());
        let points: BTreeSet<_> = x.iter().zip(&y).map(|(x, y)| [x, y].map(|place| place.to_bits())).collect();
        let [count_x, count_y] = [&x, &y].map(|places| axis::count(places));
        points.len() >= FEWEST + 2 && count_x * count_y == points.len() && !self.again(rows).is_empty()
    }

    /// Describes the first point that is in the list again, if few points are; empty if none is.
    fn again(self, rows: &Rows) -> String {
        let Some(y) = self.y else { return String::new() };
        let points = || rows.column(self.x).zip(rows.column(y)).enumerate();
        let mut sorted: Vec<_> = points().map(|(row, (x, y))| ([x, y].map(f64::to_bits), row)).collect();
        sorted.sort_unstable();
        let again = || sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        let first = again().min_by_key(|pair| pair[1].1).filter(|_| FEW_AGAIN * again().count() <= rows.rows);
        let point = first.and_then(|pair| Some((pair[0].1, points().nth(pair[1].1)?)));
        point.map_or_else(String::new, |(before, (row, (x, y)))| {
            format!(" (point {} has the x and y of point {}, {x} and {y})", row + 1, before + 1)
        })
    }

    /// Returns the map with the units of the columns.
    fn map(self, rows: &Rows, titles: &[Title], header: &Header) -> Result<Map, String> {
        let map = match self.y {
            None => self.profile(rows, header.has_validity && rows.columns == 3)?,
            Some(y) => self.surface(rows)?.ok_or_else(|| {
                let name = |column: usize| titles.get(column).map_or("", |title| title.name.trim());
                format!(
                    "the {} points in the columns {}, {}, {} are not on a lattice, each point once{}; they must be",
                    rows.rows,
                    name(self.x),
                    name(y),
                    name(self.z),
                    self.again(rows)
                )
            })?,
        };
        self.with_units(map, rows.columns, titles, header)
    }

    fn with_units(self, mut map: Map, columns: usize, titles: &[Title], header: &Header) -> Result<Map, String> {
        let used = [Some(self.x), self.y, Some(self.z)];
        let with =
            used.iter().flatten().filter(|column| titles.get(**column).is_some_and(|title| title.unit.is_some()));
        // A comment with only some of the units is a remark; a line of titles must give all.
        let is_remark = header.titles_are_comment() && with.count() < used.iter().flatten().count();
        let unit = |column: usize| titles.get(column).filter(|_| !is_remark).and_then(|title| title.unit.clone());
        let [along_x, along_y] = map.lengths.unwrap_or([1.0; 2]);
        let sides = Sides::of((along_x, unit(self.x)), self.y.map(|y| (along_y, unit(y))))?;
        map.height_unit = unit(self.z);
        if let (Some(unit), None, Some(title)) = (&sides.unit, &map.height_unit, titles.get(self.z)) {
            return Err(format!(
                "the unit of x is {unit} but the title {:?} of the heights has no unit of length; it must have one",
                title.name.trim()
            ));
        }
        map.lengths = Some(sides.lengths);
        map.length_unit = sides.unit;
        map.notes.extend(sides.notes);
        if columns > used.iter().flatten().count() {
            let name = |column: usize| {
                titles.get(column).map_or_else(|| (column + 1).to_string(), |title| title.name.trim().to_owned())
            };
            let names: Vec<String> = used.iter().flatten().map(|column| name(*column)).collect();
            map.notes.push(format!("the columns {} are read, others are left out", names.join(", ")));
        }
        Ok(map)
    }

    /// Reads the profile of heights at even distances, starting at the smallest x; points missing from the list are
    /// undefined. If `has_validity`, the third column is 0 at undefined points.
    ///
    /// # Errors
    /// Coordinates that are uneven, or may be rounded or have gaps.
    fn profile(self, rows: &Rows, has_validity: bool) -> Result<Map, String> {
        let mut x: Vec<f64> = rows.column(self.x).collect();
        let mut heights: Vec<f64> = rows.column(self.z).collect();
        if has_validity {
            let marks = heights.iter_mut().zip(rows.column(2));
            marks.filter(|(_, valid)| *valid == 0.0).for_each(|(height, _)| *height = f64::NAN);
        }
        let is_falling = x.first() > x.last();
        let goes_on = |pair: &[f64]| if is_falling { pair[1] < pair[0] } else { pair[1] > pair[0] };
        if let Some(at) = x.windows(2).position(|pair| !goes_on(pair)) {
            let matrix = if rows.columns == 2 { format!("; {AS_MATRIX}") } else { String::new() };
            return Err(format!(
                "x is {} at point {} and {} at point {} of {}; it must rise, or fall, from point to point{matrix}",
                x[at],
                at + 1,
                x[at + 1],
                at + 2,
                x.len()
            ));
        }
        if is_falling {
            x.reverse();
            heights.reverse();
        }
        let axis = Axis::rising(&x, rows.digit(self.x))
            .map_err(|reason| format!("the coordinates x are not even: {reason}"))?
            .filter(|axis| x.windows(2).all(|pair| axis.index(pair[0]) < axis.index(pair[1])))
            .ok_or_else(|| format!("the {} points x z are not at even distances; they must be", x.len()))?;
        let mut notes: Vec<String> = axis.note("x").into_iter().collect();
        if axis.count > x.len() {
            let missing = axis.count - x.len();
            notes.push(format!(
                "{missing} of {} points of the profile are not in the list; they are undefined",
                axis.count
            ));
        }
        let mut on_axis = Array2::from_elem((axis.count, 1), f64::NAN);
        for (x, height) in x.iter().zip(heights) {
            on_axis[[axis.index(*x), 0]] = height;
        }
        Ok(Map { heights: on_axis, lengths: Some([axis.length(), 1.0]), notes, ..Map::default() })
    }

    /// Reads the surface through points x y z on a lattice; lattice points missing from the list are undefined.
    ///
    /// # Errors
    /// Coordinates that may be rounded or have gaps, in rows that are otherwise a list.
    fn surface(self, rows: &Rows) -> Result<Option<Map>, String> {
        let Some(y) = self.y else { return Ok(None) };
        let coordinates = [self.x, y].map(|column| rows.column(column).collect::<Vec<_>>());
        let [count_x, count_y] = [0, 1].map(|axis| axis::count(&coordinates[axis]));
        let is_list = count_x > 1 && count_y > 1 && 2 * count_x.saturating_mul(count_y) <= 3 * rows.rows;
        let along = |index: usize, name: &str, column: usize| match Axis::of(&coordinates[index], rows.digit(column)) {
            Err(reason) if is_list => Err(format!("the coordinates {name} are not even: {reason}")),
            found => Ok(found.unwrap_or_default()),
        };
        let (Some(x), Some(y)) = (along(0, "x", self.x)?, along(1, "y", y)?) else { return Ok(None) };
        if x.count < 2 || y.count < 2 || x.count.checked_mul(y.count).is_none_or(|most| most > SPARSEST * rows.rows) {
            return Ok(None);
        }
        let mut heights = Array2::from_elem((x.count, y.count), f64::NAN);
        let mut seen = Array2::from_elem((x.count, y.count), false);
        for ((at_x, at_y), z) in coordinates[0].iter().zip(&coordinates[1]).zip(rows.column(self.z)) {
            let place = [x.index(*at_x), y.index(*at_y)];
            if std::mem::replace(&mut seen[place], true) {
                return Ok(None);
            }
            heights[place] = z;
        }
        let notes = [x.note("x"), y.note("y")].into_iter().flatten().collect();
        Ok(Some(Map { heights, lengths: Some([x.length(), y.length()]), notes, ..Map::default() }))
    }
}
