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
        let cell = patch.padded()?;
        let [rows, columns] = cell.points().map(|points| points / 2 + 1);
        let near = (0..rows * columns).into_par_iter().map(|index| between([index / columns, index % columns]));
        Ok(Self { near: near.collect(), transform: Transform::new(cell) })
    }

    /// Computes Σ_r k(r) e^{−i q·r} over the padded grid, laid out as [`Grid::modes`]; `of` selects the component k of
    /// the entries.
    pub(crate) fn spectrum(&self, of: impl Fn(&T) -> f64, parity: [Parity; 2]) -> Vec<Complex64> {
        let cell = *self.transform.grid();
        let [nx, ny] = cell.points();
        let columns = ny / 2 + 1;
        let at = |index: usize| {
            let [i, j] = [index / ny, index % ny];
            let value = of(&self.near[i.min(nx - i) * columns + j.min(ny - j)]);
            parity[0].factor(i, nx) * parity[1].factor(j, ny) * value
        };
        let field: Vec<f64> = (0..cell.len()).map(at).collect();
        let mut spectrum = vec![Complex64::ZERO; cell.spectrum_len()];
        fits(self.transform.forward(&field, &mut spectrum, &mut self.transform.workspace()));
        spectrum.iter_mut().for_each(|mode| *mode *= cell.len() as f64);
        spectrum
    }
}
