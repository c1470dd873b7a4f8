use std::borrow::Cow;

use gfmd_field::Grid;
use ndarray::{Array2, ArrayRef2, ArrayView2, Axis, Slice};
use rayon::prelude::*;

use crate::{Moments, PowerSpectrum, SurfaceError};

/// The statistics of heights over one period of a surface `[nx, ny]` or of a profile `[n, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Mean height, length.
    pub mean: f64,
    /// Lowest height, length.
    pub lowest: f64,
    /// Highest height, length.
    pub highest: f64,
    /// Spectral moments about the mean: rms height, rms gradient, rms curvature, Nayak's parameter.
    pub moments: Moments,
    /// Root-mean-square gradient by central differences (h(x+a) − h(x−a))/2a, the seam included; dimensionless.
    pub rms_gradient_central: f64,
    /// Root-mean-square gradient by forward differences (h(x+a) − h(x))/a, the seam included; dimensionless.
    pub rms_gradient_forward: f64,
    /// Root-mean-square gradient by forward differences without those across the seam, for heights that are not periodic.
    pub rms_gradient_inside: f64,
    /// The largest slope by forward differences, without those across the seam.
    pub max_slope: f64,
    /// The jump across the seam.
    pub seam: Seam,
}

/// The root-mean-square steps between neighbouring points across the periodic seam and inside. Their ratio says how well
/// opposite edges fit together; it is about 1 for a periodic surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// Step from the last to the first point along x and along y, root-mean-square, length. Zero along one point.
    pub across: [f64; 2],
    /// Step between neighbours inside along x and along y, root-mean-square, length. Zero along one point.
    pub inside: [f64; 2],
}

impl Seam {
    /// The ratio across/inside along x and along y; `None` if all steps inside are zero.
    pub fn ratio(&self) -> [Option<f64>; 2] {
        [0, 1].map(|axis| (self.inside[axis] > 0.0).then(|| self.across[axis] / self.inside[axis]))
    }
}

impl Statistics {
    /// The statistics of `heights`. Spectral statistics take the heights as one period, so that a step across the seam is part
    /// of the surface.
    ///
    /// # Errors
    /// Heights of another shape than the grid, or not finite.
    pub fn of(heights: &Array2<f64>, grid: &Grid) -> Result<Self, SurfaceError> {
        let moments = PowerSpectrum::of(heights, grid)?.moments();
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for &h in heights {
            (lowest, highest) = (lowest.min(h), highest.max(h));
        }
        let steps = [0, 1].map(|axis| Steps::along(heights.view(), Axis(axis)));
        let spacing = grid.spacing();
        let gradient = |square: [f64; 2]| (square[0] / spacing[0].powi(2) + square[1] / spacing[1].powi(2)).sqrt();
        Ok(Self {
            mean: sum_of(heights.view(), heights.view(), |h, _| h) / heights.len() as f64,
            lowest,
            highest,
            moments,
            rms_gradient_central: gradient([0, 1].map(|axis| 0.25 * steps[axis].double)),
            rms_gradient_forward: gradient([0, 1].map(|axis| steps[axis].all)),
            rms_gradient_inside: gradient([0, 1].map(|axis| steps[axis].inside)),
            max_slope: steepest(heights.view(), spacing),
            seam: Seam {
                across: [0, 1].map(|axis| steps[axis].across.sqrt()),
                inside: [0, 1].map(|axis| steps[axis].inside.sqrt()),
            },
        })
    }

    /// The highest minus the lowest height, length.
    pub fn peak_to_valley(&self) -> f64 {
        self.highest - self.lowest
    }
}

/// The mean squares of steps between points of a periodic axis.
#[derive(Default)]
struct Steps {
    /// Between neighbours, except across the seam.
    inside: f64,
    /// Between the last and the first point.
    across: f64,
    /// Between all neighbours.
    all: f64,
    /// Between next neighbours, over all points.
    double: f64,
}

impl Steps {
    fn along(heights: ArrayView2<f64>, axis: Axis) -> Self {
        let points = heights.len_of(axis) as isize;
        if points < 2 {
            return Self::default();
        }
        // Σ (h(i + shift) − h(i))² over i from `first` to `end`.
        let squares = |first: isize, end: isize, shift: isize| {
            let part = |shift: isize| heights.slice_axis(axis, Slice::from(shift + first..shift + end));
            sum_of(part(shift), part(0), |ahead, here| (ahead - here).powi(2))
        };
        let (lanes, count) = ((heights.len() as isize / points) as f64, points as f64);
        let (inside, across) = (squares(0, points - 1, 1), squares(points - 1, points, 1 - points));
        let double = squares(0, points - 2, 2) + squares(points - 2, points, 2 - points);
        Self {
            inside: inside / (lanes * (count - 1.0)),
            across: across / lanes,
            all: (inside + across) / (lanes * count),
            double: double / (lanes * count),
        }
    }
}

/// The largest slope by forward differences between neighbours inside.
fn steepest(heights: ArrayView2<f64>, spacing: [f64; 2]) -> f64 {
    let [nx, ny] = [heights.nrows(), heights.ncols()];
    let in_row = |i: usize| {
        let squares = (0..ny).map(|j| {
            let step = |inside: bool, ahead: [usize; 2], spacing: f64| {
                if inside { (heights[ahead] - heights[[i, j]]) / spacing } else { 0.0 }
            };
            let [x, y] = [step(i + 1 < nx, [i + 1, j], spacing[0]), step(j + 1 < ny, [i, j + 1], spacing[1])];
            x * x + y * y
        });
        squares.fold(0.0, f64::max)
    };
    (0..nx).into_par_iter().map(in_row).reduce(|| 0.0, f64::max).sqrt()
}

/// The sum Σ f(a, b) over the points of two fields, added row by row: it has the same bits for any number of threads.
fn sum_of(a: ArrayView2<f64>, b: ArrayView2<f64>, f: impl Fn(f64, f64) -> f64 + Sync) -> f64 {
    let row = |i| a.row(i).iter().zip(b.row(i)).map(|(&a, &b)| f(a, b)).sum();
    let rows: Vec<f64> = (0..a.nrows()).into_par_iter().map(row).collect();
    rows.iter().sum()
}

/// Returns the heights in the storage order of the grid if they fit it and are finite.
pub(crate) fn checked<'a>(heights: &'a ArrayRef2<f64>, grid: &Grid) -> Result<Cow<'a, [f64]>, SurfaceError> {
    let (nx, ny) = heights.dim();
    if [nx, ny] != grid.points() {
        return Err(SurfaceError::Shape { found: [nx, ny], expected: grid.points() });
    }
    finite(heights)?;
    Ok(match heights.as_slice() {
        Some(slice) => Cow::Borrowed(slice),
        None => Cow::Owned(heights.iter().copied().collect()),
    })
}

/// Refuses heights that are NaN or infinite, with their number and the first of them.
pub(crate) fn finite(heights: &ArrayRef2<f64>) -> Result<(), SurfaceError> {
    if heights.iter().all(|h| h.is_finite()) {
        return Ok(());
    }
    let mut holes = heights.indexed_iter().filter(|(_, h)| !h.is_finite());
    match holes.next() {
        None => Ok(()),
        Some(((i, j), &value)) => {
            Err(SurfaceError::NotFinite { count: 1 + holes.count(), points: heights.len(), first: [i, j], value })
        }
    }
}
