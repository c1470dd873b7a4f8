//! Files of NumPy arrays (`.npy`).

use std::io;

pub use gfmd_topography::npy::{parse, read};
use ndarray::ArrayViewD;
use ndarray_npy::WriteNpyExt;

use crate::{FileError, Output};

/// Writes an array to the claimed path.
///
/// # Errors
/// A file that cannot be written.
pub fn write(output: &Output, array: ArrayViewD<f64>) -> Result<(), FileError> {
    output.write(|file| array.write_npy(file).map_err(io::Error::other))
}
