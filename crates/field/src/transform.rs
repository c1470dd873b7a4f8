use ndrustfft::{Complex, FftHandler, Normalization, R2cFftHandler, ndfft, ndfft_r2c, ndifft, ndifft_r2c};
use num_complex::Complex64;

use crate::Grid;

/// The planned Fourier transforms of one grid: built once, shared between threads.
pub struct Transform {
    grid: Grid,
}

/// Working memory of one caller, made by [`Transform::workspace`] and used again at every call.
pub struct Workspace {
    half: Vec<Complex64>,
}

/// A slice of the wrong length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {what} has {found} values, this grid needs {expected}")]
pub struct ShapeError {
    /// Which argument.
    pub what: &'static str,
    /// Its length.
    pub found: usize,
    /// The length it must have.
    pub expected: usize,
}
