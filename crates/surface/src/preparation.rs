use std::f64::consts::PI;

use gfmd_field::{Grid, Share, contiguous};
use ndarray::{Array2, ArrayRef2, ArrayView1, ArrayView2, s};

use crate::SurfaceError;
use crate::names::named;
use crate::statistics::{checked, finite};

/// Part of a scan that is not roughness and that [`remove`] subtracts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trend {
    /// Mean height.
    Mean,
    /// Plane with the least squared distance from the heights. Its removal leaves the smallest rms height.
    Plane,
    /// Plane with the mean slope, the mean of the forward differences at all points with a neighbour along both axes.
    /// Its removal leaves the smallest rms gradient and joins opposite edges on average.
    Slope,
    /// Paraboloid of 1, x, y, x², xy, y² with the least squared distance. It includes the bow of a scanner or a radius.
    Quadratic,
}

named! { Trend, "trend":
    Mean = "mean", "the mean height";
    Plane = "plane", "the least-squares plane";
    Slope = "slope", "the plane of the mean slope, which joins opposite edges on average";
    Quadratic = "quadratic", "the least-squares paraboloid";
}

/// Method to turn heights that are not periodic into one period of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Periodisation {
    /// No change: the step between opposite edges becomes part of the surface. It adds to all gradients and, with C ∝
    /// q⁻² along the axes, to the spectrum. Use it for periodic heights.
    AsIs,
    /// Heights and their mirror images, an even extension to `[2nx, 2ny]` points in a cell twice as long. It has no
    /// step but a crease between the images. The height distribution does not change; gradients change only at the
    /// seams. The cell has mirror planes, its longest wavelength doubles, and a correlation of h_x with h_y is lost.
    Mirror,
}

named! { Periodisation, "periodisation":
    AsIs = "as-is", "not at all: opposite edges meet in a step";
    Mirror = "mirror", "by mirror images: no step, four times the points";
}

/// Returns the heights without their trend. The fit uses indices, so that lengths do not matter.
///
/// # Errors
/// Heights that are not finite; fewer than 2 points along an axis (not a profile's y) for a tilt, 3 for a paraboloid.
pub fn remove(heights: &ArrayRef2<f64>, trend: Trend) -> Result<Array2<f64>, SurfaceError> {
    finite(heights)?;
    let (nx, ny) = heights.dim();
    let (least, what) = match trend {
        Trend::Mean => (1, "removing the mean"),
        Trend::Plane | Trend::Slope => (2, "removing a tilt"),
        Trend::Quadratic => (3, "removing a paraboloid"),
    };
    if nx < least || ny < if ny == 1 { 1 } else { least } {
        return Err(SurfaceError::TooFewPoints { what, least, found: [nx, ny] });
    }
    let (x, y) = (centred(nx), centred(ny));
    // The check of the number of points ensures that there are heights.
    let mut rest = heights - heights.mean().unwrap_or(0.0);
    match trend {
        Trend::Mean => {}
        Trend::Plane => {
            project_out(&mut rest, &x[1], &y[0]);
            project_out(&mut rest, &x[0], &y[1]);
        }
        Trend::Slope => {
            let [along_x, along_y] = mean_slope(&rest);
            for ((i, j), height) in rest.indexed_iter_mut() {
                *height -= along_x * x[1][i] + along_y * y[1][j];
            }
        }
        Trend::Quadratic => {
            for [a, b] in [[1, 0], [0, 1], [2, 0], [1, 1], [0, 2]] {
                project_out(&mut rest, &x[a], &y[b]);
            }
        }
    }
    Ok(rest)
}

