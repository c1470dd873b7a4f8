use std::fmt;

use gfmd_vector::{Share, Split};

use crate::plan::Plan;
use crate::{Grid, GridError, Real, ShapeError, Workspace};

/// Convolution of fields on a non-periodic patch, `out(r) = Σ_s k(r − s) f(s)` over the points s of the grid, with a
/// kernel that is even in both directions. Built once and shared between threads.
///
/// Fields are zero outside the patch: the sum becomes a product of spectra on a cell with twice the points in each
/// direction (Hockney 1970). The zeros are neither stored nor transformed along y, and a quarter of the kernel spectrum
/// is stored. Memory is about one field, and two in each [`Workspace`]; the result has the same bits for any number of
/// threads.
///
/// ```
/// use gfmd_field::{Convolution, Grid};
///
/// let grid = Grid::line(4, 1.0)?;
/// let distance = Convolution::new(grid, |[i, _]| i as f64);
/// let mut out = [0.0_f64; 4];
/// distance.apply(&[1.0, 0.0, 0.0, 2.0], &mut out, &mut distance.workspace())?;
/// assert!(out.iter().zip([6.0, 5.0, 4.0, 3.0]).all(|(out, exact)| (out - exact).abs() < 1e-14));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Convolution<T = f64> {
    grid: Grid,
    share: Share,
    plan: Plan<T>,
    kernel: Vec<T>,
}

impl<T: Real> Convolution<T> {
    /// Plans the convolution on `grid` with the kernel `kernel([i, j])` at a distance of i points along x and j along
    /// y.
    pub fn new(grid: Grid, kernel: impl Fn([usize; 2]) -> f64 + Sync) -> Self {
        Self::distributed(grid, &grid.whole(), kernel)
    }

    /// Plans the convolution as [`new`](Self::new), for the rows in the `share` of this process; every process makes
    /// the same calls. The results have the same bits as with one process.
    pub fn distributed(grid: Grid, share: &Share, kernel: impl Fn([usize; 2]) -> f64 + Sync) -> Self {
        let points = grid.points().map(|points| if points == 1 { 1 } else { padded_length(2 * points) });
        let plan = Plan::new(&grid, points, share, None);
        let is_line = grid.is_line();
        let kernel = plan.even(|i, row| {
            for (j, value) in row.iter_mut().enumerate() {
                *value = T::nearest(kernel(if is_line { [j, i] } else { [i, j] }));
            }
        });
        Self { grid, share: share.clone(), plan, kernel }
    }

    /// Returns the grid of the fields.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns the rows of this process; a single process has all rows.
    pub fn share(&self) -> &Share {
        &self.share
    }

    /// Allocates all memory for calls, for the number of threads of the current rayon pool.
    pub fn workspace(&self) -> Workspace<T> {
        self.plan.workspace()
    }

    /// Computes `out` = Σ k `field`.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn apply(&self, field: &[T], out: &mut [T], ws: &mut Workspace<T>) -> Result<(), ShapeError> {
        self.plan.convolve(&self.kernel, field, out, ws)
    }

    /// Runs the first half of [`apply`](Self::apply), for a field that is generated row by row; see
    /// [`Transform::convolve_ahead`](crate::Transform::convolve_ahead).
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn apply_ahead<I: Split>(
        &self,
        input: I,
        source: impl Fn(usize, I, &mut [T]) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.plan.ahead(&self.kernel, input, source, ws)
    }

    /// Runs the second half; see [`Transform::convolve_back`](crate::Transform::convolve_back).
    ///
    /// # Errors
    /// Returns an error if outputs or the workspace do not fit the grid.
    pub fn apply_back<O: Split>(
        &self,
        output: O,
        sink: impl Fn(usize, &mut [T], O) + Sync,
        ws: &mut Workspace<T>,
    ) -> Result<(), ShapeError> {
        self.plan.back(output, sink, ws)
    }

    /// Returns Σ_r f(r) Σ_s k(r − s) f(s), with about half the work of [`apply`](Self::apply).
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not fit the grid.
    pub fn quadratic_form(&self, field: &[T], ws: &mut Workspace<T>) -> Result<f64, ShapeError> {
        let [nx, ny] = self.plan.points();
        Ok(self.plan.quadratic_form(&self.kernel, field, ws)? * (nx * ny) as f64)
    }
}

impl Convolution {
    /// Returns the largest magnitude in the spectrum of the kernel, the largest amplification of a wave.
    pub fn largest(&self) -> f64 {
        let own = self.kernel.iter().fold(0.0, |largest: f64, k| k.abs().max(largest));
        self.share.each(own).into_iter().fold(0.0, f64::max)
    }

    /// Adds `part` to the kernel at zero distance, which adds `part` times the field to the result.
    #[must_use]
    pub fn with_own(&self, part: f64) -> Self {
        self.with_kernel(self.kernel.iter().map(|k| k + part).collect())
    }

    /// Returns the convolution with `factor` times the kernel, in single precision.
    pub fn rounded(&self, factor: f64) -> Convolution<f32> {
        self.with_kernel(self.kernel.iter().map(|k| (k * factor) as f32).collect())
    }

    fn with_kernel<T: Real>(&self, kernel: Vec<T>) -> Convolution<T> {
        let plan = Plan::new(&self.grid, self.plan.points(), &self.share, None);
        Convolution { grid: self.grid, share: self.share.clone(), plan, kernel }
    }
}

impl<T> fmt::Debug for Convolution<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Convolution").field("grid", &self.grid).finish_non_exhaustive()
    }
}

impl Grid {
    /// Returns the periodic cell in which a patch on this grid does not overlap its images. It has the same spacing,
    /// and along each axis with more than one point at least twice the points, an even product of 2, 3, 5 and 7.
    ///
    /// # Errors
    /// Returns an error if the cell has more points than memory can address.
    pub fn padded(&self) -> Result<Self, GridError> {
        self.padded_to(2)
    }

    /// Returns the [padded](Self::padded) grid with at least `times` the points of each axis; `times` is at least 2.
    ///
    /// # Errors
    /// Returns an error as [`padded`](Self::padded).
    pub fn padded_to(&self, times: usize) -> Result<Self, GridError> {
        let points = self.points().map(|points| if points == 1 { 1 } else { padded_length(times.max(2) * points) });
        let spacing = self.spacing();
        Self::new(points, [0, 1].map(|axis| spacing[axis] * points[axis] as f64))
    }
}

/// Returns the smallest even product of 2, 3, 5 and 7 (fast to transform) that is at least `points`.
fn padded_length(points: usize) -> usize {
    let is_smooth = |length: &usize| {
        let mut rest = *length;
        for factor in [2, 3, 5, 7] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    let even = points.next_multiple_of(2);
    (even..).step_by(2).find(is_smooth).unwrap_or(even)
}
