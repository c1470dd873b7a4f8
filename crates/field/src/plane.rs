//! Two-dimensional grids: rows, then columns panel by panel.
//!
//! The rows of a field become half spectra in [`Block`]s of rows. A panel of neighbouring columns is then copied, block
//! by block, to memory in which each column is contiguous. It is transformed, multiplied by the kernel, transformed
//! back while it is in the second-level cache, and copied back. A convolution thus reads and writes memory three times,
//! and only [`Plane::forward`] and [`Plane::inverse`] use a transposed spectrum.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use gfmd_vector::{Rows, Split, distribute, lock};
use multiversion::multiversion;
use num_complex::Complex;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealToComplex};
use rustfft::Fft;

use crate::Real;
use crate::prefetch::{LINE, prefetch};
use crate::real::{copy, square};

/// Number of rows in a block: the part of a panel in one block fits the first-level cache.
pub(crate) const BLOCK: usize = 64;
/// Number of cache lines of every row in a panel of columns. It decreases, down to one line, if the columns are so long
/// that the panel would be larger than [`PANEL`].
const WIDTH: usize = 4;
/// Largest number of bytes in a panel: twice a second-level cache; half of it measured no better.
const PANEL: usize = 1 << 21;
/// Smallest number of values in the rows that a thread takes at a time.
const PORTION: usize = 1 << 14;
/// Number of values below which a transform ends before a second thread has woken up.
const SHARED: usize = 1 << 15;
/// Number of values above which a field no longer stays in the cache between two passes.
pub(crate) const LARGE: usize = 1 << 19;

/// Plans for nx rows of ny points. A field may fill only a corner; it is zero on the rest, which is not stored.
pub(crate) struct Plane<T> {
    rows: usize,
    points: usize,
    /// Number of rows of the field, and of points in each row.
    corner: [usize; 2],
    width: usize,
    to_half: Arc<dyn RealToComplex<T>>,
    from_half: Arc<dyn ComplexToReal<T>>,
    ahead: Arc<dyn Fft<T>>,
    back: Arc<dyn Fft<T>>,
}

/// Working memory: the half spectra of the rows, about as large as one field, and a panel for each thread.
#[derive(Default)]
pub(crate) struct Memory<T> {
    pub(crate) blocks: Vec<Block<T>>,
    pub(crate) workers: Vec<Worker<T>>,
    sums: Vec<f64>,
}

/// Half spectra of neighbouring rows. A row pass owns its block; a panel pass locks it while it copies its part in or
/// out.
pub(crate) type Block<T> = Mutex<Vec<Complex<T>>>;

/// Working memory of one thread.
pub(crate) struct Worker<T> {
    row: Vec<T>,
    tile: Vec<Complex<T>>,
    pub(crate) columns: Vec<Complex<T>>,
    pub(crate) scratch: Vec<Complex<T>>,
}

impl<T: Real> Plane<T> {
    /// Number of complex values in a cache line, which is also the number of unused values between neighbouring columns
    /// of a panel: columns that lie a power of two apart would evict each other from the cache.
    pub(crate) const GAP: usize = LINE / size_of::<Complex<T>>();

    /// Creates plans for fields that fill the `corner` of the points.
    pub(crate) fn new([rows, points]: [usize; 2], corner: [usize; 2]) -> Self {
        let ((to_half, from_half), (ahead, back)) = (T::real(points), T::complex(rows));
        let width = (PANEL / size_of::<Complex<T>>() / rows).clamp(Self::GAP, WIDTH * Self::GAP);
        Self { rows, points, corner, width: width.min(points / 2 + 1), to_half, from_half, ahead, back }
    }

    /// Allocates memory for this plan, with working memory for each of `threads`.
    pub(crate) fn memory(&self, threads: usize) -> Memory<T> {
        let threads = if self.rows * self.points < SHARED { 1 } else { threads.max(1) };
        let rows = self.corner[0];
        let block = |number| Mutex::new(vec![Complex::ZERO; BLOCK.min(rows - number * BLOCK) * self.stride()]);
        Memory {
            // All threads write the zeros.
            blocks: (0..rows.div_ceil(BLOCK)).into_par_iter().map(block).collect(),
            workers: (0..threads).map(|_| self.worker()).collect(),
            sums: vec![0.0; self.half()],
        }
    }

