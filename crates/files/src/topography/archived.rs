//! Heights from datasets of HDF5 files of any program.

use crate::Reader;

use super::{Found, two_dimensional};

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

/// Reads the heights of a dataset, and the lengths from evenly spaced coordinates `x` and `y` in its group, if any.
pub(super) fn read(path: &str, dataset: &str) -> Result<Found, String> {
    let reader = Reader::open(path).map_err(|error| error.to_string())?;
    if dataset.is_empty() {
        let names = reader.names("/").join(", ");
        return Err(format!(
            "no dataset is named; it must be named, such as {path}:/surface/height; the file holds {names}"
        ));
    }
    let shape = reader.shape(dataset).map_err(|error| error.to_string())?;
    let values = reader.values::<f64>(dataset).map_err(|error| error.to_string())?;
    let heights = two_dimensional(&shape, values)?;
    let lengths = lengths(&reader, dataset, heights.dim().into())?;
    // "length" and "1" stand for any consistent unit.
    let unit = reader.text(dataset, "units").ok().filter(|unit| !["", "1", "length"].contains(&unit.as_str()));
    Ok(Found { heights, lengths, unit, channel: None })
}

/// Cell lengths from evenly spaced coordinates `x` and `y` in the group of a dataset, if any. The second length of a
/// profile is 1 and has no meaning.
///
/// # Errors
/// Coordinates that are unevenly spaced.
pub fn lengths(reader: &Reader, dataset: &str, points: [usize; 2]) -> Result<Option<[f64; 2]>, String> {
    let group = dataset.rsplit_once('/').map_or("", |(group, _)| group);
    let length = |axis: &str, points: usize| -> Result<Option<f64>, String> {
        let name = format!("{group}/{axis}");
        match reader.contains(&name) {
            true => evenly_spaced(&reader.values::<f64>(&name).map_err(|error| error.to_string())?, points, &name),
            false => Ok(None),
        }
    };
    let [nx, ny] = points;
    let along_y = if ny == 1 { Some(1.0) } else { length("y", ny)? };
    Ok(length("x", nx)?.zip(along_y).map(|(x, y)| [x, y]))
}

/// The period of n evenly spaced coordinates, n times the spacing; `None` if the number of coordinates is not n.
fn evenly_spaced(coordinates: &[f64], points: usize, name: &str) -> Result<Option<f64>, String> {
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
