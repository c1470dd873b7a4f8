use std::fmt;
use std::ops::Range;

use gfmd_vector::{Rows, Share, Split};
use num_complex::Complex;

use crate::line::{self, Line};
use crate::plane::{self, Plane};
use crate::prefetch::prefetch;
use crate::real::copy;
use crate::shared::{self, Shared};
use crate::{Grid, Real};

/// Planned transforms of the fields of a grid, which may be a corner of a larger grid. Every call checks that its
/// arguments fit.
pub(crate) struct Plan<T> {
    /// Number of rows of a field, and of points in each row.
    rows: [usize; 2],
    /// Numbers of points of the transforms.
    points: [usize; 2],
    kind: Kind<T>,
}

enum Kind<T> {
    Line(Line<T>),
    Plane(Plane<T>),
    /// Plan for the rows of one of several processes.
    Shared(Shared<T>),
}

/// Working memory of one caller, created by [`Transform::workspace`](crate::Transform::workspace) or
/// [`Convolution::workspace`](crate::Convolution::workspace) and used at every call: about one field (two for a
/// convolution), and 16 columns per thread. The calls themselves allocate nothing.
pub struct Workspace<T = f64> {
    points: [usize; 2],
    line: line::Memory<T>,
    plane: plane::Memory<T>,
    shared: shared::Memory<T>,
}

/// Error: a slice of the wrong length, or a workspace of another grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {what} has {found} values; it must have {expected} on this grid")]
pub struct ShapeError {
    /// Name of the argument.
    pub what: &'static str,
    /// Length of the argument.
    pub found: usize,
    /// Required length.
    pub expected: usize,
}

impl<T: Real> Plan<T> {
    /// Plans the transforms of the rows of the grid in the `share` of this process, with at least as many `points` as
    /// the grid. Several processes have these `lanes`, by default about the same number.
    pub(crate) fn new(grid: &Grid, points: [usize; 2], share: &Share, lanes: Option<&[Range<usize>]>) -> Self {
        match grid.rows() {
            [1, shown] => Self { rows: [1, shown], points, kind: Kind::Line(Line::new(points[0] * points[1], shown)) },
            corner if share.is_whole() => Self { rows: corner, points, kind: Kind::Plane(Plane::new(points, corner)) },
            [_, shown] => {
                let kind = Kind::Shared(Shared::new(points, shown, share, lanes));
                Self { rows: [share.rows().len(), shown], points, kind }
            }
        }
    }

    /// Returns the lanes of the half spectrum that belong to this process.
    pub(crate) fn lanes(&self) -> Range<usize> {
        match (&self.kind, self.points) {
            // A row along y has a lane for each of its modes; a line has one lane.
            (Kind::Line(_), [_, 1]) => 0..1,
            (Kind::Line(_) | Kind::Plane(_), [_, ny]) => 0..ny / 2 + 1,
            (Kind::Shared(shared), _) => shared.columns(),
        }
    }

    /// Returns the numbers of points of the transforms.
    pub(crate) fn points(&self) -> [usize; 2] {
        self.points
    }

    /// Returns the number of points in a row of a field.
    pub(crate) fn row(&self) -> usize {
        self.rows[1]
    }

    /// Allocates all memory for calls, for the number of threads of the current rayon pool.
    pub(crate) fn workspace(&self) -> Workspace<T> {
        let (line, plane, shared) = Default::default();
        let mut ws = Workspace { points: self.points, line, plane, shared };
        let threads = rayon::current_num_threads();
        match &self.kind {
            Kind::Line(line) => ws.line = line.memory(),
            Kind::Plane(plane) => ws.plane = plane.memory(threads),
            Kind::Shared(shared) => ws.shared = shared.memory(threads),
        }
        ws
    }

    /// Computes the spectrum of a field.
    pub(crate) fn forward(
        &self,
        field: &[T],
        spectrum: &mut [Complex<T>],
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.check_field("field", field)?;
        check("spectrum", spectrum.len(), self.spectrum_len())?;
        self.check_workspace(ws)?;
        match &self.kind {
            Kind::Line(line) => line.forward(&rows_of(field), spectrum, &mut ws.line),
            Kind::Plane(plane) => plane.forward(&rows_of(field), spectrum, &mut ws.plane),
            Kind::Shared(shared) => shared.forward(&rows_of(field), spectrum, &mut ws.shared),
        }
        Ok(())
    }

    /// Computes the field of a spectrum.
    pub(crate) fn inverse(
        &self,
        spectrum: &[Complex<T>],
        field: &mut [T],
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        check("spectrum", spectrum.len(), self.spectrum_len())?;
        self.check_field("field", field)?;
        self.check_workspace(ws)?;
        match &self.kind {
            Kind::Line(line) => line.inverse(spectrum, field, &mut ws.line),
            Kind::Plane(plane) => plane.inverse(spectrum, field, &mut ws.plane),
            Kind::Shared(shared) => shared.inverse(spectrum, field, &mut ws.shared),
        }
        Ok(())
    }

