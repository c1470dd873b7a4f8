//! Sizes from coordinates, and the names of datasets in files.

use ndarray::{Array2, Axis};

/// Relative deviation of a coordinate from even spacing that counts as rounding.
const EVEN: f64 = 1e-6;

/// Largest error of a step of rounded coordinates, in spacings.
const MOST_ROUNDING: f64 = 0.1;

/// Largest distance of a coordinate from its lattice point, in spacings.
const OFF: f64 = 1e-3;

/// Splits `FILE.h5:/dataset` into path and dataset; the dataset is empty for the name of an HDF5 file. Returns `None`
/// for any other name.
pub fn split(name: &str) -> Option<(&str, &str)> {
    let is_archive = |path: &str| {
        let path = path.to_ascii_lowercase();
        [".h5", ".hdf5"].iter().any(|ending| path.ends_with(ending))
    };
    match name.rsplit_once(":/") {
        Some((path, _)) if is_archive(path) => Some((path, &name[path.len() + 1..])),
        _ if is_archive(name) => Some((name, "")),
        _ => None,
    }
}

/// Units of length that denote any consistent unit.
pub const CONSISTENT: [&str; 3] = ["", "1", "length"];

/// Computes cell lengths from evenly spaced coordinates `x` and `y` in the group of a dataset, if any. `values` returns
/// the values of a dataset, or `None` if it does not exist. The second length of a profile is 1 and has no meaning.
///
/// # Errors
/// Coordinates that are unevenly spaced.
pub fn lengths(
    values: impl Fn(&str) -> Option<Result<Vec<f64>, String>>,
    dataset: &str,
    points: [usize; 2],
) -> Result<Option<[f64; 2]>, String> {
    let group = dataset.rsplit_once('/').map_or("", |(group, _)| group);
    let length = |axis: &str, points: usize| -> Result<Option<f64>, String> {
        let name = format!("{group}/{axis}");
        values(&name).map_or(Ok(None), |values| evenly_spaced(&values?, points, &name, 0.0))
    };
    let [nx, ny] = points;
    let along_y = if ny == 1 { Some(1.0) } else { length("y", ny)? };
    Ok(length("x", nx)?.zip(along_y).map(|(x, y)| [x, y]))
}

/// Returns the period of n evenly spaced coordinates, n times the spacing, negative if they fall. Returns `None` if the
/// number of coordinates is not n. Each coordinate has an error of `rounding`.
pub(crate) fn evenly_spaced(
    coordinates: &[f64],
    points: usize,
    name: &str,
    rounding: f64,
) -> Result<Option<f64>, String> {
    if coordinates.len() != points || points < 2 {
        return Ok(None);
    }
    let spacing = (coordinates[points - 1] - coordinates[0]) / (points - 1) as f64;
    let allowed = (EVEN * spacing.abs()).max((3.0 * rounding).min(MOST_ROUNDING * spacing.abs()));
    let is_even = |pair: &&[f64]| (pair[1] - pair[0] - spacing).abs() <= allowed;
    match coordinates.windows(2).find(|pair| !is_even(pair)) {
        Some(pair) => Err(format!(
            "a step of the coordinates {name} is {}; it must be {spacing}, since they must be evenly spaced",
            pair[1] - pair[0]
        )),
        None => Ok(Some(spacing * points as f64)),
    }
}

/// Makes negative lengths, which belong to falling coordinates, positive, and reverses the heights so that coordinates
/// rise. Returns a note for each such axis.
pub(crate) fn rising(heights: &mut Array2<f64>, lengths: &mut [f64; 2]) -> Vec<String> {
    let falling = [("x", 0), ("y", 1)].into_iter().filter(|(_, axis)| lengths[*axis] < 0.0);
    let notes = falling.map(|(name, axis)| {
        heights.invert_axis(Axis(axis));
        format!("the coordinates {name} fall; the heights are turned so that {name} rises")
    });
    let notes = notes.collect();
    *lengths = lengths.map(f64::abs);
    notes
}

/// Lattice of evenly spaced coordinates along one axis.
pub(crate) struct Lattice {
    first: f64,
    pub(crate) step: f64,
    pub(crate) count: usize,
}

impl Lattice {
    /// Finds the lattice of coordinates in any order, each with any number of occurrences; `None` if there is none.
    pub(crate) fn of(coordinates: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = coordinates.collect();
        sorted.sort_by(f64::total_cmp);
        let (first, last) = (*sorted.first()?, *sorted.last()?);
        let apart = 1e-9 * (last - first);
        sorted.dedup_by(|next, before| *next - *before <= apart);
        let count = sorted.len();
        let step = (last - first) / count.saturating_sub(1) as f64;
        let on_lattice = |(index, x): (usize, &f64)| ((x - first) / step - index as f64).abs() <= OFF;
        (step > 0.0 && sorted.iter().enumerate().all(on_lattice)).then_some(Self { first, step, count })
    }

    /// Returns the index of a coordinate on the lattice.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a coordinate begins at the first")]
    pub(crate) fn index(&self, coordinate: f64) -> usize {
        (((coordinate - self.first) / self.step).round() as usize).min(self.count - 1)
    }
}
