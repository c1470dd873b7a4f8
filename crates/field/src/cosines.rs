use std::fmt;
use std::sync::Arc;

use num_complex::Complex64;
use rayon::prelude::*;
use rustdct::{DctPlanner, TransformType2And3};
use rustfft::FftPlanner;

use crate::transform::check;
use crate::{Grid, ShapeError};

/// Operators that are diagonal in the cosine waves of a patch, cos(π m (i + ½)/nx) cos(π n (j + ½)/ny): those of fields that
/// are continued beyond the edges by mirroring. They are planned once and shared between threads.
///
/// A kernel has one value for each wave, `[n, m]` (transposed: m is contiguous). A grid with one point along an axis is a
/// single row. The result has the same bits for any number of threads.
///
/// ```
/// use gfmd_field::{Cosines, Grid};
///
/// let grid = Grid::line(8, 1.0)?;
/// let cosines = Cosines::new(grid);
/// let wave: Vec<f64> = (0..8).map(|i| (std::f64::consts::PI * 3.0 * (i as f64 + 0.5) / 8.0).cos()).collect();
/// let kernel: Vec<f64> = (0..8).map(|m| f64::from(m) * 0.5).collect();
/// let mut out = vec![0.0; 8];
/// cosines.apply(&kernel, |_, row| row.copy_from_slice(&wave), &mut out, |_, _| {}, &mut cosines.workspace())?;
/// assert!(out.iter().zip(&wave).all(|(out, wave)| (out - 1.5 * wave).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Cosines {
    grid: Grid,
    /// The number of rows, and of points in each.
    shape: [usize; 2],
    along_x: Arc<dyn TransformType2And3<f64>>,
    along_y: Arc<dyn TransformType2And3<f64>>,
}

/// The working memory of one caller of [`Cosines`]: two fields.
pub struct CosineWorkspace {
    rows: Vec<f64>,
    columns: Vec<f64>,
}

/// The least number of values in the rows that a thread takes at a time.
const PORTION: usize = 1 << 13;
/// The side of the squares in which a field is transposed: two of them fit the first-level cache.
const TILE: usize = 32;

impl Cosines {
    /// Plans the transforms of `grid`.
    pub fn new(grid: Grid) -> Self {
        let shape = if grid.points().contains(&1) { [1, grid.len()] } else { grid.points() };
        let mut planner = DctPlanner::new();
        Self { grid, shape, along_x: planner.plan_dct2(shape[0]), along_y: planner.plan_dct2(shape[1]) }
    }

    /// Allocates the memory that a call needs.
    pub fn workspace(&self) -> CosineWorkspace {
        CosineWorkspace { rows: vec![0.0; self.grid.len()], columns: vec![0.0; self.grid.len()] }
    }

