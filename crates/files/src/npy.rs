//! Files of NumPy arrays (`.npy`).

use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use ndarray::{ArrayD, ArrayViewD};
use ndarray_npy::{ReadNpyError, ReadNpyExt, WriteNpyExt};

use crate::{FileError, Output};

/// Reads an array of floats of any shape.
///
/// # Errors
/// A file that cannot be read or does not contain floats. The message does not contain the path.
pub fn read(path: impl AsRef<Path>) -> Result<ArrayD<f64>, String> {
    let open = || File::open(&path).map(BufReader::new).map_err(|error| error.to_string());
    let array = match ArrayD::<f64>::read_npy(open()?) {
        Err(ReadNpyError::WrongDescriptor(_)) => ArrayD::<f32>::read_npy(open()?).map(|array| array.mapv(f64::from)),
        other => other,
    };
    array.map_err(|error| match error {
        ReadNpyError::WrongDescriptor(found) => {
            format!("the entries have the type {found}; they must be floats of 64 or 32 bits ('<f8', '<f4')")
        }
        other => other.to_string(),
    })
}

/// Writes an array to the claimed path.
///
/// # Errors
/// A file that cannot be written.
pub fn write(output: &Output, array: ArrayViewD<f64>) -> Result<(), FileError> {
    output.write(|file| array.write_npy(file).map_err(io::Error::other))
}
