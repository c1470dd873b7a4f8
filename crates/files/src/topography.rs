//! Surfaces from files: NumPy arrays, HDF5 datasets, and text files of instruments.
//!
//! | name               | contents                                                | sizes and units                |
//! |--------------------|---------------------------------------------------------|--------------------------------|
//! | `FILE.npy`         | NumPy array, 1-D or 2-D, floats of 32 or 64 bits        | none                           |
//! | `FILE.h5:/dataset` | HDF5 dataset of numbers, 1-D or 2-D                     | coordinates `x`, `y` beside it |
//! | any other          | text: a matrix of numbers, a line per y, a column per x | header, as `# Width: 10 µm`    |
//!
//! Heights are returned as `[x, y]`, a 1-D array as `[n, 1]`. Points without a height are an error, which gives their
//! number and the first of them; they are never filled in.

pub(crate) mod archived;
mod matrix;

#[cfg(test)]
mod tests;

use ndarray::Array2;

use crate::npy;

/// Heights with the sizes and the unit given in their file.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    /// Heights `[x, y]` in `unit`, row-major; all finite.
    pub heights: Array2<f64>,
    /// Size of the scanned field along x and y in `unit`, n times the spacing, if the file has it. The second size of a
    /// profile is 1 and has no meaning.
    pub lengths: Option<[f64; 2]>,
    /// Unit of heights and lengths, if the file has it.
    pub unit: Option<String>,
    /// Description of file and channel.
    pub source: String,
}

/// Error of reading a topography: one line that starts with the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct TopographyError {
    /// Name of the file as given by the caller.
    pub file: String,
    /// Description of the error, with the value found and the values allowed.
    pub reason: String,
}

/// Contents of a file before the checks common to all formats.
#[derive(Debug)]
struct Found {
    heights: Array2<f64>,
    lengths: Option<[f64; 2]>,
    unit: Option<String>,
    channel: Option<String>,
}

impl Topography {
    /// Reads the file `name`, in one of the formats in the table of this module.
    ///
    /// # Errors
    /// A file that cannot be read, has another format than its name says, or has points without a height.
    pub fn read(name: &str) -> Result<Self, TopographyError> {
        let fail = |reason| TopographyError { file: name.into(), reason };
        let found = match archived::split(name) {
            Some((path, dataset)) => archived::read(path, dataset),
            None if name.to_ascii_lowercase().ends_with(".npy") => array(name),
            None => matrix::read(name),
        };
        let Found { heights, lengths, unit, channel } = found.map_err(fail)?;
        let (nx, ny) = heights.dim();
        if nx == 0 || ny == 0 {
            return Err(fail(format!("the shape of the array is [{nx}, {ny}]; it must have at least one point")));
        }
        check_complete(&heights).map_err(fail)?;
        if let Some(lengths) = lengths.filter(|lengths| !lengths.iter().all(|l| l.is_finite() && *l > 0.0)) {
            return Err(fail(format!("the size is {} by {}; it must be positive and finite", lengths[0], lengths[1])));
        }
        let source = match channel {
            Some(channel) => format!("{name}, channel {channel}"),
            None => name.into(),
        };
        Ok(Self { heights: heights.as_standard_layout().into_owned(), lengths, unit, source })
    }
}

/// Reads the heights of an `.npy` file.
fn array(path: &str) -> Result<Found, String> {
    let array = npy::read(path)?;
    let shape = array.shape().to_vec();
    let heights = two_dimensional(&shape, array.into_iter().collect())?;
    Ok(Found { heights, lengths: None, unit: None, channel: None })
}

/// Returns an error with the number of points without a height and the first of them, if there are any.
fn check_complete(heights: &Array2<f64>) -> Result<(), String> {
    let mut missing = heights.indexed_iter().filter(|(_, h)| !h.is_finite());
    let Some(((i, j), value)) = missing.next() else { return Ok(()) };
    Err(format!(
        "{} of {} points have no finite height, the first ({value}) at [x, y] = [{i}, {j}]; every point must \
         have a height: fill them in first",
        1 + missing.count(),
        heights.len()
    ))
}

/// Converts an array of one or two dimensions to `[x, y]`.
fn two_dimensional(shape: &[usize], values: Vec<f64>) -> Result<Array2<f64>, String> {
    let [nx, ny] = match *shape {
        [n] => [n, 1],
        [1, n] if n > 1 => {
            return Err(format!("the shape of the array is [1, {n}]; a profile must have the shape [{n}] or [{n}, 1]"));
        }
        [nx, ny] => [nx, ny],
        _ => return Err(format!("the shape of the array is {shape:?}; it must have 1 or 2 dimensions")),
    };
    let count = values.len();
    Array2::from_shape_vec((nx, ny), values)
        .map_err(|_| format!("the array has {count} values for the shape {shape:?}"))
}
