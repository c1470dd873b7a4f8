use std::borrow::Cow;
use std::ops::Range;

use gfmd_field::{Grid, Share, contiguous};
use ndarray::ArrayRef2;
use rayon::prelude::*;

use crate::{Moments, SurfaceError};

/// Statistics of heights over one period of a surface `[nx, ny]` or of a profile `[n, 1]`.
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
    /// Root-mean-square gradient by central differences (h(x+a) − h(x−a))/2a, including the seam; dimensionless.
    pub rms_gradient_central: f64,
    /// Root-mean-square gradient by forward differences (h(x+a) − h(x))/a, including the seam; dimensionless.
    pub rms_gradient_forward: f64,
    /// Root-mean-square gradient by forward differences without the differences across the seam, for heights that are
    /// not periodic.
    pub rms_gradient_inside: f64,
    /// Mean square of the Laplacian (h″ of a profile) by second differences between points inside, for heights that are
    /// not periodic, 1/length²; `None` with fewer than three points along an axis.
    pub mean_square_laplacian_inside: Option<f64>,
    /// Largest slope by forward differences, without the differences across the seam.
    pub max_slope: f64,
    /// Jump across the seam.
    pub seam: Seam,
}

/// Root-mean-square steps between neighbouring points across the periodic seam and inside. Their ratio measures how
/// well opposite edges fit together; it is about 1 for a periodic surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// Root-mean-square step from the last to the first point along x and y, length. Zero along an axis with one point.
    pub across: [f64; 2],
    /// Root-mean-square step between neighbours inside along x and along y, length. Zero along an axis with one point.
    pub inside: [f64; 2],
}

impl Seam {
    /// Returns the ratio across/inside along x and along y; `None` if all steps inside are zero.
    pub fn ratio(&self) -> [Option<f64>; 2] {
        [0, 1].map(|axis| (self.inside[axis] > 0.0).then(|| self.across[axis] / self.inside[axis]))
    }
}

impl Statistics {
    /// Computes the statistics of `heights`. Spectral statistics take the heights as one period, so that a step across
    /// the seam is part of the surface.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid) -> Result<Self, SurfaceError> {
        let [nx, ny] = grid.points();
        Self::distributed(heights, grid, &Share::whole(nx, ny))
    }

    /// Computes the statistics of distributed heights: each process passes the rows of its `share`. All processes get
    /// the statistics of the whole surface.
    ///
    /// # Errors
    /// The same errors as [`of`](Self::of), on all processes.
    pub fn distributed(heights: &ArrayRef2<f64>, grid: &Grid, share: &Share) -> Result<Self, SurfaceError> {
        let heights = checked_over(heights, grid, share)?;
        let moments = Moments::distributed(&heights, grid, share)?;
        let rows = rows(&heights, grid, share);
        let [nx, ny] = grid.points().map(|points| points as f64);
        let sum = |rows: &[Row], which: usize| rows.iter().map(|row| row.sums[which]).sum::<f64>();
        // Steps along x end in the next row or in the row after it.
        let along_x = |ahead: usize| {
            let (inside, across) = rows.split_at(rows.len().saturating_sub(ahead));
            [sum(inside, ahead), sum(across, ahead)]
        };
        let along_y = |which: usize| [sum(&rows, which), sum(&rows, which + 1)];
        let steps = [Steps::of([nx, ny], along_x(1), along_x(2)), Steps::of([ny, nx], along_y(3), along_y(5))];
        let spacing = grid.spacing();
        let gradient = |square: [f64; 2]| (square[0] / spacing[0].powi(2) + square[1] / spacing[1].powi(2)).sqrt();
        let most = |start: f64, value: fn(&Row) -> f64| rows.iter().map(value).fold(start, f64::max);
        Ok(Self {
            mean: sum(&rows, 0) / (nx * ny),
            lowest: rows.iter().map(|row| row.lowest).fold(f64::INFINITY, f64::min),
            highest: most(f64::NEG_INFINITY, |row| row.highest),
            moments,
            rms_gradient_central: gradient([0, 1].map(|axis| 0.25 * steps[axis].double)),
            rms_gradient_forward: gradient([0, 1].map(|axis| steps[axis].all)),
            rms_gradient_inside: gradient([0, 1].map(|axis| steps[axis].inside)),
            mean_square_laplacian_inside: {
                let lanes = if grid.is_line() { 1.0 } else { ny - 2.0 };
                (nx > 2.0 && lanes > 0.0).then(|| sum(&rows, 7) / ((nx - 2.0) * lanes))
            },
            max_slope: most(0.0, |row| row.steepest).sqrt(),
            seam: Seam {
                across: [0, 1].map(|axis| steps[axis].across.sqrt()),
                inside: [0, 1].map(|axis| steps[axis].inside.sqrt()),
            },
        })
    }

    /// Returns the moments of heights that do not repeat, from differences between points inside. `waves` and short
    /// waves are NaN, as is the Laplacian with fewer than three points along an axis.
    pub fn moments_inside(&self) -> Moments {
        Moments {
            mean_square_gradient: self.rms_gradient_inside.powi(2),
            mean_square_laplacian: self.mean_square_laplacian_inside.unwrap_or(f64::NAN),
            mean_square_gradient_of_short_waves: f64::NAN,
            waves: f64::NAN,
            ..self.moments
        }
    }

    /// Returns the highest minus the lowest height, length.
    pub fn peak_to_valley(&self) -> f64 {
        self.highest - self.lowest
    }
}