/// Returns the heights without the trend of their defined points. Undefined points (NaN) remain undefined. Without
/// undefined points, equivalent to [`remove`].
///
/// # Errors
/// Infinite heights; too few defined points to determine the trend.
pub fn remove_from_defined(heights: &ArrayRef2<f64>, trend: Trend) -> Result<Array2<f64>, SurfaceError> {
    if heights.iter().any(|height| height.is_infinite()) || !heights.iter().any(|height| height.is_nan()) {
        return remove(heights, trend);
    }
    let (nx, ny) = heights.dim();
    let too_few = |what, least| SurfaceError::TooFewPoints { what, least, found: [nx, ny] };
    let scaled = |i: usize, n: usize| if n > 1 { 2.0 * i as f64 / (n as f64 - 1.0) - 1.0 } else { 0.0 };
    let terms = |i: usize, j: usize| {
        let (x, y) = (scaled(i, nx), scaled(j, ny));
        [1.0, x, y, x * x, x * y, y * y]
    };
    let used: &[usize] = match (trend, ny) {
        (Trend::Mean | Trend::Slope, _) => &[0],
        (Trend::Plane, 1) => &[0, 1],
        (Trend::Plane, _) => &[0, 1, 2],
        (Trend::Quadratic, 1) => &[0, 1, 3],
        (Trend::Quadratic, _) => &[0, 1, 2, 3, 4, 5],
    };
    let mut rest = heights.to_owned();
    if trend == Trend::Slope {
        let [along_x, along_y] = defined_slope(heights).ok_or_else(|| too_few("removing a tilt", 2))?;
        rest.indexed_iter_mut().for_each(|((i, j), h)| *h -= along_x * i as f64 + along_y * j as f64);
    }
    // Two passes: the second fit removes the rounding error of the first.
    for _ in 0..2 {
        let mut equations = vec![vec![0.0; used.len() + 1]; used.len()];
        for ((i, j), height) in rest.indexed_iter().filter(|(_, height)| !height.is_nan()) {
            let terms = terms(i, j);
            for (row, &a) in equations.iter_mut().zip(used) {
                row.iter_mut().zip(used).for_each(|(sum, &b)| *sum += terms[a] * terms[b]);
                row[used.len()] += terms[a] * height;
            }
        }
        let solution = eliminate(equations).ok_or_else(|| too_few("removing the trend of the defined points", 3))?;
        for ((i, j), height) in rest.indexed_iter_mut() {
            let terms = terms(i, j);
            *height -= used.iter().zip(&solution).map(|(&term, c)| c * terms[term]).sum::<f64>();
        }
    }
    Ok(rest)
}

/// Returns the mean forward differences over pairs of defined neighbours, or `None` if there are none.
fn defined_slope(heights: &ArrayRef2<f64>) -> Option<[f64; 2]> {
    let mean = |step: [usize; 2]| {
        let differences = heights.indexed_iter().filter_map(|((i, j), here)| {
            let difference = heights.get([i + step[0], j + step[1]])? - here;
            (!difference.is_nan()).then_some(difference)
        });
        let (count, sum) = differences.fold((0_usize, 0.0), |(count, sum), difference| (count + 1, sum + difference));
        (count > 0).then(|| sum / count as f64)
    };
    Some([mean([1, 0])?, if heights.ncols() == 1 { 0.0 } else { mean([0, 1])? }])
}

/// Solves symmetric positive definite equations with the right-hand side in the last column; `None` if singular.
fn eliminate(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let count = rows.len();
    for k in 0..count {
        // If the terms depend on each other on these points, only rounding error remains on the diagonal.
        if rows[k][k].is_nan() || rows[k][k] <= 1e-10 * rows[0][0] {
            return None;
        }
        let pivot = rows[k].clone();
        for row in &mut rows[k + 1..] {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(&pivot).for_each(|(value, pivot)| *value -= factor * pivot);
        }
    }
    let mut solution = vec![0.0; count];
    for k in (0..count).rev() {
        let known: f64 = (k + 1..count).map(|l| rows[k][l] * solution[l]).sum();
        solution[k] = (rows[k][count] - known) / rows[k][k];
    }
    Some(solution)
}

/// Returns periodic heights and their grid.
///
/// # Errors
/// Heights that do not have the shape of the grid or are not finite.
pub fn periodise(
    heights: &ArrayRef2<f64>,
    grid: &Grid,
    how: Periodisation,
) -> Result<(Array2<f64>, Grid), SurfaceError> {
    checked(heights, grid)?;
    match how {
        Periodisation::AsIs => Ok((heights.to_owned(), *grid)),
        Periodisation::Mirror => mirrored(heights, grid),
    }
}

/// Returns the deviations of `heights` from their mean times a Tukey window, for the spectrum of a non-periodic scan.
///
/// The window falls to zero at the edges as a cosine over the fraction `taper` of each side, half of it at either end
/// (1: Hann window, 0: no window). It is divided by its rms value, so that the mean square of homogeneous roughness
/// does not change. Heights and gradients then vary over the cell: do not use them in contact calculations.
///
/// # Errors
/// Heights that are not finite; a taper outside \[0, 1\].
pub fn window(heights: &ArrayRef2<f64>, taper: f64) -> Result<Array2<f64>, SurfaceError> {
    finite(heights)?;
    if !(0.0..=1.0).contains(&taper) {
        return Err(SurfaceError::Taper(taper));
    }
    let (nx, ny) = heights.dim();
    Ok(window_rows(&Share::whole(nx, ny), heights, (taper, row_mean(heights))))
}

