use std::fmt;

use num_complex::Complex64;

use crate::Grid;
use crate::line::{self, Line};
use crate::plane::{self, Plane};
use crate::prefetch::prefetch;

/// The planned Fourier transforms of one grid: built once, shared between threads.
///
/// A spectrum is laid out as [`Grid::modes`], a field as on the front page. Work is distributed over the threads of the
/// current rayon pool; the result has the same bits for any number of threads.
pub struct Transform {
    grid: Grid,
    plan: Plan,
}

pub(crate) enum Plan {
    Line(Line),
    Plane(Plane),
}

impl Plan {
    /// Allocates all memory that a call needs, for as many threads as the current rayon pool has. `points` are those of
    /// the transforms.
    pub(crate) fn workspace(&self, points: [usize; 2]) -> Workspace {
        let (line, plane) = match self {
            Self::Line(line) => (line.memory(), plane::Memory::default()),
            Self::Plane(plane) => (line::Memory::default(), plane.memory(rayon::current_num_threads())),
        };
        Workspace { points, line, plane }
    }
}

/// The working memory of one caller, made by [`Transform::workspace`] or
/// [`Convolution::workspace`](crate::Convolution::workspace) and used at every call: about one field (a convolution: two), and
/// 16 columns for each thread. A call itself allocates nothing.
pub struct Workspace {
    pub(crate) points: [usize; 2],
    pub(crate) line: line::Memory,
    pub(crate) plane: plane::Memory,
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

impl Transform {
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
    pub fn workspace(&self) -> Workspace {
        self.plan.workspace(self.grid.points())
    }

    /// Computes the spectrum f̃(q) = (1/N) Σ_r f(r) e^{−i q·r}.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn forward(&self, field: &[f64], spectrum: &mut [Complex64], ws: &mut Workspace) -> Result<(), ShapeError> {
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
    pub fn inverse(&self, spectrum: &[Complex64], field: &mut [f64], ws: &mut Workspace) -> Result<(), ShapeError> {
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
    pub fn convolve(
        &self,
        kernel: &[f64],
        field: &[f64],
        out: &mut [f64],
        ws: &mut Workspace,
    ) -> Result<(), ShapeError> {
        check("field", field.len(), self.grid.len())?;
        self.convolve_rows(kernel, rows_of(field), out, |_, _| {}, ws)
    }

    /// Computes a [`convolution`](Self::convolve) of a field that `source` makes row by row, and hands each row of the result
    /// to `sink` while it is in the cache. Further work on field and result then costs no pass over memory.
    ///
    /// `source(i, row)` fills `row` with the values `[i, ..]` of the field; `sink(i, row)` gets the finished row `[i, ..]`
    /// of `out` and may change it. A grid with one point along an axis is a single row, number 0. Each row is visited once,
    /// in any order and on any thread.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn convolve_rows(
        &self,
        kernel: &[f64],
        source: impl Fn(usize, &mut [f64]) + Sync,
        out: &mut [f64],
        sink: impl Fn(usize, &mut [f64]) + Sync,
        ws: &mut Workspace,
    ) -> Result<(), ShapeError> {
        check("kernel", kernel.len(), self.grid.spectrum_len())?;
        check("output", out.len(), self.grid.len())?;
        self.check_workspace(ws)?;
        match &self.plan {
            Plan::Line(line) => line.convolve(kernel, &source, out, &sink, &mut ws.line),
            Plan::Plane(plane) => plane.convolve(kernel, &source, out, &sink, &mut ws.plane),
        }
        Ok(())
    }

    /// Returns Σ_q w k |f̃|² = (1/N) Σ_r f (K f), with w the weight of a mode. It takes half the work of a convolution.
    ///
    /// # Errors
    /// A slice or a workspace that does not fit the grid.
    pub fn quadratic_form(&self, kernel: &[f64], field: &[f64], ws: &mut Workspace) -> Result<f64, ShapeError> {
        check("kernel", kernel.len(), self.grid.spectrum_len())?;
        check("field", field.len(), self.grid.len())?;
        self.check_workspace(ws)?;
        Ok(match &self.plan {
            Plan::Line(line) => line.quadratic_form(kernel, &rows_of(field), &mut ws.line),
            Plan::Plane(plane) => plane.quadratic_form(kernel, &rows_of(field), &mut ws.plane),
        })
    }

    fn check_workspace(&self, ws: &Workspace) -> Result<(), ShapeError> {
        let [nx, ny] = self.grid.points();
        check("workspace along x", ws.points[0], nx)?;
        check("workspace along y", ws.points[1], ny)
    }
}

impl fmt::Debug for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Transform").field("grid", &self.grid).finish_non_exhaustive()
    }
}

impl fmt::Debug for Workspace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workspace").field("points", &self.points).finish_non_exhaustive()
    }
}

/// A source that copies the rows of a field and prefetches the next one.
pub(crate) fn rows_of(field: &[f64]) -> impl Fn(usize, &mut [f64]) + Sync {
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
