use std::ops::Range;

use gfmd_field::{Grid, GridError, Transform};

use super::LANES;
use super::compliance_of;
use crate::NormalResponse;
use crate::elastic::fits;

/// Kernel between two points, tabulated by their distance along x and y. N blocks of a row have points within reach of
/// one block.
#[derive(Debug)]
pub(super) struct Stencil<const N: usize> {
    /// Largest distance, in points.
    reach: usize,
    table: Vec<f32>,
    wide: Range<usize>,
}

/// Smallest number of blocks that a row of a kernel reaches: the block itself, and one on each side.
pub(super) const NARROW: usize = 3;

/// Distance in points from an axis up to which a kernel has ripples along the axis.
const RIPPLE: usize = 1;

impl<const N: usize> Stencil<N> {
    /// Length of a row of the table.
    const WIDTH: usize = (N + 1) * LANES - 1;

    /// Tabulates the kernel with the spectrum `of(q, G)` up to a distance `radius` in length, and near the axes up to
    /// `reach` in points. It is computed on a periodic cell of fewer `points`, which divide the points of the grid, so
    /// that the waves of the cell are waves of the grid.
    pub(super) fn new(
        response: &NormalResponse,
        points: [usize; 2],
        (reach, radius): (usize, f64),
        of: impl Fn(f64, f64) -> f64,
    ) -> Result<Self, GridError> {
        let grid = response.grid();
        let times = [0, 1].map(|axis| grid.points()[axis] / points[axis]);
        let lengths = [0, 1].map(|axis| grid.lengths()[axis] / times[axis] as f64);
        let cell = Grid::new(points, lengths)?;
        let modes = cell.modes().map(|mode| {
            let compliance = compliance_of(response, [0, 1].map(|axis| mode.number[axis] * times[axis] as i64));
            (of(mode.wavenumber(), compliance) / cell.len() as f64).into()
        });
        let modes: Vec<_> = modes.collect();
        let transform = Transform::new(cell);
        let mut field = vec![0.0; cell.len()];
        fits(transform.inverse(&modes, &mut field, &mut transform.workspace()));
        let mut table = vec![0.0; (2 * reach + 1) * Self::WIDTH];
        for (i, row) in table.chunks_exact_mut(Self::WIDTH).enumerate() {
            for (j, value) in row[Self::WIDTH / 2 - reach..].iter_mut().take(2 * reach + 1).enumerate() {
                let [i, j] = [i, j].map(|k| k.abs_diff(reach));
                let distance = (i as f64 * grid.spacing()[0]).hypot(j as f64 * grid.spacing()[1]);
                *value = if distance < radius || i.min(j) <= RIPPLE { field[i * points[1] + j] as f32 } else { 0.0 };
            }
        }
        let reaches = |row: &[f32]| {
            let narrow = (Self::WIDTH + 1 - (NARROW + 1) * LANES) / 2;
            row[..narrow].iter().chain(&row[Self::WIDTH - narrow..]).any(|value| *value != 0.0)
        };
        let wide = table.chunks_exact(Self::WIDTH).position(reaches).unwrap_or(reach);
        Ok(Self { reach, table, wide: wide..2 * reach + 1 - wide })
    }

    /// Returns the largest distance, in points.
    pub(super) fn reach(&self) -> usize {
        self.reach
    }

    /// Returns the rows in which the kernel reaches N blocks; in other rows it reaches [`NARROW`].
    pub(super) fn wide(&self) -> &Range<usize> {
        &self.wide
    }

    /// Iterates over the kernel for targets `k` − reach rows after the source, skipping `without` blocks at its start.
    /// The values from lane l to all lanes of the blocks within reach begin at `LANES` − 1 − l.
    #[inline(always)]
    pub(super) fn rows(&self, k: Range<usize>, without: usize) -> impl Iterator<Item = &[f32]> {
        self.table[k.start * Self::WIDTH..k.end * Self::WIDTH]
            .chunks_exact(Self::WIDTH)
            .map(move |row| &row[without * LANES..])
    }
}
