use std::fmt;

use gfmd_vector::{Rows, Split};
use num_complex::Complex;

use crate::line::{self, Line};
use crate::plane::{self, Plane};
use crate::prefetch::prefetch;
use crate::real::copy;
use crate::{Grid, Real};

/// The planned Fourier transforms of one grid: built once, shared between threads.
///
/// A spectrum is laid out as [`Grid::modes`], a field as on the front page. Work is distributed over the threads of the
/// current rayon pool; the result has the same bits for any number of threads.
pub struct Transform<T = f64> {
    grid: Grid,
    plan: Plan<T>,
}

pub(crate) enum Plan<T> {
    Line(Line<T>),
    Plane(Plane<T>),
}

impl<T: Real> Plan<T> {
    /// Allocates all memory that a call needs, for as many threads as the current rayon pool has. `points` are those of
    /// the transforms.
    pub(crate) fn workspace(&self, points: [usize; 2]) -> Workspace<T> {
        let (line, plane) = match self {
            Self::Line(line) => (line.memory(), plane::Memory::default()),
            Self::Plane(plane) => (line::Memory::default(), plane.memory(rayon::current_num_threads())),
        };
        Workspace { points, line, plane }
    }

    /// The rows of what the workspace holds.
    pub(crate) fn back<O: Split>(&self, output: O, sink: &(impl Fn(usize, &mut [T], O) + Sync), ws: &mut Workspace<T>) {
        match self {
            Self::Line(line) => line.row_back(output, sink, &mut ws.line),
            Self::Plane(plane) => plane.rows_back(output, sink, &mut ws.plane),
        }
    }
}

/// The working memory of one caller, made by [`Transform::workspace`] or
/// [`Convolution::workspace`](crate::Convolution::workspace) and used at every call: about one field (a convolution: two), and
/// 16 columns for each thread. A call itself allocates nothing.
pub struct Workspace<T = f64> {
    pub(crate) points: [usize; 2],
    pub(crate) line: line::Memory<T>,
    pub(crate) plane: plane::Memory<T>,
}

/// A slice of the wrong length, or a workspace of another grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {what} has {found} values; it must have {expected} on this grid")]
pub struct ShapeError {
    /// The argument.
    pub what: &'static str,
    /// Its length.
    pub found: usize,
    /// The length it must have.
    pub expected: usize,
}

impl<T: Real> Transform<T> {
    /// Plans the transforms of `grid`. Any number of points will do; products of small primes are fast.
    pub fn new(grid: Grid) -> Self {
        let points = grid.points();
        let plan =
            if points.contains(&1) { Plan::Line(Line::new(grid.len())) } else { Plan::Plane(Plane::new(points)) };
        Self { grid, plan }
    }

    /// The grid of the transforms.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Allocates all memory that a call needs, for as many threads as the current rayon pool has.
    pub fn workspace(&self) -> Workspace<T> {
        self.plan.workspace(self.grid.points())
    }

