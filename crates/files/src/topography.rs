//! Surfaces from files: arrays of other programs, our own archives, and the text export of instruments.
//!
//! | name               | what                                                    | sizes and units                |
//! |--------------------|---------------------------------------------------------|--------------------------------|
//! | `FILE.npy`         | NumPy array, 1-D or 2-D, floats of 32 or 64 bits        | none                           |
//! | `FILE.h5:/dataset` | HDF5 dataset of numbers, 1-D or 2-D                     | coordinates `x`, `y` beside it |
//! | any other          | text: a matrix of numbers, a line per y, a column per x | `# Width: 10 µm` and the like  |
//!
//! Heights come out as `[x, y]`, a 1-D array as `[n, 1]`. A point without a height is an error that says where and how
//! many: no filling in behind the user's back.

pub(crate) mod archived;
mod matrix;

#[cfg(test)]
mod tests;

use ndarray::Array2;

use crate::npy;

/// Heights with what their file says about them.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    /// Heights `[x, y]` in `unit`, row-major; all finite.
    pub heights: Array2<f64>,
    /// Size of the scanned field along x and y in `unit`, n times the spacing, if the file has it. Of a profile, the
    /// second is 1 and means nothing.
    pub lengths: Option<[f64; 2]>,
    /// The unit of heights and lengths alike, if the file has it.
    pub unit: Option<String>,
    /// File and channel in words.
    pub source: String,
}

/// Why a file is no topography: one line that names it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct TopographyError {
    /// The file, as it was given.
    pub file: String,
    /// What was found and what is allowed.
    pub reason: String,
}

/// What a reader found, before the checks that all formats share.
#[derive(Debug)]
struct Found {
    heights: Array2<f64>,
    lengths: Option<[f64; 2]>,
    unit: Option<String>,
    channel: Option<String>,
}

impl Topography {
    /// Reads `name`: see the table of this module.
    ///
    /// # Errors
    /// A file that cannot be read, is something else than its name says, or has points without a height.
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
            return Err(fail(format!("an array without points, shape [{nx}, {ny}]")));
        }
        check_complete(&heights).map_err(fail)?;
        if let Some(lengths) = lengths.filter(|lengths| !lengths.iter().all(|l| l.is_finite() && *l > 0.0)) {
            return Err(fail(format!("sizes must be positive and finite, found {} by {}", lengths[0], lengths[1])));
        }
        let source = match channel {
            Some(channel) => format!("{name}, channel {channel}"),
            None => name.into(),
        };
        Ok(Self { heights: heights.as_standard_layout().into_owned(), lengths, unit, source })
    }
}

/// The heights of an `.npy` file.
fn array(path: &str) -> Result<Found, String> {
    let array = npy::read(path)?;
    let shape = array.shape().to_vec();
    let heights = two_dimensional(&shape, array.into_iter().collect())?;
    Ok(Found { heights, lengths: None, unit: None, channel: None })
}

/// An error that counts the points without a height and names the first.
fn check_complete(heights: &Array2<f64>) -> Result<(), String> {
    let mut missing = heights.indexed_iter().filter(|(_, h)| !h.is_finite());
    let Some(((i, j), value)) = missing.next() else { return Ok(()) };
    Err(format!(
        "{} of {} points have no finite height, the first ({value}) at [x, y] = [{i}, {j}]; fill them in before: every \
         point needs a height",
        1 + missing.count(),
        heights.len()
    ))
}

/// An array of one or two dimensions as `[x, y]`.
fn two_dimensional(shape: &[usize], values: Vec<f64>) -> Result<Array2<f64>, String> {
    let [nx, ny] = match *shape {
        [n] => [n, 1],
        [1, n] if n > 1 => return Err(format!("a profile has the shape [{n}] or [{n}, 1], found [1, {n}]")),
        [nx, ny] => [nx, ny],
        _ => return Err(format!("an array of 1 or 2 dimensions is allowed, found shape {shape:?}")),
    };
    let count = values.len();
    Array2::from_shape_vec((nx, ny), values).map_err(|_| format!("{count} values do not fill the shape {shape:?}"))
}
