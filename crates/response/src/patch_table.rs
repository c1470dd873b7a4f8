use std::f64::consts::PI;

use std::ops::RangeInclusive;

use gfmd_field::{Grid, Share, Transform};
use gfmd_green::GreenError;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::elastic::fits;

/// Compliance between two cells of a patch, tabulated by their distance up to half of the padded grid, and the
/// transforms of the padded grid. Each process has the values for its rows of this grid.
pub(crate) struct PatchTable<T> {
    pub(crate) transform: Transform,
    /// Rows of the padded grid of this process.
    pub(crate) share: Share,
    /// Values by the distance `[i, j]` in cells, i and j ≥ 0, from the first distance i of these rows.
    near: Vec<T>,
    /// First distance i.
    first: usize,
    /// Distance along each axis, in cells, from which odd values fall to zero; half of the grid if they do not.
    reach: [usize; 2],
}

/// Symmetry of a value under reversal of the distance along an axis.
#[derive(Clone, Copy)]
pub(crate) enum Parity {
    Even,
    Odd,
}

impl Parity {
    /// Returns the factor for distance `index` among `points`. Odd values vanish where the images of the patch meet.
    fn factor(self, index: usize, points: usize) -> f64 {
        match self {
            Self::Even => 1.0,
            Self::Odd if 2 * index == points => 0.0,
            Self::Odd if 2 * index < points => 1.0,
            Self::Odd => -1.0,
        }
    }
}

impl<T: Send + Sync> PatchTable<T> {
    /// Tabulates `between([i, j])` for a padded grid with `times` the points of the `patch`, shared by the processes of
    /// `share`. If there is room between the images of the patch, odd values fall smoothly to zero there. A step would
    /// be a force at short waves.
    ///
    /// # Errors
    /// Returns an error if the padded grid has more points than memory can address, or rows that the processes cannot
    /// share.
    pub(crate) fn padded_to(
        times: usize,
        patch: &Grid,
        share: &Share,
        between: impl Fn([usize; 2]) -> T + Sync,
    ) -> Result<Self, GreenError> {
        let cell = patch.padded_to(times)?;
        let share = if share.is_whole() { cell.whole() } else { share.of_another(cell.rows())? };
        let [rows, columns] = cell.points().map(|points| points / 2 + 1);
        let distances = if share.is_whole() { 0..=rows - 1 } else { distances(&share, cell.points()[0]) };
        let (first, count) = (*distances.start(), distances.count());
        let near = (0..count * columns).into_par_iter();
        let near = near.map(|index| between([first + index / columns, index % columns])).collect();
        let reach = if times > 2 { patch.points() } else { cell.points().map(|points| points / 2) };
        Ok(Self { near, first, transform: Transform::distributed(cell, &share), share, reach })
    }

    /// Computes Σ_r k(r) e^{−i q·r} over the padded grid for the modes of this process, laid out as [`Grid::modes`];
    /// `of` selects the component k of the entries.
    pub(crate) fn spectrum(&self, of: impl Fn(&T) -> f64, parity: [Parity; 2]) -> Vec<Complex64> {
        let cell = *self.transform.grid();
        let [nx, ny] = cell.points();
        let columns = ny / 2 + 1;
        let is_odd = parity.iter().any(|parity| matches!(parity, Parity::Odd));
        let factors = [0, 1].map(|axis| {
            let points = cell.points()[axis];
            let falls = |i: usize| if is_odd { fall(i.min(points - i), self.reach[axis], points / 2) } else { 1.0 };
            (0..points).map(|i| parity[axis].factor(i, points) * falls(i)).collect::<Vec<f64>>()
        });
        let at = |index: usize| {
            let [i, j] = [index / ny, index % ny];
            let value = of(&self.near[(i.min(nx - i) - self.first) * columns + j.min(ny - j)]);
            factors[0][i] * factors[1][j] * value
        };
        let field: Vec<f64> = self.share.own().map(at).collect();
        let [_, lane] = cell.spectrum_shape();
        let mut spectrum = vec![Complex64::ZERO; self.transform.lanes().len() * lane];
        fits(self.transform.forward(&field, &mut spectrum, &mut self.transform.workspace()));
        spectrum.iter_mut().for_each(|mode| *mode *= cell.len() as f64);
        spectrum
    }
}

/// Returns the distances of the own rows from the first row of a periodic cell with `rows` rows.
fn distances(share: &Share, rows: usize) -> RangeInclusive<usize> {
    let of_row = |i: usize| i.min(rows - i);
    let [least, most] = share.rows().map(of_row).fold([rows, 0], |[least, most], i| [least.min(i), most.max(i)]);
    least..=most
}

/// Returns the factor of an odd value at a `distance` between the `reach` of the patch and `half` of the grid.
fn fall(distance: usize, reach: usize, half: usize) -> f64 {
    if distance < reach || reach == half {
        return 1.0;
    }
    let part = (distance + 1 - reach) as f64 / (half + 1 - reach) as f64;
    (0.5 * PI * part).cos().powi(2)
}