    /// Computes `out`: the field whose rows `source(i, row)` fills, with every wave multiplied by its value of the `kernel`;
    /// `sink(i, row)` gets each finished row and may change it. Each row is visited once, on any thread.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn apply(
        &self,
        kernel: &[f64],
        source: impl Fn(usize, &mut [f64]) + Sync,
        out: &mut [f64],
        sink: impl Fn(usize, &mut [f64]) + Sync,
        ws: &mut CosineWorkspace,
    ) -> Result<(), ShapeError> {
        check("kernel", kernel.len(), self.grid.len())?;
        check("output", out.len(), self.grid.len())?;
        check("workspace", ws.rows.len(), self.grid.len())?;
        let [nx, ny] = self.shape;
        let CosineWorkspace { rows, columns } = ws;
        each_row(rows, &*self.along_y, |i, row, plan, scratch| {
            source(i, row);
            plan.process_dct2_with_scratch(row, scratch);
        });
        transpose(rows, ny, columns);
        // A pair of transforms multiplies by half the number of points.
        let scale = 4.0 / (nx * ny) as f64;
        each_row(columns, &*self.along_x, |n, column, plan, scratch| {
            plan.process_dct2_with_scratch(column, scratch);
            column.iter_mut().zip(&kernel[n * nx..]).for_each(|(wave, k)| *wave *= k * scale);
            plan.process_dct3_with_scratch(column, scratch);
        });
        transpose(columns, nx, out);
        each_row(out, &*self.along_y, |i, row, plan, scratch| {
            plan.process_dct3_with_scratch(row, scratch);
            sink(i, row);
        });
        Ok(())
    }

    /// The quotients ⟨c, K c⟩/⟨c, c⟩ of every cosine wave c, laid out as a kernel, for the convolution K on the patch with
    /// the even kernel `kernel([i, j])` (see [`Convolution`](crate::Convolution)). Of all operators that are diagonal in the
    /// cosines, the one with these values is nearest to K, and it is positive definite if K is (Chan, Chan and Wong 1999).
    pub fn quotients(&self, kernel: impl Fn([usize; 2]) -> f64 + Sync) -> Vec<f64> {
        let [nx, ny] = self.shape;
        let is_line = self.grid.is_line();
        let mut rows = vec![0.0; nx * ny];
        let mut columns = vec![0.0; nx * ny];
        rows.par_chunks_mut(ny).enumerate().with_min_len(portion(ny)).for_each(|(i, row)| {
            row.iter_mut().enumerate().for_each(|(j, k)| *k = kernel(if is_line { [j, i] } else { [i, j] }));
        });
        quotients_along(&mut rows, ny);
        transpose(&rows, ny, &mut columns);
        quotients_along(&mut columns, nx);
        columns
    }
}

/// Replaces every row of values k(a) at the distances a = 0, 1, … by the quotients of its cosine waves. With θ = π m/n,
/// Σ_i 2 cos(θ(i + ½)) cos(θ(i + a + ½)) = (n − a) cos(θ a) − sin(θ a)/sin θ, summed over both points inside the row.
fn quotients_along(rows: &mut [f64], length: usize) {
    let fft = FftPlanner::new().plan_fft_forward(2 * length);
    let n = length as f64;
    let memory = || (vec![Complex64::ZERO; 2 * length], vec![Complex64::ZERO; fft.get_inplace_scratch_len()]);
    rows.par_chunks_mut(length).with_min_len(portion(length)).for_each_init(memory, |(line, scratch), row| {
        line.fill(Complex64::ZERO);
        for (a, (z, k)) in line.iter_mut().zip(&*row).enumerate() {
            let both = if a == 0 { *k } else { 2.0 * k };
            *z = Complex64::new((n - a as f64) * both, both);
        }
        fft.process_with_scratch(line, scratch);
        for (m, quotient) in row.iter_mut().enumerate() {
            let (ahead, back) = (line[m], line[(2 * length - m) % (2 * length)]);
            // The spectra of the real and of the imaginary part.
            let (cosines, sines) = (0.5 * (ahead.re + back.re), 0.5 * (ahead.re - back.re));
            let theta = std::f64::consts::PI * m as f64 / n;
            *quotient = if m == 0 { cosines / n } else { (cosines - sines / theta.sin()) / n };
        }
    });
}

/// Applies `work` to all rows in parallel, each thread with its own scratch.
fn each_row(
    field: &mut [f64],
    plan: &dyn TransformType2And3<f64>,
    work: impl Fn(usize, &mut [f64], &dyn TransformType2And3<f64>, &mut [f64]) + Sync,
) {
    let length = rustdct::rustfft::Length::len(plan);
    field
        .par_chunks_mut(length)
        .enumerate()
        .with_min_len(portion(length))
        .for_each_init(|| vec![0.0; plan.get_scratch_len()], |scratch, (i, row)| work(i, row, plan, scratch));
}

/// The least number of rows that a thread takes at a time.
fn portion(length: usize) -> usize {
    1 + PORTION / length
}

