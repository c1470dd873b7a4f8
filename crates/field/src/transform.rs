use std::fmt;
use std::ops::Range;

use gfmd_vector::{Share, Split};
use num_complex::Complex;

use crate::plan::Plan;
use crate::{Grid, GridError, Real, ShapeError, Workspace};

/// Planned Fourier transforms of one grid, built once and shared between threads.
///
/// A spectrum is in the order of [`Grid::modes`]; the crate documentation describes the layout of a field. Work is
/// distributed over the threads of the current rayon pool; the result has the same bits for any number of threads.
pub struct Transform<T = f64> {
    grid: Grid,
    plan: Plan<T>,
}

impl<T: Real> Transform<T> {
    /// Plans the transforms of `grid`. Any number of points is allowed; products of small primes are fast.
    pub fn new(grid: Grid) -> Self {
        Self::distributed(grid, &grid.whole())
    }

    /// Plans the transforms of the rows in the `share` of this process. A field has these rows, and a spectrum or a
    /// kernel has the [`lanes`](Self::lanes) of this process; every process makes the same calls. The results have the
    /// same bits as with one process. Message buffers take about 0.4 fields in addition to the memory of
    /// [`new`](Self::new) for these rows.
    pub fn distributed(grid: Grid, share: &Share) -> Self {
        Self { grid, plan: Plan::new(&grid, grid.points(), share, None) }
    }

    /// Plans the transforms as [`distributed`](Self::distributed), with these lanes of each process, one range after
    /// another: for coarser grids whose waves a process needs beside its waves of a finer one. Any rows are allowed.
    pub fn with_lanes(grid: Grid, share: &Share, lanes: &[Range<usize>]) -> Self {
        Self { grid, plan: Plan::new(&grid, grid.points(), share, Some(lanes)) }
    }

    /// Plans the transforms of fields on a `patch`, in its [padded](Grid::padded_to) cell with at least `times` the
    /// points of each axis. A field has the rows of the patch in the `share` of this process, and is zero elsewhere; a
    /// spectrum has the modes of the cell, as for [`distributed`](Self::distributed). The zeros are not stored.
    ///
    /// # Errors
    /// Returns an error if the cell has more points than memory can address.
    pub fn padded(times: usize, patch: &Grid, share: &Share) -> Result<Self, GridError> {
        let grid = patch.padded_to(times)?;
        Ok(Self { grid, plan: Plan::new(patch, grid.points(), share, None) })
    }

    /// Returns the lanes of the half spectrum ([`Grid::spectrum_shape`]) of this process; one process has all lanes.
    pub fn lanes(&self) -> Range<usize> {
        self.plan.lanes()
    }

    /// Returns the grid of the transforms.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Allocates all memory for calls, for the number of threads of the current rayon pool.
    pub fn workspace(&self) -> Workspace<T> {
        self.plan.workspace()
    }

    /// Computes the spectrum f̃(q) = (1/N) Σ_r f(r) e^{−i q·r}.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn forward(&self, field: &[T], spectrum: &mut [Complex<T>], ws: &mut Workspace<T>) -> Result<(), ShapeError> {
        self.plan.forward(field, spectrum, ws)
    }

    /// Computes the field f(r) = Re Σ_q f̃(q) e^{+i q·r}, summed over the full spectrum, from the stored half.
    ///
    /// The Hermitian part is used if the spectrum does not belong to a real field: (f̃(q) + f̃*(−q))/2 at zero and
    /// Nyquist of the halved axis, where both q and −q are stored. The imaginary part of a self-conjugate mode is
    /// therefore ignored.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn inverse(&self, spectrum: &[Complex<T>], field: &mut [T], ws: &mut Workspace<T>) -> Result<(), ShapeError> {
        self.plan.inverse(spectrum, field, ws)
    }

    /// Computes `out` = F⁻¹\[k F\[field\]\] for a real kernel k laid out as [`Grid::modes`]. The spectrum is never
    /// stored.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn convolve(&self, kernel: &[T], field: &[T], out: &mut [T], ws: &mut Workspace<T>) -> Result<(), ShapeError> {
        self.plan.convolve(kernel, field, out, ws)
    }

    /// Computes a [`convolution`](Self::convolve) of a field that `source` generates row by row, and passes each row of
    /// the result to `sink` while it is in the cache. Further work on field and result then costs no pass over memory.
    ///
    /// `source(i, input, row)` fills `row` with the values `[i, ..]` of the field; `sink(i, row, output)` gets the row
    /// `[i, ..]` of the result. `input` and `output` are cut into one part per row, and the parts of row i are passed
    /// on: [`Rows`](crate::Rows) of vectors to read or change, vectors with one value per row, or `()`. A grid with one
    /// point along an axis is a single row, number 0. Each row is visited once, in any order and on any thread.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn convolve_rows<I: Split, O: Split>(
        &self,
        kernel: &[T],
        input: I,
        source: impl Fn(usize, I, &mut [T]) + Sync,
        output: O,
        sink: impl Fn(usize, &mut [T], O) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.convolve_ahead(kernel, input, source, ws)?;
        self.convolve_back(output, sink, ws)
    }

    /// Runs the first half of [`convolve_rows`](Self::convolve_rows), which fills the workspace; the second half may
    /// then read data changed by the source. A kernel that is even in q_x may have only the first nx/2 + 1 values of
    /// every column of modes.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn convolve_ahead<I: Split>(
        &self,
        kernel: &[T],
        input: I,
        source: impl Fn(usize, I, &mut [T]) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.plan.ahead(kernel, input, source, ws)
    }

    /// Runs the second half of [`convolve_rows`](Self::convolve_rows), from the workspace left by the first half.
    ///
    /// # Errors
    /// Returns an error if outputs or the workspace do not fit the grid.
    pub fn convolve_back<O: Split>(
        &self,
        output: O,
        sink: impl Fn(usize, &mut [T], O) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.plan.back(output, sink, ws)
    }

    /// Returns Σ_q w k |f̃|² = (1/N) Σ_r f (K f), where w is the weight of a mode, with half the work of a convolution.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn quadratic_form(&self, kernel: &[T], field: &[T], ws: &mut Workspace<T>) -> Result<f64, ShapeError> {
        self.plan.quadratic_form(kernel, field, ws)
    }
}

impl<T> fmt::Debug for Transform<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Transform").field("grid", &self.grid).finish_non_exhaustive()
    }
}
