//! Fields on a periodic grid, as variables of an archive.

use std::borrow::Cow;

use gfmd_field::Grid;
use ndarray::ArrayRef2;

use crate::Dimension;

/// The dimensions x and y of a grid, with the positions of its points.
pub fn axes(grid: &Grid, unit: &str) -> [Dimension; 2] {
    let positions = |axis: usize| (0..grid.points()[axis]).map(|i| i as f64 * grid.spacing()[axis]).collect();
    [
        Dimension::values("x", positions(0), unit, "position along x"),
        Dimension::values("y", positions(1), unit, "position along y"),
    ]
}

/// The values of a field, row-major as in a file.
pub fn contiguous(field: &ArrayRef2<f64>) -> Cow<'_, [f64]> {
    field.as_slice().map_or_else(|| field.iter().copied().collect::<Vec<_>>().into(), Into::into)
}