    fn worker(&self) -> Worker<T> {
        let scratch = [
            self.to_half.get_scratch_len(),
            self.from_half.get_scratch_len(),
            self.ahead.get_inplace_scratch_len(),
            self.back.get_inplace_scratch_len(),
        ];
        Worker {
            row: vec![T::ZERO; self.points],
            tile: vec![Complex::ZERO; BLOCK.min(self.corner[0]) * self.width],
            columns: vec![Complex::ZERO; self.width * self.column()],
            scratch: vec![Complex::ZERO; scratch.into_iter().max().unwrap_or(0)],
        }
    }

    /// Computes the spectrum f̃ of the rows that `source` fills.
    pub(crate) fn forward(
        &self,
        source: &(impl Fn(usize, &mut [T]) + Sync),
        spectrum: &mut [Complex<T>],
        memory: &mut Memory<T>,
    ) {
        self.rows_ahead((), &|i, (), row| source(i, row), self.corner[1], memory);
        let Memory { blocks, workers, .. } = memory;
        let scale = self.scale();
        distribute(
            workers,
            self.panels().zip(spectrum.chunks_mut(self.width * self.rows)),
            |(panel, columns), worker| {
                self.load(blocks, &panel, columns, self.rows, &mut worker.tile);
                let lines = columns.chunks_exact_mut(self.rows);
                lines.for_each(|column| column[self.corner[0]..].fill(Complex::ZERO));
                self.ahead.process_with_scratch(columns, &mut worker.scratch);
                columns.iter_mut().for_each(|mode| *mode *= scale);
            },
        );
    }

    /// Computes the field of the spectrum.
    pub(crate) fn inverse(&self, spectrum: &[Complex<T>], field: &mut [T], memory: &mut Memory<T>) {
        let Memory { blocks, workers, .. } = memory;
        distribute(workers, self.panels(), |panel, worker| {
            let columns = &mut worker.columns[..panel.len() * self.rows];
            columns.copy_from_slice(&spectrum[panel.start * self.rows..panel.end * self.rows]);
            self.back.process_with_scratch(columns, &mut worker.scratch);
            self.store(columns, self.rows, blocks, &panel, &mut worker.tile);
        });
        self.rows_back(Rows(field, self.corner[1]), &copy, memory);
    }

    /// Computes the half spectra of the rows of K f; `source` fills the rows of f from the rows of `input`, which has
    /// one entry per row.
    pub(crate) fn convolve<I: Split>(
        &self,
        kernel: &[T],
        input: I,
        source: &(impl Fn(usize, I, &mut [T]) + Sync),
        memory: &mut Memory<T>,
    ) {
        self.rows_ahead(input, source, self.corner[1], memory);
        let Memory { blocks, workers, .. } = memory;
        let line = kernel.len() / self.half();
        distribute(workers, self.panels(), |panel, Worker { tile, columns, scratch, .. }| {
            self.load(blocks, &panel, columns, self.column(), tile);
            let kernels = kernel[panel.start * line..panel.end * line].chunks_exact(line);
            for (column, kernel) in columns.chunks_exact_mut(self.column()).zip(kernels) {
                let column = &mut column[..self.rows];
                column[self.corner[0]..].fill(Complex::ZERO);
                self.filter(column, kernel, scratch);
            }
            self.store(columns, self.column(), blocks, &panel, tile);
        });
    }

