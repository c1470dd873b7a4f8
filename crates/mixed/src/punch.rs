use gfmd_field::Grid;
use ndarray::Array2;

use crate::MixedError;

/// Flat punch in the middle of the cell, of equal widths along x and y (a strip on a line grid), and the points that it
/// covers.
///
/// [`Edge`] sets whether points on its edge are covered. This choice changes the width of the punch that the points
/// represent; see [`effective_width`](Self::effective_width).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatPunch {
    fraction: f64,
    edge: Edge,
}

/// Treatment of points on the edge of a punch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Edge {
    /// Points on the edge are not covered: (1 − f)/2 < x/L < (1 + f)/2.
    #[default]
    Strict,
    /// Points on the edge are covered.
    Inclusive,
}

/// Distance from an edge, in spacings, up to which a point counts as on it.
const ON_EDGE: f64 = 1e-9;

impl FlatPunch {
    /// Makes a punch with a width of `fraction` of the cell along each axis.
    ///
    /// # Errors
    /// A fraction that is not between 0 and 1, both excluded.
    pub fn new(fraction: f64, edge: Edge) -> Result<Self, MixedError> {
        if fraction > 0.0 && fraction < 1.0 { Ok(Self { fraction, edge }) } else { Err(MixedError::Fraction(fraction)) }
    }

    /// Returns the points under the punch; there may be none.
    pub fn points(&self, grid: &Grid) -> Array2<bool> {
        let [nx, ny] = grid.points();
        Array2::from_shape_fn((nx, ny), |(i, j)| self.covers(i, nx) && (grid.is_line() || self.covers(j, ny)))
    }

    /// Returns the number of points under the punch along x.
    pub fn points_across(&self, grid: &Grid) -> usize {
        let n = grid.points()[0];
        (0..n).filter(|i| self.covers(*i, n)).count()
    }

    /// Returns the width along x, in length, of the sharp-edged punch on the continuum with the nearest force. By
    /// measurement, N points act as a punch of about N − 1/3 spacings. With either [`Edge`] the force error is thus of
    /// first order in the spacing; it is half as large if the edge is included (docs/solvers.md).
    pub fn effective_width(&self, grid: &Grid) -> f64 {
        (self.points_across(grid) as f64 - 1.0 / 3.0) * grid.spacing()[0]
    }

    fn covers(&self, i: usize, n: usize) -> bool {
        // Distance beyond the edge, in half spacings.
        let beyond = (2.0 * i as f64 - n as f64).abs() - self.fraction * n as f64;
        match self.edge {
            Edge::Strict => beyond < -2.0 * ON_EDGE,
            Edge::Inclusive => beyond <= 2.0 * ON_EDGE,
        }
    }
}
