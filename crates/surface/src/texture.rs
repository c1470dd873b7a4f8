//! The texture of a surface: autocorrelation, distributions, roughness against distance, bearing curve.

mod bearing;
mod correlation;
mod distribution;
mod scales;

pub use bearing::{Bearing, Core};
pub use correlation::{Autocorrelation, CorrelationLengths};
pub use distribution::{Density, Distributions};
pub use scales::Scales;

use gfmd_field::Grid;
use ndarray::Array2;

use crate::SurfaceError;

/// Functions that describe the texture of a surface, in addition to its spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The autocorrelation of the heights.
    pub autocorrelation: Autocorrelation,
    /// The distributions of height, slope and curvature.
    pub distributions: Distributions,
    /// Slope and curvature against the distance over which they are measured.
    pub scales: Scales,
    /// The bearing curve.
    pub bearing: Bearing,
}

impl Texture {
    /// The texture of heights `[nx, ny]`, or of a profile `[n, 1]`; differences cross the edges of the cell if it
    /// `repeats`.
    ///
    /// # Errors
    /// Heights of another shape than the grid, or not finite.
    pub fn of(heights: &Array2<f64>, grid: &Grid, repeats: bool) -> Result<Self, SurfaceError> {
        Ok(Self {
            autocorrelation: Autocorrelation::of(heights, grid, repeats)?,
            distributions: Distributions::of(heights, grid, repeats)?,
            scales: Scales::of(heights, grid, repeats)?,
            bearing: Bearing::of(heights, grid)?,
        })
    }
}