    /// Returns Σ_q w k |f̃|² for the rows that `source` fills.
    pub(crate) fn quadratic_form(
        &self,
        kernel: &[T],
        source: &(impl Fn(usize, &mut [T]) + Sync),
        memory: &mut Memory<T>,
    ) -> f64 {
        self.rows_ahead((), &|i, (), row| source(i, row), self.corner[1], memory);
        let Memory { blocks, workers, sums } = memory;
        let line = kernel.len() / self.half();
        distribute(workers, self.panels().zip(sums.chunks_mut(self.width)), |(panel, sums), worker| {
            let Worker { tile, columns, scratch, .. } = worker;
            self.load(blocks, &panel, columns, self.column(), tile);
            let kernels = kernel[panel.start * line..].chunks_exact(line);
            let columns = columns.chunks_exact_mut(self.column());
            for ((sum, number), (column, kernel)) in sums.iter_mut().zip(panel).zip(columns.zip(kernels)) {
                let column = &mut column[..self.rows];
                column[self.corner[0]..].fill(Complex::ZERO);
                *sum = self.form(number, column, kernel, scratch);
            }
        });
        self.whole_form(sums)
    }

    /// Transforms a column of all rows, multiplies it by its part of the kernel, and transforms it back.
    pub(crate) fn filter(&self, column: &mut [Complex<T>], kernel: &[T], scratch: &mut [Complex<T>]) {
        let scale = self.scale();
        self.ahead(column, scratch);
        let (stored, mirrored) = column.split_at_mut(kernel.len());
        multiply(stored, kernel, scale);
        for (mode, k) in mirrored.iter_mut().rev().zip(&kernel[1..]) {
            *mode *= *k * scale;
        }
        self.back(column, scratch);
    }

    /// Transforms column `number` of all rows and returns its part of the quadratic form.
    pub(crate) fn form(
        &self,
        number: usize,
        column: &mut [Complex<T>],
        kernel: &[T],
        scratch: &mut [Complex<T>],
    ) -> f64 {
        self.ahead(column, scratch);
        let alone = number == 0 || 2 * number == self.points;
        let (stored, mirrored) = column.split_at(kernel.len());
        let mirrored: f64 = mirrored.iter().rev().zip(&kernel[1..]).map(|(mode, k)| k.widened() * square(mode)).sum();
        let weight = if alone { 1.0 } else { 2.0 };
        weight * (energy(stored, kernel) + mirrored)
    }

    /// Adds the parts of all columns to the quadratic form.
    pub(crate) fn whole_form(&self, parts: &[f64]) -> f64 {
        parts.iter().sum::<f64>() * (1.0 / (self.rows * self.points) as f64).powi(2)
    }

    /// Transforms a column.
    pub(crate) fn ahead(&self, column: &mut [Complex<T>], scratch: &mut [Complex<T>]) {
        self.ahead.process_with_scratch(column, scratch);
    }

    /// Transforms a column back.
    pub(crate) fn back(&self, column: &mut [Complex<T>], scratch: &mut [Complex<T>]) {
        self.back.process_with_scratch(column, scratch);
    }

    /// Computes the spectrum of a kernel that is even in both directions, for fields in the corner: a real quarter of
    /// it. `source(i, row)` fills the values at the distances 0, 1, … along a row; beyond the corner the kernel is
    /// zero.
    pub(crate) fn even(&self, source: &(impl Fn(usize, &mut [T]) + Sync), memory: &mut Memory<T>) -> Vec<T> {
        self.even_rows(source, memory);
        let Memory { blocks, workers, .. } = memory;
        let line = self.line();
        let mut kernel = vec![T::ZERO; self.half() * line];
        distribute(workers, self.panels().zip(kernel.chunks_mut(self.width * line)), |(panel, kernels), worker| {
            let Worker { tile, columns, scratch, .. } = worker;
            self.load(blocks, &panel, columns, self.column(), tile);
            for (column, kernel) in columns.chunks_exact_mut(self.column()).zip(kernels.chunks_exact_mut(line)) {
                self.even_column(self.corner[0], &mut column[..self.rows], kernel, scratch);
            }
        });
        kernel
    }

