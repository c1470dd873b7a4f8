use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use gfmd_vector::{Messages, Share, Split};
use num_complex::Complex64;
use rayon::prelude::*;
use rustdct::TransformType2And3;

use crate::plan::{check, check_rows};
use crate::{Grid, Real, ShapeError};
use gfmd_plan::Plans as _;

/// Operators that are diagonal in the cosine waves of a patch, cos(π m (i + ½)/nx) cos(π n (j + ½)/ny), for fields
/// mirrored beyond the edges. Planned once and shared between threads.
///
/// A kernel has one value per wave, `[n, m]` (transposed: m is contiguous). A grid with one point along an axis is a
/// single row. The result has the same bits for any number of threads.
///
/// ```
/// use gfmd_field::{Cosines, Grid, Rows};
///
/// let grid = Grid::line(8, 1.0)?;
/// let cosines = Cosines::new(grid);
/// let wave: Vec<f64> = (0..8).map(|i| (std::f64::consts::PI * 3.0 * (i as f64 + 0.5) / 8.0).cos()).collect();
/// let kernel: Vec<f64> = (0..8).map(|m| f64::from(m) * 0.5).collect();
/// let mut out = vec![0.0; 8];
/// cosines.apply(
///     &kernel,
///     (),
///     |_, (), row| row.copy_from_slice(&wave),
///     Rows(&mut out[..], 8),
///     |_, row, Rows(out, _)| out.copy_from_slice(row),
///     &mut cosines.workspace(),
/// )?;
/// assert!(out.iter().zip(&wave).all(|(out, wave)| (out - 1.5 * wave).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Cosines<T = f64> {
    grid: Grid,
    /// Number of rows, and of points in each row.
    shape: [usize; 2],
    share: Share,
    /// Columns of each process.
    columns: Vec<Range<usize>>,
    along_x: Arc<dyn TransformType2And3<T>>,
    along_y: Arc<dyn TransformType2And3<T>>,
}

/// Working memory of one caller of [`Cosines`]: two fields, and as much for messages between several processes.
pub struct CosineWorkspace<T = f64> {
    rows: Vec<T>,
    columns: Vec<T>,
    messages: Messages,
}

/// Smallest number of values in the rows that a thread takes at a time.
const PORTION: usize = 1 << 13;
/// Side of the square tiles of a transposition; two tiles fit the first-level cache.
const TILE: usize = 32;

impl<T: Real> Cosines<T> {
    /// Plans the transforms of `grid`.
    pub fn new(grid: Grid) -> Self {
        Self::distributed(grid, &grid.whole())
    }

    /// Plans the transforms of the rows in the `share` of this process. A kernel has its [`columns`](Self::columns);
    /// every process makes the same calls. The results have the same bits as with one process.
    pub fn distributed(grid: Grid, share: &Share) -> Self {
        let shape = grid.rows();
        let [along_x, along_y] = T::cosines(shape);
        let ([_, ny], size) = (shape, share.all_rows().len());
        let columns = (0..size).map(|rank| ny * rank / size..ny * (rank + 1) / size).collect();
        Self { grid, shape, share: share.clone(), columns, along_x, along_y }
    }

    /// Returns the columns, the numbers n of the waves, of the kernel of this process.
    pub fn columns(&self) -> Range<usize> {
        self.columns[self.share.ranks().rank()].clone()
    }

    /// Allocates the memory for a call.
    pub fn workspace(&self) -> CosineWorkspace<T> {
        let ([nx, ny], rows) = (self.shape, self.share.rows().len());
        CosineWorkspace {
            rows: vec![T::ZERO; rows * ny],
            columns: vec![T::ZERO; self.columns().len() * nx],
            messages: Messages::default(),
        }
    }

    /// Multiplies every wave of a field by its value of the `kernel`. `source(i, input, row)` fills the rows of the
    /// field, and `sink(i, row, output)` gets each row of the result; see
    /// [`Transform::convolve_rows`](crate::Transform::convolve_rows) for inputs and outputs.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn apply<I: Split, O: Split>(
        &self,
        kernel: &[T],
        input: I,
        source: impl Fn(usize, I, &mut [T]) + Sync,
        output: O,
        sink: impl Fn(usize, &mut [T], O) + Sync,
        ws: &mut CosineWorkspace<T>,
    ) -> Result<(), ShapeError> {
        let ([nx, ny], own) = (self.shape, self.share.rows().len());
        check("kernel", kernel.len(), self.columns().len() * nx)?;
        check("workspace", ws.rows.len(), own * ny)?;
        check_rows(&input, own)?;
        check_rows(&output, own)?;
        let CosineWorkspace { rows, columns, messages } = ws;
        each_row(rows, input, &*self.along_y, |i, row, input, plan, scratch| {
            source(i, input, row);
            plan.process_dct2_with_scratch(row, scratch);
        });
        self.to_columns(rows, columns, messages);
        // A pair of transforms multiplies by half the number of points.
        let scale = T::nearest(4.0 / (nx * ny) as f64);
        each_row(columns, (), &*self.along_x, |n, column, (), plan, scratch| {
            plan.process_dct2_with_scratch(column, scratch);
            column.iter_mut().zip(&kernel[n * nx..]).for_each(|(wave, k)| *wave *= *k * scale);
            plan.process_dct3_with_scratch(column, scratch);
        });
        turn(&self.share, columns, [&self.columns, self.share.all_rows()], rows, messages);
        each_row(rows, output, &*self.along_y, |i, row, output, plan, scratch| {
            plan.process_dct3_with_scratch(row, scratch);
            sink(i, row, output);
        });
        Ok(())
    }

    /// Transposes the rows of this process, together with the others, to its columns.
    fn to_columns(&self, rows: &[T], columns: &mut [T], messages: &mut Messages) {
        turn(&self.share, rows, [self.share.all_rows(), &self.columns], columns, messages);
    }
}