    /// Computes `out` = F⁻¹\[k F\[field\]\].
    pub(crate) fn convolve(
        &self,
        kernel: &[T],
        field: &[T],
        out: &mut [T],
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.check_field("field", field)?;
        self.check_field("output", out)?;
        let source = rows_of(field);
        self.ahead(kernel, (), |i, (), row: &mut [T]| source(i, row), ws)?;
        self.back(Rows(out, self.row()), copy, ws)
    }

    /// Runs the first half of a convolution, which leaves the half spectra of the rows of the result in the workspace.
    pub(crate) fn ahead<I: Split>(
        &self,
        kernel: &[T],
        input: I,
        source: impl Fn(usize, I, &mut [T]) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.check_kernel(kernel)?;
        check_rows(&input, self.rows[0])?;
        self.check_workspace(ws)?;
        match &self.kind {
            Kind::Line(line) => line.convolve(kernel, input, &source, &mut ws.line),
            Kind::Plane(plane) => plane.convolve(kernel, input, &source, &mut ws.plane),
            Kind::Shared(shared) => shared.convolve(kernel, input, &source, &mut ws.shared),
        }
        Ok(())
    }

    /// Runs the second half of a convolution: transforms the half spectra in the workspace to rows.
    pub(crate) fn back<O: Split>(
        &self,
        output: O,
        sink: impl Fn(usize, &mut [T], O) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        check_rows(&output, self.rows[0])?;
        self.check_workspace(ws)?;
        match &self.kind {
            Kind::Line(line) => line.row_back(output, &sink, &mut ws.line),
            Kind::Plane(plane) => plane.rows_back(output, &sink, &mut ws.plane),
            Kind::Shared(shared) => shared.rows_back(output, &sink, &mut ws.shared),
        }
        Ok(())
    }

    /// Returns Σ_q w k |f̃|², where w is the weight of a mode.
    pub(crate) fn quadratic_form(&self, kernel: &[T], field: &[T], ws: &mut Workspace<T>) -> Result<f64, ShapeError> {
        self.check_kernel(kernel)?;
        self.check_field("field", field)?;
        self.check_workspace(ws)?;
        Ok(match &self.kind {
            Kind::Line(line) => line.quadratic_form(kernel, &rows_of(field), &mut ws.line),
            Kind::Plane(plane) => plane.quadratic_form(kernel, &rows_of(field), &mut ws.plane),
            Kind::Shared(shared) => shared.quadratic_form(kernel, &rows_of(field), &mut ws.shared),
        })
    }

    /// Computes the stored part of the spectrum of an even kernel from rows of its values at the distances 0, 1, …; of
    /// the lanes of this process.
    pub(crate) fn even(&self, source: impl Fn(usize, &mut [T]) + Sync) -> Vec<T> {
        let mut ws = self.workspace();
        match &self.kind {
            Kind::Line(line) => line.even(&source, &mut ws.line),
            Kind::Plane(plane) => plane.even(&source, &mut ws.plane),
            Kind::Shared(shared) => shared.even(&source, &mut ws.shared),
        }
    }

    fn spectrum_len(&self) -> usize {
        match (&self.kind, self.points) {
            (Kind::Line(_), [nx, ny]) => nx * ny / 2 + 1,
            (_, [nx, _]) => nx * self.lanes().len(),
        }
    }

    /// Checks the size of a kernel; a quarter suffices for a kernel that is also even along x.
    fn check_kernel(&self, kernel: &[T]) -> Result<(), ShapeError> {
        let [nx, _] = self.points;
        let is_quarter = !matches!(self.kind, Kind::Line(_)) && kernel.len() == (nx / 2 + 1) * self.lanes().len();
        if is_quarter { Ok(()) } else { check("kernel", kernel.len(), self.spectrum_len()) }
    }

    fn check_field(&self, what: &'static str, field: &[T]) -> Result<(), ShapeError> {
        check(what, field.len(), self.rows[0] * self.rows[1])
    }

    fn check_workspace(&self, ws: &Workspace<T>) -> Result<(), ShapeError> {
        check("workspace along x", ws.points[0], self.points[0])?;
        check("workspace along y", ws.points[1], self.points[1])
    }
}

/// Returns a source that copies the rows of a field and prefetches the next row.
fn rows_of<T: Real>(field: &[T]) -> impl Fn(usize, &mut [T]) + Sync {
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

/// Checks that the input or output of a convolution has a part for each row.
pub(crate) fn check_rows(parts: &impl Split, rows: usize) -> Result<(), ShapeError> {
    if parts.fits(rows) { Ok(()) } else { Err(ShapeError { what: "rows", found: parts.length(), expected: rows }) }
}

impl<T> fmt::Debug for Workspace<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workspace").field("points", &self.points).finish_non_exhaustive()
    }
}
