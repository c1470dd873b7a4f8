use gfmd_field::{Grid, Real, Transform, Workspace};
use gfmd_vector::for_each;
use num_complex::Complex;

use crate::elastic::fits;

/// Transforms of one component with a complex factor for each mode, with their memory and a counter: the stiffness and
/// compliance of waves whose pressure leads the displacement.
///
/// # Panics
/// Every method panics if a field does not have the size of the grid, or a kernel not the number of its modes.
#[derive(Debug)]
pub struct ComplexTransforms<T> {
    transform: Transform<T>,
    workspace: Workspace<T>,
    spectrum: Vec<Complex<T>>,
    /// Number of pairs.
    pairs: u64,
}

impl<T: Real> ComplexTransforms<T> {
    /// Creates transforms on `grid`, with the counter at zero.
    pub fn new(grid: Grid) -> Self {
        let transform = Transform::new(grid);
        let spectrum = vec![Complex::new(T::nearest(0.0), T::nearest(0.0)); grid.spectrum_len()];
        Self { workspace: transform.workspace(), transform, spectrum, pairs: 0 }
    }

    /// Computes `out` = F⁻¹\[k F\[field\]\], with a complex kernel k laid out as [`Grid::modes`].
    pub fn convolve(&mut self, kernel: &[Complex<T>], field: &[T], out: &mut [T]) {
        self.pairs += 1;
        fits(self.transform.forward(field, &mut self.spectrum, &mut self.workspace));
        for_each((&mut self.spectrum[..], kernel), &|_, (spectrum, kernel)| {
            spectrum.iter_mut().zip(kernel).for_each(|(mode, k)| *mode *= *k);
        });
        fits(self.transform.inverse(&self.spectrum, out, &mut self.workspace));
    }

    /// Returns the number of pairs of forward and inverse transforms so far.
    pub fn pairs(&self) -> f64 {
        self.pairs as f64
    }
}
