use gfmd_field::{Grid, GridError, Transform};

use super::LANES;
use super::compliance_of;
use crate::NormalResponse;
use crate::elastic::fits;

/// A kernel between two points, by their distance along x and y. N blocks of a row have points within reach of one of them.
#[derive(Debug)]
pub(super) struct Stencil<const N: usize> {
    /// The largest distance, in points.
    reach: usize,
    table: Vec<f32>,
}

impl<const N: usize> Stencil<N> {
    /// The length of a row of the table.
    const WIDTH: usize = (N + 1) * LANES - 1;

    /// The kernel whose value for the wave q is `of(q, G)`, up to `reach`. It is computed on a periodic cell of fewer `points`, which
    /// divide those of the grid: its waves are waves of the grid.
    pub(super) fn new(
        response: &NormalResponse,
        points: [usize; 2],
        reach: usize,
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
                *value = field[i.abs_diff(reach) * points[1] + j.abs_diff(reach)] as f32;
            }
        }
        Ok(Self { reach, table })
    }

    /// The largest distance, in points.
    pub(super) fn reach(&self) -> usize {
        self.reach
    }

    /// The kernel for targets `k` − reach rows behind the source. The values from its lane l to all lanes of all blocks within reach
    /// begin at `LANES` − 1 − l.
    pub(super) fn row(&self, k: usize) -> &[f32] {
        &self.table[k * Self::WIDTH..(k + 1) * Self::WIDTH]
    }
}
