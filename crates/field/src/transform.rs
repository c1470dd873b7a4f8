use std::fmt;
use std::sync::Arc;

use num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

use crate::Grid;

/// The planned Fourier transforms of one grid: built once, shared between threads.
pub struct Transform {
    grid: Grid,
    to_half: Arc<dyn RealToComplex<f64>>,
    from_half: Arc<dyn ComplexToReal<f64>>,
    ahead: Arc<dyn Fft<f64>>,
    back: Arc<dyn Fft<f64>>,
}

/// Working memory of one caller, made by [`Transform::workspace`] and used again at every call.
pub struct Workspace {
    spectrum: Vec<Complex64>,
    real: Vec<f64>,
    half: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

/// A slice of the wrong length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {what} has {found} values, this grid needs {expected}")]
pub struct ShapeError {
    /// Which argument.
    pub what: &'static str,
    /// Its length.
    pub found: usize,
    /// The length it must have.
    pub expected: usize,
}

impl Transform {
    /// Plans the transforms of `grid`.
    pub fn new(grid: Grid) -> Self {
        let [nx, ny] = grid.points();
        let mut real = RealFftPlanner::new();
        let mut complex = FftPlanner::new();
        let [row, column] = if grid.is_line() { [nx, 1] } else { [ny, nx] };
        Self {
            grid,
            to_half: real.plan_fft_forward(row),
            from_half: real.plan_fft_inverse(row),
            ahead: complex.plan_fft_forward(column),
            back: complex.plan_fft_inverse(column),
        }
    }

    /// The grid that was planned for.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// All memory that a call needs.
    pub fn workspace(&self) -> Workspace {
        let scratch = [
            self.to_half.get_scratch_len(),
            self.from_half.get_scratch_len(),
            self.ahead.get_inplace_scratch_len(),
            self.back.get_inplace_scratch_len(),
        ];
        Workspace {
            spectrum: vec![Complex64::ZERO; self.grid.spectrum_len()],
            real: self.to_half.make_input_vec(),
            half: self.to_half.make_output_vec(),
            scratch: vec![Complex64::ZERO; scratch.into_iter().max().unwrap_or(0)],
        }
    }

    /// f̃(q) = (1/N) Σ_r f(r) e^{−i q·r}, laid out as [`Grid::modes`].
    ///
    /// # Errors
    /// A slice or a workspace of another grid's size.
    pub fn forward(&self, field: &[f64], spectrum: &mut [Complex64], ws: &mut Workspace) -> Result<(), ShapeError> {
        check("field", field.len(), self.grid.len())?;
        check("spectrum", spectrum.len(), self.grid.spectrum_len())?;
        self.check_workspace(ws)?;
        self.spectrum_of(field, spectrum, &mut ws.real, &mut ws.half, &mut ws.scratch);
        Ok(())
    }

    /// f(r) = Σ_q f̃(q) e^{+i q·r} over the full spectrum, of which the stored half is given. Its real part, where
    /// the half is not that of a real field: imaginary parts of self-conjugate modes are without effect.
    ///
    /// # Errors
    /// A slice or a workspace of another grid's size.
    pub fn inverse(&self, spectrum: &[Complex64], field: &mut [f64], ws: &mut Workspace) -> Result<(), ShapeError> {
        check("spectrum", spectrum.len(), self.grid.spectrum_len())?;
        check("field", field.len(), self.grid.len())?;
        self.check_workspace(ws)?;
        ws.spectrum.copy_from_slice(spectrum);
        self.field_of(&mut ws.spectrum, field, &mut ws.real, &mut ws.half, &mut ws.scratch);
        Ok(())
    }

    /// `out` ← F⁻¹\[k F\[field\]\], the real kernel k laid out as [`Grid::modes`].
    ///
    /// # Errors
    /// A slice or a workspace of another grid's size.
    pub fn convolve(
        &self,
        kernel: &[f64],
        field: &[f64],
        out: &mut [f64],
        ws: &mut Workspace,
    ) -> Result<(), ShapeError> {
        check("kernel", kernel.len(), self.grid.spectrum_len())?;
        check("field", field.len(), self.grid.len())?;
        check("output", out.len(), self.grid.len())?;
        self.check_workspace(ws)?;
        self.spectrum_of(field, &mut ws.spectrum, &mut ws.real, &mut ws.half, &mut ws.scratch);
        for (mode, k) in ws.spectrum.iter_mut().zip(kernel) {
            *mode *= k;
        }
        self.field_of(&mut ws.spectrum, out, &mut ws.real, &mut ws.half, &mut ws.scratch);
        Ok(())
    }

