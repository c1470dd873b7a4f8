use std::f64::consts::PI;

use gfmd_field::{Grid, GridError, Transform};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::elastic::fits;

/// Compliance between two cells of a patch, tabulated by their distance up to half of the padded grid, and the
/// transforms of the padded grid.
pub(crate) struct PatchTable<T> {
    pub(crate) transform: Transform,
    /// Values by the distance `[i, j]` in cells, i and j ≥ 0.
    near: Vec<T>,
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
    /// Tabulates `between([i, j])` for the padded grid of `patch`.
    ///
    /// # Errors
    /// Returns an error if the padded grid has more points than memory can address.
    pub(crate) fn new(patch: &Grid, between: impl Fn([usize; 2]) -> T + Sync) -> Result<Self, GridError> {
        Self::padded_to(2, patch, between)
    }

    /// Tabulates `between([i, j])` for a padded grid with `times` the points of the `patch`. If there is room between
    /// the images of the patch, odd values fall smoothly to zero there. A step would be a force at short waves.
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new).
    pub(crate) fn padded_to(
        times: usize,
        patch: &Grid,
        between: impl Fn([usize; 2]) -> T + Sync,
    ) -> Result<Self, GridError> {
        let cell = patch.padded_to(times)?;
        let [rows, columns] = cell.points().map(|points| points / 2 + 1);
        let near = (0..rows * columns).into_par_iter().map(|index| between([index / columns, index % columns]));
        let reach = if times > 2 { patch.points() } else { cell.points().map(|points| points / 2) };
        Ok(Self { near: near.collect(), transform: Transform::new(cell), reach })
    }

    /// Computes Σ_r k(r) e^{−i q·r} over the padded grid, laid out as [`Grid::modes`]; `of` selects the component k of
    /// the entries.
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
            let value = of(&self.near[i.min(nx - i) * columns + j.min(ny - j)]);
            factors[0][i] * factors[1][j] * value
        };
        let field: Vec<f64> = (0..cell.len()).map(at).collect();
        let mut spectrum = vec![Complex64::ZERO; cell.spectrum_len()];
        fits(self.transform.forward(&field, &mut spectrum, &mut self.transform.workspace()));
        spectrum.iter_mut().for_each(|mode| *mode *= cell.len() as f64);
        spectrum
    }
}

/// Returns the factor of an odd value at a `distance` between the `reach` of the patch and `half` of the grid.
fn fall(distance: usize, reach: usize, half: usize) -> f64 {
    if distance < reach || reach == half {
        return 1.0;
    }
    let part = (distance + 1 - reach) as f64 / (half + 1 - reach) as f64;
    (0.5 * PI * part).cos().powi(2)
}
