//! Arrays of NumPy.

use std::fs::File;
use std::io::BufReader;

use ndarray::ArrayD;
use ndarray_npy::{ReadNpyError, ReadNpyExt};

use super::{Found, two_dimensional};

/// Heights of an `.npy` file.
pub(super) fn read(path: &str) -> Result<Found, String> {
    let array = read_any(path)?;
    let shape = array.shape().to_vec();
    let heights = two_dimensional(&shape, array.into_iter().collect())?;
    Ok(Found { heights, lengths: None, unit: None, channel: None })
}

/// The floats of an `.npy` file, whatever its dimensions.
pub(crate) fn read_any(path: &str) -> Result<ArrayD<f64>, String> {
    let open = || File::open(path).map(BufReader::new).map_err(|error| error.to_string());
    let array = match ArrayD::<f64>::read_npy(open()?) {
        Err(ReadNpyError::WrongDescriptor(_)) => ArrayD::<f32>::read_npy(open()?).map(|array| array.mapv(f64::from)),
        other => other,
    };
    array.map_err(|error| match error {
        ReadNpyError::WrongDescriptor(found) => {
            format!("floats of 64 or 32 bits ('<f8', '<f4') are allowed, found {found}")
        }
        other => other.to_string(),
    })
}