    /// Σ_q w k |f̃|² = (1/N) Σ_r f (K f), with w the weight of a mode. Takes the forward half only.
    ///
    /// # Errors
    /// A slice or a workspace of another grid's size.
    pub fn quadratic_form(&self, kernel: &[f64], field: &[f64], ws: &mut Workspace) -> Result<f64, ShapeError> {
        check("kernel", kernel.len(), self.grid.spectrum_len())?;
        check("field", field.len(), self.grid.len())?;
        self.check_workspace(ws)?;
        self.spectrum_of(field, &mut ws.spectrum, &mut ws.real, &mut ws.half, &mut ws.scratch);
        Ok(self.grid.modes().zip(&ws.spectrum).zip(kernel).map(|((mode, f), k)| mode.weight * k * f.norm_sqr()).sum())
    }

    fn check_workspace(&self, ws: &Workspace) -> Result<(), ShapeError> {
        check("workspace", ws.spectrum.len(), self.grid.spectrum_len())?;
        check("workspace row", ws.half.len(), self.to_half.complex_len())
    }

    fn spectrum_of(
        &self,
        field: &[f64],
        spectrum: &mut [Complex64],
        real: &mut [f64],
        half: &mut [Complex64],
        scratch: &mut [Complex64],
    ) {
        let columns = field.len() / real.len();
        let scale = 1.0 / field.len() as f64;
        for (i, row) in field.chunks_exact(real.len()).enumerate() {
            real.copy_from_slice(row);
            let done = self.to_half.process_with_scratch(real, half, scratch);
            debug_assert!(done.is_ok());
            for (j, value) in half.iter().enumerate() {
                spectrum[j * columns + i] = value * scale;
            }
        }
        self.ahead.process_with_scratch(spectrum, scratch);
    }

    fn field_of(
        &self,
        spectrum: &mut [Complex64],
        field: &mut [f64],
        real: &mut [f64],
        half: &mut [Complex64],
        scratch: &mut [Complex64],
    ) {
        let columns = field.len() / real.len();
        if columns > 1 {
            self.back.process_with_scratch(spectrum, scratch);
        }
        for (i, row) in field.chunks_exact_mut(real.len()).enumerate() {
            for (j, value) in half.iter_mut().enumerate() {
                *value = spectrum[j * columns + i];
            }
            half[0].im = 0.0;
            if real.len().is_multiple_of(2) {
                half[real.len() / 2].im = 0.0;
            }
            let done = self.from_half.process_with_scratch(half, row, scratch);
            debug_assert!(done.is_ok());
        }
    }
}

impl fmt::Debug for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Transform").field("grid", &self.grid).finish_non_exhaustive()
    }
}

fn check(what: &'static str, found: usize, expected: usize) -> Result<(), ShapeError> {
    if found == expected { Ok(()) } else { Err(ShapeError { what, found, expected }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for points in [[8, 8], [7, 6], [6, 7], [5, 9], [1, 6], [6, 1], [7, 1], [1, 1], [1, 5], [2, 2]] {
            let grid = Grid::new(points, [1.0, 2.0]).unwrap();
            let transform = Transform::new(grid);
            let mut ws = transform.workspace();
            let field: Vec<f64> = (0..grid.len()).map(|i| (0.618 * i as f64).fract()).collect();
            let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
            let mut back = vec![0.0; grid.len()];
            transform.forward(&field, &mut spectrum, &mut ws).unwrap();
            let mean = field.iter().sum::<f64>() / grid.len() as f64;
            assert!((spectrum[0].re - mean).abs() < 1e-15);
            transform.inverse(&spectrum, &mut back, &mut ws).unwrap();
            assert!(field.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-14), "{points:?}");
        }
    }
}