/// Mean square steps between points of a periodic axis.
#[derive(Default)]
struct Steps {
    /// Steps between neighbours, except across the seam.
    inside: f64,
    /// Step between the last and the first point.
    across: f64,
    /// Steps between all neighbours.
    all: f64,
    /// Steps between next-nearest neighbours, over all points.
    double: f64,
}

impl Steps {
    /// Returns mean squares from the sums of squared steps to nearest and next-nearest neighbours, inside and across
    /// the seam, on an axis with these numbers of points and lanes.
    fn of([points, lanes]: [f64; 2], [inside, across]: [f64; 2], double: [f64; 2]) -> Self {
        if points < 2.0 {
            return Self::default();
        }
        Self {
            inside: inside / (lanes * (points - 1.0)),
            across: across / lanes,
            all: (inside + across) / (lanes * points),
            double: (double[0] + double[1]) / (lanes * points),
        }
    }
}

/// Contributions of a row to the statistics of the surface. Sums are formed row by row to be bitwise identical for any
/// number of threads and processes.
#[derive(Clone, Copy)]
struct Row {
    /// Sums of heights; of squared steps to the next row and to the row after it; of squared steps along the row to
    /// nearest neighbours, inside and across the seam, and to next-nearest neighbours, inside and across the seam; of
    /// the squared Laplacian at the points inside of the next row.
    sums: [f64; 8],
    lowest: f64,
    highest: f64,
    /// Largest squared slope by forward differences inside.
    steepest: f64,
}