    /// Transforms the rows of a kernel that is even along each row; `source` fills their values at the distances 0, 1,
    /// ….
    pub(crate) fn even_rows(&self, source: &(impl Fn(usize, &mut [T]) + Sync), memory: &mut Memory<T>) {
        let [_, shown] = self.corner;
        let both_sides = |i: usize, (): (), row: &mut [T]| {
            row[shown..].fill(T::ZERO);
            source(i, &mut row[..shown]);
            let (near, far) = row.split_at_mut(shown);
            far.iter_mut().rev().zip(&near[1..]).for_each(|(far, near)| *far = *near);
        };
        self.rows_ahead((), &both_sides, self.points, memory);
    }

    /// Computes the stored half of a column of the spectrum of an even kernel from its first `held` values.
    pub(crate) fn even_column(
        &self,
        held: usize,
        column: &mut [Complex<T>],
        kernel: &mut [T],
        scratch: &mut [Complex<T>],
    ) {
        let (near, far) = column.split_at_mut(held);
        far.fill(Complex::ZERO);
        far.iter_mut().rev().zip(&near[1..]).for_each(|(far, near)| *far = *near);
        self.ahead.process_with_scratch(column, scratch);
        kernel.iter_mut().zip(column).for_each(|(k, mode)| *k = mode.re);
    }

    /// Transforms the rows of the field into half spectra; `source` fills their first `filled` points.
    pub(crate) fn rows_ahead<I: Split>(
        &self,
        input: I,
        source: &(impl Fn(usize, I, &mut [T]) + Sync),
        filled: usize,
        memory: &mut Memory<T>,
    ) {
        let rows = self.portion();
        let portions = portions(&mut memory.blocks, rows * self.stride()).zip(input.parts(rows)).enumerate();
        distribute(&mut memory.workers, portions, |(number, (portion, input)), Worker { row, scratch, .. }| {
            for (i, (half, input)) in portion.chunks_exact_mut(self.stride()).zip(input.parts(1)).enumerate() {
                let (own, padding) = row.split_at_mut(filled);
                source(number * rows + i, input, own);
                padding.fill(T::ZERO);
                let done = self.to_half.process_with_scratch(row, &mut half[..self.half()], scratch);
                done.expect("lengths are those of the plan");
            }
        });
    }

    /// Transforms half spectra back into rows of the field and passes them to `sink` with the rows of `output`.
    pub(crate) fn rows_back<O: Split>(
        &self,
        output: O,
        sink: &(impl Fn(usize, &mut [T], O) + Sync),
        memory: &mut Memory<T>,
    ) {
        let rows = self.portion();
        let large = self.corner[0] * self.corner[1] > LARGE;
        let portions = portions(&mut memory.blocks, rows * self.stride()).zip(output.parts(rows)).enumerate();
        distribute(&mut memory.workers, portions, |(number, (mut portion, output)), worker| {
            for (i, output) in output.parts(1).enumerate().take(portion.len() / self.stride()) {
                let (half, rest) = std::mem::take(&mut portion).split_at_mut(self.stride());
                portion = rest;
                if large && !portion.is_empty() {
                    prefetch(&portion[..self.stride()]);
                }
                let half = &mut half[..self.half()];
                half[0].im = T::ZERO;
                if self.points.is_multiple_of(2) {
                    half[self.points / 2].im = T::ZERO;
                }
                let done = self.from_half.process_with_scratch(half, &mut worker.row, &mut worker.scratch);
                done.expect("lengths are those of the plan, edges are real");
                sink(number * rows + i, &mut worker.row[..self.corner[1]], output);
            }
        });
    }

    /// Copies a panel from the blocks into columns, `stride` apart.
    fn load(
        &self,
        blocks: &[Block<T>],
        panel: &Range<usize>,
        columns: &mut [Complex<T>],
        stride: usize,
        tile: &mut [Complex<T>],
    ) {
        for (number, block) in blocks.iter().enumerate() {
            let rows = number * BLOCK..self.corner[0].min((number + 1) * BLOCK);
            for (to, from) in tile.chunks_exact_mut(panel.len()).zip(lock(block).chunks_exact(self.stride())) {
                to.copy_from_slice(&from[panel.clone()]);
            }
            for (place, column) in columns.chunks_mut(stride).take(panel.len()).enumerate() {
                for (to, from) in column[rows.clone()].iter_mut().zip(tile.chunks_exact(panel.len())) {
                    *to = from[place];
                }
            }
        }
    }

