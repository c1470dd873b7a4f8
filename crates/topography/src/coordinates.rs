//! Sizes from coordinates, and the names of datasets in files.

/// Relative deviation of a coordinate from even spacing that counts as rounding.
const EVEN: f64 = 1e-6;

/// Splits `FILE.h5:/dataset` into path and dataset; the dataset is empty for the name of an HDF5 file. `None` for any
/// other name.
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

/// Units of lengths that denote any consistent unit.
pub const CONSISTENT: [&str; 3] = ["", "1", "length"];

/// Cell lengths from evenly spaced coordinates `x` and `y` in the group of a dataset, if any. `values` returns those of
/// a dataset, or `None` if there is no such dataset. The second length of a profile is 1 and has no meaning.
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
        values(&name).map_or(Ok(None), |values| evenly_spaced(&values?, points, &name))
    };
    let [nx, ny] = points;
    let along_y = if ny == 1 { Some(1.0) } else { length("y", ny)? };
    Ok(length("x", nx)?.zip(along_y).map(|(x, y)| [x, y]))
}

/// The period of n evenly spaced coordinates, n times the spacing; `None` if the number of coordinates is not n.
pub(crate) fn evenly_spaced(coordinates: &[f64], points: usize, name: &str) -> Result<Option<f64>, String> {
    if coordinates.len() != points || points < 2 {
        return Ok(None);
    }
    let spacing = (coordinates[points - 1] - coordinates[0]) / (points - 1) as f64;
    let uneven = coordinates.windows(2).find(|pair| (pair[1] - pair[0] - spacing).abs() > EVEN * spacing.abs());
    match uneven {
        Some(pair) => Err(format!(
            "a step of the coordinates {name} is {}; it must be {spacing}, since they must be evenly spaced",
            pair[1] - pair[0]
        )),
        None => Ok(Some(spacing * points as f64)),
    }
}
