//! Filling of undefined points from the heights around them.

mod harmonic;
mod nearest;

use ndarray::{Array2, ArrayRef2};

use crate::SurfaceError;
use crate::error::positive;
use crate::names::named;

/// Method to fill undefined points (NaN).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    /// Solution of Laplace's equation with the defined heights as boundary values. The sum over neighbours of (h −
    /// h′)/d² is zero at every undefined point, without neighbours beyond the edges. The fill adds no maxima or minima
    /// and has the smallest rms gradient. Its relative residual is below 10⁻⁹.
    Harmonic,
    /// Height of the nearest defined point. Of several, the one with the lowest x, then the lowest y.
    Nearest,
}

named! { Fill, "fill":
    Harmonic = "harmonic", "the solution of Laplace's equation between the defined points";
    Nearest = "nearest", "the height of the nearest defined point";
}

/// Returns the heights with undefined points (NaN) filled. Defined heights do not change. `spacing` is the distance
/// between points along x and y; only its ratio matters. The scan is not treated as periodic. The result is bitwise
/// identical for any number of threads.
///
/// # Errors
/// Infinite heights; no defined point; a spacing that is not positive; a solution that did not converge.
pub fn fill(heights: &ArrayRef2<f64>, spacing: [f64; 2], how: Fill) -> Result<Array2<f64>, SurfaceError> {
    let mut infinite = heights.indexed_iter().filter(|(_, height)| height.is_infinite());
    if let Some(((i, j), &value)) = infinite.next() {
        let count = 1 + infinite.count();
        return Err(SurfaceError::NotFinite { count, points: heights.len(), first: [i, j], value });
    }
    for step in spacing {
        positive("grid spacing", step)?;
    }
    let undefined = heights.iter().filter(|height| height.is_nan()).count();
    if undefined == heights.len() {
        return Err(SurfaceError::Undefined { points: heights.len() });
    }
    if undefined == 0 {
        return Ok(heights.as_standard_layout().into_owned());
    }
    let heights = heights.as_standard_layout().into_owned();
    match how {
        Fill::Harmonic => harmonic::fill(heights, spacing),
        Fill::Nearest => Ok(nearest::fill(&heights, spacing)),
    }
}