    /// Copies columns, `stride` apart, to the place of their panel in the blocks.
    fn store(
        &self,
        columns: &[Complex<T>],
        stride: usize,
        blocks: &[Block<T>],
        panel: &Range<usize>,
        tile: &mut [Complex<T>],
    ) {
        for (number, block) in blocks.iter().enumerate() {
            let rows = number * BLOCK..self.corner[0].min((number + 1) * BLOCK);
            for (place, column) in columns.chunks(stride).take(panel.len()).enumerate() {
                for (from, to) in column[rows.clone()].iter().zip(tile.chunks_exact_mut(panel.len())) {
                    to[place] = *from;
                }
            }
            for (from, to) in tile.chunks_exact(panel.len()).zip(lock(block).chunks_exact_mut(self.stride())) {
                to[panel.clone()].copy_from_slice(from);
            }
        }
    }

    /// Returns the number of rows of a transform.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of points of a row that a field may fill.
    pub(crate) fn shown(&self) -> usize {
        self.corner[1]
    }

    /// Returns the number of modes in the half spectrum of a row, which is the number of columns.
    fn half(&self) -> usize {
        self.points / 2 + 1
    }

    /// Returns the distance between rows of a block, a whole number of cache lines.
    pub(crate) fn stride(&self) -> usize {
        self.half().next_multiple_of(Self::GAP)
    }

    /// Returns the distance between columns of a panel.
    pub(crate) fn column(&self) -> usize {
        self.rows + Self::GAP
    }

    /// Returns the number of kernel values in a column; half of an even column is stored for fields in a corner.
    fn line(&self) -> usize {
        if self.corner[0] < self.rows { self.rows / 2 + 1 } else { self.rows }
    }

    /// Returns the number of rows that a thread takes at a time, a divisor of the rows of a block.
    fn portion(&self) -> usize {
        (PORTION / self.points).clamp(1, BLOCK).next_power_of_two()
    }

    pub(crate) fn scale(&self) -> T {
        T::nearest(1.0 / (self.rows * self.points) as f64)
    }

    fn panels(&self) -> impl Iterator<Item = Range<usize>> + Send + use<T> {
        let (half, width) = (self.half(), self.width);
        (0..half).step_by(width).map(move |first| first..half.min(first + width))
    }
}

/// Splits all blocks into pieces of `length`, without locking: the caller has exclusive access.
fn portions<T: Real>(blocks: &mut [Block<T>], length: usize) -> impl Iterator<Item = &mut [Complex<T>]> + Send {
    blocks.iter_mut().flat_map(move |block| block.get_mut().unwrap_or_else(PoisonError::into_inner).chunks_mut(length))
}

/// Multiplies modes by their part of the kernel and a factor.
#[multiversion(targets = "simd")]
fn multiply<T: Real>(modes: &mut [Complex<T>], kernel: &[T], factor: T) {
    for (mode, k) in modes.iter_mut().zip(kernel) {
        *mode *= *k * factor;
    }
}

/// Returns Σ k |f̃|², summed in an order that depends on the length alone.
pub(crate) fn energy<T: Real>(modes: &[Complex<T>], kernel: &[T]) -> f64 {
    let (modes, kernel) = (modes.as_chunks::<8>(), kernel.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (modes, kernel) in modes.0.iter().zip(kernel.0) {
        for (sum, (mode, k)) in sums.iter_mut().zip(modes.iter().zip(kernel)) {
            *sum += k.widened() * square(mode);
        }
    }
    let rest: f64 = modes.1.iter().zip(kernel.1).map(|(mode, k)| k.widened() * square(mode)).sum();
    sums.iter().sum::<f64>() + rest
}