/// `out` ← the transpose of `field`, which has rows of `length` values.
fn transpose(field: &[f64], length: usize, out: &mut [f64]) {
    let rows = field.len() / length;
    out.par_chunks_mut(TILE * rows).enumerate().for_each(|(strip, out)| {
        for first in (0..rows).step_by(TILE) {
            for (column, out) in out.chunks_exact_mut(rows).enumerate() {
                let column = strip * TILE + column;
                for (row, out) in out.iter_mut().enumerate().skip(first).take(TILE) {
                    *out = field[row * length + column];
                }
            }
        }
    });
}

impl fmt::Debug for Cosines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cosines").field("grid", &self.grid).finish_non_exhaustive()
    }
}

impl fmt::Debug for CosineWorkspace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CosineWorkspace").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Convolution;

    fn wave(n: usize, m: usize) -> Vec<f64> {
        (0..n).map(|i| (std::f64::consts::PI * m as f64 * (i as f64 + 0.5) / n as f64).cos()).collect()
    }

    #[test]
    fn every_wave_is_multiplied_by_its_value_of_the_kernel() {
        for points in [[1, 1], [5, 1], [1, 6], [2, 3], [8, 8], [70, 33]] {
            let grid = Grid::new(points, [1.0, 2.0]).unwrap();
            let cosines = Cosines::new(grid);
            let mut ws = cosines.workspace();
            let kernel: Vec<f64> = (0..grid.len()).map(|k| 1.0 + (0.618_034 * k as f64).fract()).collect();
            let [nx, ny] = cosines.shape;
            for [m, n] in [[0, 0], [nx - 1, ny - 1], [nx / 2, 0], [0, ny / 2], [nx / 2, ny / 3]] {
                let (x, y) = (wave(nx, m), wave(ny, n));
                let mut out = vec![f64::NAN; grid.len()];
                let source = |i: usize, row: &mut [f64]| row.iter_mut().zip(&y).for_each(|(r, y)| *r = x[i] * y);
                cosines.apply(&kernel, source, &mut out, |_, _| {}, &mut ws).unwrap();
                for (index, out) in out.iter().enumerate() {
                    let exact = kernel[n * nx + m] * x[index / ny] * y[index % ny];
                    assert!((out - exact).abs() < 1e-13, "{points:?} {m} {n}: {out} {exact}");
                }
            }
        }
    }

    #[test]
    fn quotients_are_those_of_the_convolution() {
        let kernel = |[i, j]: [usize; 2]| 1.0 / (1.0 + (i as f64).hypot(1.3 * j as f64));
        for points in [[1, 1], [5, 1], [1, 6], [2, 3], [8, 8], [9, 12]] {
            let grid = Grid::new(points, [1.0, 2.0]).unwrap();
            let (cosines, convolution) = (Cosines::new(grid), Convolution::new(grid, kernel));
            let quotients = cosines.quotients(kernel);
            let [nx, ny] = cosines.shape;
            let mut ws = convolution.workspace();
            for n in 0..ny {
                for m in 0..nx {
                    let (x, y) = (wave(nx, m), wave(ny, n));
                    let field: Vec<f64> = x.iter().flat_map(|x| y.iter().map(move |y| x * y)).collect();
                    let square: f64 = field.iter().map(|f| f * f).sum();
                    let exact = convolution.quadratic_form(&field, &mut ws).unwrap() / square;
                    let found = quotients[n * nx + m];
                    assert!((found - exact).abs() < 1e-12, "{points:?} {m} {n}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        let cosines = Cosines::new(Grid::square(4, 1.0).unwrap());
        let mut ws = cosines.workspace();
        let mut out = vec![0.0; 16];
        assert!(cosines.apply(&[1.0; 15], |_, _| {}, &mut out, |_, _| {}, &mut ws).is_err());
        assert!(cosines.apply(&[1.0; 16], |_, _| {}, &mut out[..9], |_, _| {}, &mut ws).is_err());
        let mut other = Cosines::new(Grid::square(6, 1.0).unwrap()).workspace();
        assert!(cosines.apply(&[1.0; 16], |_, _| {}, &mut out, |_, _| {}, &mut other).is_err());
    }
}