    /// Computes the spectrum f̃(q) = (1/N) Σ_r f(r) e^{−i q·r}.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn forward(&self, field: &[T], spectrum: &mut [Complex<T>], ws: &mut Workspace<T>) -> Result<(), ShapeError> {
        check("field", field.len(), self.grid.len())?;
        check("spectrum", spectrum.len(), self.grid.spectrum_len())?;
        self.check_workspace(ws)?;
        match &self.plan {
            Plan::Line(line) => line.forward(&rows_of(field), spectrum, &mut ws.line),
            Plan::Plane(plane) => plane.forward(&rows_of(field), spectrum, &mut ws.plane),
        }
        Ok(())
    }

    /// Computes the field f(r) = Re Σ_q f̃(q) e^{+i q·r}, summed over the full spectrum, from the stored half.
    ///
    /// If the spectrum is not that of a real field, its Hermitian part is used: at zero and Nyquist of the halved axis,
    /// where both q and −q are stored, (f̃(q) + f̃*(−q))/2. The imaginary part of a mode that is its own conjugate is
    /// therefore ignored.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn inverse(&self, spectrum: &[Complex<T>], field: &mut [T], ws: &mut Workspace<T>) -> Result<(), ShapeError> {
        check("spectrum", spectrum.len(), self.grid.spectrum_len())?;
        check("field", field.len(), self.grid.len())?;
        self.check_workspace(ws)?;
        match &self.plan {
            Plan::Line(line) => line.inverse(spectrum, field, &mut ws.line),
            Plan::Plane(plane) => plane.inverse(spectrum, field, &mut ws.plane),
        }
        Ok(())
    }

    /// Computes `out` = F⁻¹\[k F\[field\]\] for a real kernel k laid out as [`Grid::modes`]. The spectrum is never stored.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn convolve(&self, kernel: &[T], field: &[T], out: &mut [T], ws: &mut Workspace<T>) -> Result<(), ShapeError> {
        check("field", field.len(), self.grid.len())?;
        check("output", out.len(), self.grid.len())?;
        let (source, columns) = (rows_of(field), self.row());
        self.convolve_rows(kernel, (), |i, (), row| source(i, row), Rows(out, columns), copy, ws)
    }

    /// Computes a [`convolution`](Self::convolve) of a field that `source` makes row by row, and hands each row of the result
    /// to `sink` while it is in the cache. Further work on field and result then costs no pass over memory.
    ///
    /// `source(i, input, row)` fills `row` with the values `[i, ..]` of the field; `sink(i, row, output)` gets the row `[i, ..]`
    /// of the result. The `input` and the `output` are cut into one part for each row, and the parts of row i are handed over:
    /// [`Rows`] of vectors to read and to change, vectors with a value for each row, or `()`. A grid with one point along an
    /// axis is a single row, number 0. Each row is visited once, in any order and on any thread.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
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

    /// The first half of [`convolve_rows`](Self::convolve_rows), which fills the workspace; the second one may then read what
    /// the source has changed. The kernel may also have the first nx/2 + 1 values only of every column of modes, if it is even
    /// in q_x.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn convolve_ahead<I: Split>(
        &self,
        kernel: &[T],
        input: I,
        source: impl Fn(usize, I, &mut [T]) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.check_kernel(kernel)?;
        check_rows(&input, self.grid.len() / self.row())?;
        self.check_workspace(ws)?;
        match &self.plan {
            Plan::Line(line) => line.convolve(kernel, input, &source, &mut ws.line),
            Plan::Plane(plane) => plane.convolve(kernel, input, &source, &mut ws.plane),
        }
        Ok(())
    }

    /// The second half of [`convolve_rows`](Self::convolve_rows), from the workspace as the first one left it.
    ///
    /// # Errors
    /// Outputs or a workspace that do not fit the grid.
    pub fn convolve_back<O: Split>(
        &self,
        output: O,
        sink: impl Fn(usize, &mut [T], O) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        check_rows(&output, self.grid.len() / self.row())?;
        self.check_workspace(ws)?;
        self.plan.back(output, &sink, ws);
        Ok(())
    }

    /// Returns Σ_q w k |f̃|² = (1/N) Σ_r f (K f), with w the weight of a mode. It takes half the work of a convolution.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn quadratic_form(&self, kernel: &[T], field: &[T], ws: &mut Workspace<T>) -> Result<f64, ShapeError> {
        self.check_kernel(kernel)?;
        check("field", field.len(), self.grid.len())?;
        self.check_workspace(ws)?;
        Ok(match &self.plan {
            Plan::Line(line) => line.quadratic_form(kernel, &rows_of(field), &mut ws.line),
            Plan::Plane(plane) => plane.quadratic_form(kernel, &rows_of(field), &mut ws.plane),
        })
    }

    fn check_kernel(&self, kernel: &[T]) -> Result<(), ShapeError> {
        let [nx, ny] = self.grid.points();
        let is_even = matches!(self.plan, Plan::Plane(_)) && kernel.len() == (nx / 2 + 1) * (ny / 2 + 1);
        if is_even { Ok(()) } else { check("kernel", kernel.len(), self.grid.spectrum_len()) }
    }

    /// The number of points in a row.
    fn row(&self) -> usize {
        match self.plan {
            Plan::Line(_) => self.grid.len(),
            Plan::Plane(_) => self.grid.points()[1],
        }
    }

    fn check_workspace(&self, ws: &Workspace<T>) -> Result<(), ShapeError> {
        let [nx, ny] = self.grid.points();
        check("workspace along x", ws.points[0], nx)?;
        check("workspace along y", ws.points[1], ny)
    }
}

impl<T> fmt::Debug for Transform<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Transform").field("grid", &self.grid).finish_non_exhaustive()
    }
}

impl<T> fmt::Debug for Workspace<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workspace").field("points", &self.points).finish_non_exhaustive()
    }
}

/// A source that copies the rows of a field and prefetches the next one.
pub(crate) fn rows_of<T: Real>(field: &[T]) -> impl Fn(usize, &mut [T]) + Sync {
    move |i, row| {
        let (here, next) = field[i * row.len()..].split_at(row.len());
        row.copy_from_slice(here);
        if field.len() > plane::LARGE {
            prefetch(&next[..row.len().min(next.len())]);
        }
    }
}

pub(crate) fn check(what: &'static str, found: usize, expected: usize) -> Result<(), ShapeError> {
    if found == expected { Ok(()) } else { Err(ShapeError { what, found, expected }) }
}

/// Checks that what goes into a convolution, or comes out of it, has a part for each row.
pub(crate) fn check_rows(parts: &impl Split, rows: usize) -> Result<(), ShapeError> {
    if parts.fits(rows) { Ok(()) } else { Err(ShapeError { what: "rows", found: parts.length(), expected: rows }) }
}
