//! Fields on a periodic grid, as variables of an archive.

use crate::Dimension;
use gfmd_field::Grid;

/// Returns the dimensions x and y of a grid, with the positions of its points.
pub fn axes(grid: &Grid, unit: &str) -> [Dimension; 2] {
    let positions = |axis: usize| (0..grid.points()[axis]).map(|i| i as f64 * grid.spacing()[axis]).collect();
    [
        Dimension::values("x", positions(0), unit, "position along x"),
        Dimension::values("y", positions(1), unit, "position along y"),
    ]
}
