//! Arrays in files.

use gfmd_files::{FileError, Reader, npy, split_dataset};
use ndarray::ArrayD;

/// The array in FILE.npy or FILE.h5:/dataset.
///
/// # Errors
/// A file that cannot be read, or has no such dataset.
pub(crate) fn read(name: &str) -> Result<ArrayD<f64>, String> {
    let Some((path, dataset)) = split_dataset(name) else { return npy::read(name) };
    let words = |error: FileError| error.to_string();
    let reader = Reader::open(path).map_err(words)?;
    if dataset.is_empty() {
        return Err("it must be FILE.npy or FILE.h5:/dataset".into());
    }
    let shape = reader.shape(dataset).map_err(words)?;
    ArrayD::from_shape_vec(shape, reader.values(dataset).map_err(words)?).map_err(|error| error.to_string())
}