/// Returns the contributions of all rows from the heights of the rows of this process.
fn rows(heights: &[f64], grid: &Grid, share: &Share) -> Vec<Row> {
    let ([nx, ny], [dx, dy]) = (grid.points(), grid.spacing());
    let (own, first) = (heights.len() / ny, share.own().start / ny);
    let row = |i: usize| &heights[i * ny..(i + 1) * ny];
    // First two rows of the next process, around the cell.
    let [_, next] = share.beside(row(0), row(own - 1));
    let second = if own > 1 { row(1) } else { &next };
    let [_, after_next] = share.beside(second, row(own - 1));
    let ahead = |i: usize| if i < own { row(i) } else { [&next[..], &after_next][i - own] };
    let square = |here: f64, ahead: f64| (ahead - here).powi(2);
    let of_row = |i: usize| {
        let here = row(i);
        let (behind, second) = (ahead(i + 1), ahead(i + 2));
        // One sweep for sums that do not wait for each other.
        let [mut sum, mut steps, mut next_steps, mut step, mut double] = [0.0; 5];
        let (mut lowest, mut highest, mut steepest) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        let in_x = first + i + 1 < nx;
        let mut add = |j: usize, [beside, after]: [Option<f64>; 2]| {
            let h = here[j];
            sum += h;
            steps += square(h, behind[j]);
            next_steps += square(h, second[j]);
            step += beside.map_or(0.0, |beside| square(h, beside));
            double += after.map_or(0.0, |after| square(h, after));
            (lowest, highest) = (lowest.min(h), highest.max(h));
            let x = if in_x { (behind[j] - h) / dx } else { 0.0 };
            let y = beside.map_or(0.0, |beside| (beside - h) / dy);
            steepest = steepest.max(x * x + y * y);
        };
        let inside = ny.saturating_sub(2);
        (0..inside).for_each(|j| add(j, [Some(here[j + 1]), Some(here[j + 2])]));
        (inside..ny).for_each(|j| add(j, [here.get(j + 1).copied(), None]));
        let seam = square(here[ny - 1], here[0]);
        let double_seam = (inside..ny).zip(here).map(|(j, ahead)| square(here[j], *ahead)).sum();
        let laplacian = |j: usize| {
            let x = (here[j] - behind[j] + (second[j] - behind[j])) / (dx * dx);
            let y = if grid.is_line() {
                0.0
            } else {
                (behind[j - 1] - behind[j] + (behind[j + 1] - behind[j])) / (dy * dy)
            };
            x + y
        };
        let inner = if grid.is_line() { 0..1 } else { 1..ny.max(2) - 1 };
        let bent = if first + i + 2 < nx { inner.map(|j| laplacian(j).powi(2)).sum() } else { 0.0 };
        Row { sums: [sum, steps, next_steps, step, seam, double, double_seam, bent], lowest, highest, steepest }
    };
    let found: Vec<Row> = (0..own).into_par_iter().map(of_row).collect();
    if share.is_whole() {
        return found;
    }
    let words: Vec<([f64; 8], [f64; 3])> =
        found.iter().map(|row| (row.sums, [row.lowest, row.highest, row.steepest])).collect();
    let lengths: Vec<usize> = share.all_rows().iter().map(Range::len).collect();
    let all = share.collect(&words, &lengths).into_iter();
    all.map(|(sums, [lowest, highest, steepest])| Row { sums, lowest, highest, steepest }).collect()
}

/// Checks the rows of a process by [`checked`]. If one process refuses its rows, all do.
fn checked_over<'a>(heights: &'a ArrayRef2<f64>, grid: &Grid, share: &Share) -> Result<Cow<'a, [f64]>, SurfaceError> {
    if share.is_whole() {
        return checked(heights, grid);
    }
    let ([_, ny], start) = (grid.points(), share.rows().start);
    let (found, expected) = (<[usize; 2]>::from(heights.dim()), [share.rows().len(), ny]);
    if share.any(found != expected) {
        return Err(SurfaceError::Shape { found, expected });
    }
    let holes = || heights.indexed_iter().filter(|(_, h)| !h.is_finite());
    let first = holes().next().map(|((i, j), value)| ([start + i, j], *value));
    let count = share.each(holes().count()).into_iter().sum();
    if let Some((first, value)) = share.first(first) {
        return Err(SurfaceError::NotFinite { count, points: share.total(), first, value });
    }
    Ok(contiguous(heights))
}

/// Returns the heights in the storage order of the grid if they have its shape and are finite.
pub(crate) fn checked<'a>(heights: &'a ArrayRef2<f64>, grid: &Grid) -> Result<Cow<'a, [f64]>, SurfaceError> {
    let (nx, ny) = heights.dim();
    if [nx, ny] != grid.points() {
        return Err(SurfaceError::Shape { found: [nx, ny], expected: grid.points() });
    }
    finite(heights)?;
    Ok(contiguous(heights))
}

/// Refuses heights that are NaN or infinite; the error has their number and the first of them.
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
