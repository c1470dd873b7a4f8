use gfmd_field::{Grid, GridError, Transform};

use super::LANES;
use super::compliance_of;
use crate::NormalResponse;
use crate::elastic::fits;

/// A kernel between two points, by their distance along x and y.
#[derive(Debug)]
pub(super) struct Stencil {
    /// The largest distance, in points.
    pub(super) reach: usize,
    width: usize,
    table: Vec<f32>,
}

impl Stencil {
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
        let blocks = reach.div_ceil(LANES);
        let width = 2 * (blocks * LANES + LANES - 1) + 1;
        let mut stencil = Self { reach, width, table: vec![0.0; (2 * reach + 1) * width] };
        for i in 0..2 * reach + 1 {
            for j in 0..2 * reach + 1 {
                let near = field[i.abs_diff(reach) * points[1] + j.abs_diff(reach)];
                stencil.table[i * width + width / 2 + j - reach] = near as f32;
            }
        }
        Ok(stencil)
    }

    /// The largest number of blocks along a row between two that have points within reach, so many rows apart.
    pub(super) fn blocks(&self, down: isize) -> usize {
        let along = (self.reach.pow(2) - down.unsigned_abs().pow(2)).isqrt();
        along.div_ceil(LANES)
    }

    /// The place of the value for the points with the same lane of two blocks, of which the target lies `down` rows behind the source
    /// and `along` blocks behind it.
    pub(super) fn place(&self, down: isize, along: isize) -> u32 {
        let row = (down + self.reach as isize) as usize;
        (row * self.width + (self.width / 2).wrapping_add_signed(along * LANES as isize)) as u32
    }

    /// The values from a lane of the source to all lanes of the target.
    pub(super) fn values(&self, place: u32, lane: usize) -> &[f32; LANES] {
        let start = place as usize - lane;
        self.table[start..].first_chunk().expect("a place in the table")
    }
}