/// Returns the mean of heights, summed row by row; 0 without heights.
pub fn row_mean(heights: &ArrayRef2<f64>) -> f64 {
    ArrayView1::from(&*contiguous(heights)).mean().unwrap_or(0.0)
}

/// Returns the rows of this process of the heights below a [`window`] with this taper, from the mean of all heights.
pub fn window_rows(share: &Share, heights: &ArrayRef2<f64>, (taper, mean): (f64, f64)) -> Array2<f64> {
    let (rows, ny) = heights.dim();
    let (first, nx) = (share.rows().start, share.total().checked_div(ny).unwrap_or(0));
    let (x, y) = (tukey(nx, taper), tukey(ny, taper));
    Array2::from_shape_fn((rows, ny), |(i, j)| (heights[[i, j]] - mean) * x[first + i] * y[j])
}

/// Returns the polynomials 1, i, i² on n points, centred and orthogonalised: discrete Legendre polynomials.
fn centred(points: usize) -> [Vec<f64>; 3] {
    let middle = 0.5 * (points as f64 - 1.0);
    let linear: Vec<f64> = (0..points).map(|i| i as f64 - middle).collect();
    let spread = linear.iter().map(|x| x * x).sum::<f64>() / points as f64;
    let quadratic = linear.iter().map(|x| x * x - spread).collect();
    [vec![1.0; points], linear, quadratic]
}

/// Subtracts from the heights their projection on a(x) b(y). Products of orthogonal polynomials are orthogonal on the
/// lattice, so that successive projections give the joint fit.
fn project_out(heights: &mut Array2<f64>, a: &[f64], b: &[f64]) {
    let norm: f64 = a.iter().map(|x| x * x).sum::<f64>() * b.iter().map(|y| y * y).sum::<f64>();
    if norm == 0.0 {
        return; // y of a profile
    }
    let overlap: f64 =
        heights.outer_iter().zip(a).map(|(row, x)| x * row.iter().zip(b).map(|(h, y)| h * y).sum::<f64>()).sum();
    let coefficient = overlap / norm;
    for (mut row, x) in heights.outer_iter_mut().zip(a) {
        row.iter_mut().zip(b).for_each(|(h, y)| *h -= coefficient * x * y);
    }
}

/// Returns the mean forward difference per index along x and y, over the points with a neighbour along both axes.
fn mean_slope(heights: &ArrayRef2<f64>) -> [f64; 2] {
    let (nx, ny) = heights.dim();
    let mean = |ahead: ArrayView2<f64>, here: ArrayView2<f64>| {
        ahead.iter().zip(here).map(|(a, h)| a - h).sum::<f64>() / ahead.len() as f64
    };
    if ny == 1 {
        return [mean(heights.slice(s![1.., ..]), heights.slice(s![..-1, ..])), 0.0];
    }
    let here = heights.slice(s![..nx - 1, ..ny - 1]);
    [mean(heights.slice(s![1.., ..-1]), here), mean(heights.slice(s![..-1, 1..]), here)]
}

fn mirrored(heights: &ArrayRef2<f64>, grid: &Grid) -> Result<(Array2<f64>, Grid), SurfaceError> {
    let ([nx, ny], [lx, ly]) = (grid.points(), grid.lengths());
    let image = |index: usize, points: usize| if index < points { index } else { 2 * points - 1 - index };
    let twice = if grid.is_line() {
        Grid::new([2 * nx, 1], [2.0 * lx, ly])?
    } else {
        Grid::new([2 * nx, 2 * ny], [2.0 * lx, 2.0 * ly])?
    };
    Ok((Array2::from_shape_fn(twice.points(), |(i, j)| heights[[image(i, nx), image(j, ny)]]), twice))
}

/// Returns the Tukey window at the centres of n intervals, divided by its rms value; 1 for a single point.
fn tukey(points: usize, taper: f64) -> Vec<f64> {
    if points == 1 {
        return vec![1.0];
    }
    let rise = |i: usize| {
        let edge = (i as f64 + 0.5).min(points as f64 - i as f64 - 0.5) / points as f64;
        if 2.0 * edge < taper { 0.5 - 0.5 * (2.0 * PI * edge / taper).cos() } else { 1.0 }
    };
    let window: Vec<f64> = (0..points).map(rise).collect();
    let rms = (window.iter().map(|w| w * w).sum::<f64>() / points as f64).sqrt();
    window.into_iter().map(|w| w / rms).collect()
}
