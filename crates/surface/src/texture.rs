//! Surface texture: autocorrelation, distributions, roughness against distance, bearing curve.

mod bearing;
mod correlation;
mod direction;
mod distribution;
mod features;
mod profile;
pub(crate) mod ratio;
mod scales;

pub use bearing::Bearing;
pub use correlation::{Autocorrelation, CorrelationLengths};
pub use direction::Direction;
pub use distribution::{Density, Distributions};
pub use features::{Features, MotifEdges, Motifs};
pub use profile::ProfileNumbers;
pub use ratio::{Core, Volumes};
pub use scales::Scales;

use gfmd_field::Grid;
use ndarray::ArrayRef2;

use crate::SurfaceError;

/// Functions that describe the texture of a surface, in addition to its spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Autocorrelation of the heights.
    pub autocorrelation: Autocorrelation,
    /// Distributions of height, slope and curvature.
    pub distributions: Distributions,
    /// Slope and curvature against the distance of their measurement.
    pub scales: Scales,
    /// Bearing curve.
    pub bearing: Bearing,
}

impl Texture {
    /// Computes the texture of heights `[nx, ny]`, or of a profile `[n, 1]`. Differences cross the edges of the cell if
    /// it `repeats`.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid, repeats: bool) -> Result<Self, SurfaceError> {
        Ok(Self {
            autocorrelation: Autocorrelation::of(heights, grid, repeats)?,
            distributions: Distributions::of(heights, grid, repeats)?,
            scales: Scales::of(heights, grid, repeats)?,
            bearing: Bearing::of(heights, grid)?,
        })
    }
}