impl Cosines {
    /// Returns the quotients ⟨c, K c⟩/⟨c, c⟩ of every cosine wave c, laid out as a kernel, for the convolution K on the
    /// patch with the even kernel `kernel([i, j])` (see [`Convolution`](crate::Convolution)). They define the operator
    /// diagonal in the cosines that is nearest to K; it is positive definite if K is (Chan, Chan and Wong 1999).
    pub fn quotients(&self, kernel: impl Fn([usize; 2]) -> f64 + Sync) -> Vec<f64> {
        let [nx, ny] = self.shape;
        let (is_line, first) = (self.grid.is_line(), self.share.rows().start);
        let CosineWorkspace { mut rows, mut columns, mut messages } = self.workspace();
        rows.par_chunks_mut(ny).enumerate().with_min_len(portion(ny)).for_each(|(i, row)| {
            let i = first + i;
            row.iter_mut().enumerate().for_each(|(j, k)| *k = kernel(if is_line { [j, i] } else { [i, j] }));
        });
        quotients_along(&mut rows, ny);
        self.to_columns(&rows, &mut columns, &mut messages);
        quotients_along(&mut columns, nx);
        columns
    }
}

/// Replaces every row of values k(a) at the distances a = 0, 1, … by the quotients of its cosine waves. With θ = π m/n,
/// Σ_i 2 cos(θ(i + ½)) cos(θ(i + a + ½)) = (n − a) cos(θ a) − sin(θ a)/sin θ, summed over both points inside the row.
fn quotients_along(rows: &mut [f64], length: usize) {
    let (fft, _) = f64::complex(2 * length);
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

/// Applies `work` to all rows in parallel, each with its part of `others` and each thread with its own scratch.
fn each_row<T: Real, V: Split>(
    field: &mut [T],
    others: V,
    plan: &dyn TransformType2And3<T>,
    work: impl Fn(usize, &mut [T], V, &dyn TransformType2And3<T>, &mut [T]) + Sync,
) {
    let length = rustdct::rustfft::Length::len(plan);
    let rows = portion(length);
    let portions = field.chunks_mut(rows * length).zip(others.parts(rows)).enumerate();
    portions.par_bridge().for_each_init(
        || vec![T::ZERO; plan.get_scratch_len()],
        |scratch, (number, (portion, others))| {
            for (i, (row, others)) in portion.chunks_exact_mut(length).zip(others.parts(1)).enumerate() {
                work(number * rows + i, row, others, plan, scratch);
            }
        },
    );
}

/// Returns the smallest number of rows that a thread takes at a time.
fn portion(length: usize) -> usize {
    1 + PORTION / length
}

/// Transposes a field with lines shared by processes into `out`. Each process gives the lines of its part of the first
/// division, and gets the lines across them of its part of the second one.
fn turn<T: Real>(
    share: &Share,
    field: &[T],
    [given, taken]: [&[Range<usize>]; 2],
    out: &mut [T],
    messages: &mut Messages,
) {
    let [across, length] = [given, taken].map(|parts| parts.last().map_or(0, |part| part.end));
    if share.is_whole() {
        return transpose(field, length, out);
    }
    let (own, wanted) = (given[share.ranks().rank()].len(), taken[share.ranks().rank()].len());
    let mut buffers = std::mem::take(messages);
    let words = |lines: usize, values: usize| T::words(lines * values);
    buffers.out_lengths = taken.iter().map(|part| words(own, part.len())).collect();
    buffers.into_lengths = given.iter().map(|part| words(part.len(), wanted)).collect();
    buffers.out.resize(buffers.out_lengths.iter().sum(), 0);
    buffers.into.resize(buffers.into_lengths.iter().sum(), 0);
    let mut rest = &mut buffers.out[..];
    let mut pieces = Vec::new();
    for (part, length) in taken.iter().zip(&buffers.out_lengths) {
        let (piece, after) = rest.split_at_mut(*length);
        pieces.push((part, piece));
        rest = after;
    }
    // Each piece has the columns of one process, one after another.
    pieces.into_par_iter().for_each_init(Vec::new, |block, (part, piece)| {
        block.resize(own * part.len(), T::ZERO);
        for (line, values) in field.chunks_exact(length).enumerate() {
            let values = &values[part.clone()];
            values.iter().enumerate().for_each(|(column, value)| block[column * own + line] = *value);
        }
        T::pack(block, piece);
    });
    let arrived = share.ranks().post(buffers).wait();
    let mut rest = &arrived.into[..];
    let mut block = Vec::new();
    for (part, words) in given.iter().zip(&arrived.into_lengths) {
        let (piece, after) = rest.split_at(*words);
        rest = after;
        block.resize(part.len() * wanted, T::ZERO);
        T::unpack(piece, &mut block);
        // A process may have no lines.
        if !part.is_empty() {
            let lines = out.par_chunks_mut(across).zip(block.par_chunks(part.len())).with_min_len(portion(across));
            lines.for_each(|(line, values)| line[part.clone()].copy_from_slice(values));
        }
    }
    *messages = arrived;
}

/// Transposes `field`, which has rows of `length` values, into `out`.
fn transpose<T: Real>(field: &[T], length: usize, out: &mut [T]) {
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

impl<T> fmt::Debug for Cosines<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cosines").field("grid", &self.grid).finish_non_exhaustive()
    }
}

impl<T> fmt::Debug for CosineWorkspace<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CosineWorkspace").finish_non_exhaustive()
    }
}
