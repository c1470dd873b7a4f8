//! Interpolation of heights on a finer grid.

use gfmd_field::{Grid, Spline};
use ndarray::{Array2, ArrayRef2, Axis, s};

use crate::SurfaceError;
use crate::pair::interpolated;
use crate::statistics::checked;

/// Method of interpolation between the points of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Trigonometric interpolation, exact for a periodic surface with waves that the grid resolves. On a patch, which
    /// has no waves, the cubic spline.
    #[default]
    Waves,
    /// Local cubic polynomials through four neighbours along each axis (Keys 1981).
    Cubic,
}

/// Returns the heights on a grid of the same cell with `times` as many points along each side, and the grid. The given
/// heights are kept.
///
/// # Errors
/// Heights that do not have the shape of the grid or are not finite; `times` of zero; a grid with too many points.
pub fn finer(
    heights: &ArrayRef2<f64>,
    grid: &Grid,
    times: usize,
    how: Interpolation,
) -> Result<(Array2<f64>, Grid), SurfaceError> {
    let along = [times, if grid.is_line() { 1 } else { times }];
    let [nx, ny] = grid.points();
    let fine = Grid::new([nx.saturating_mul(along[0]), ny.saturating_mul(along[1])], grid.lengths())?;
    let mut found = Array2::zeros(fine.points());
    let parts = (0..along[0]).flat_map(|i| (0..along[1]).map(move |j| [i, j]));
    for part in parts {
        let steps = [0, 1].map(|axis| part[axis] as f64 / along[axis] as f64);
        let between = match how {
            _ if part == [0, 0] => heights.to_owned(),
            // The surface moves in the opposite direction.
            Interpolation::Waves => interpolated(heights, grid, steps.map(|step| -step))?,
            Interpolation::Cubic => cubic(heights, steps),
        };
        let mut every = found.slice_mut(ndarray::s![part[0]..;along[0], part[1]..;along[1]]);
        every.assign(&between);
    }
    Ok((found, fine))
}

/// Largest number of points beyond each rim of a patch; a cubic spline forgets its ends by a factor of 0.27 per point.
const BEYOND: usize = 16;

/// Returns the heights of a patch on a grid with `times` as many points along each side, and the grid. Points are the
/// centres of equal cells, which fill the same patch on both grids; heights of the outermost points follow from a
/// continuation beyond the rim that is point symmetric about the last point.
///
/// # Errors
/// Heights that do not have the shape of the grid or are not finite; `times` of zero; a grid with too many points.
pub fn finer_inside(
    heights: &ArrayRef2<f64>,
    grid: &Grid,
    times: usize,
    how: Interpolation,
) -> Result<(Array2<f64>, Grid), SurfaceError> {
    checked(heights, grid)?;
    let along = [times, if grid.is_line() { 1 } else { times }];
    let points = grid.points();
    let fine = Grid::new([0, 1].map(|axis| points[axis].saturating_mul(along[axis])), grid.lengths())?;
    let beyond = points.map(|points| BEYOND.min(points - 1));
    let continued = continued(&continued(heights, Axis(0), beyond[0]), Axis(1), beyond[1]);
    let spacing = grid.spacing();
    let lengths = [0, 1].map(|axis| spacing[axis] * continued.len_of(Axis(axis)) as f64);
    let around = Grid::new(continued.dim().into(), lengths)?;
    let spline = Spline::through(&around, &continued.iter().copied().collect::<Vec<f64>>())?;
    let mut found = Array2::zeros(fine.points());
    let parts = (0..along[0]).flat_map(|i| (0..along[1]).map(move |j| [i, j]));
    for part in parts {
        // Place of the finer centres relative to the coarser ones, in steps of the coarser grid.
        let steps = [0, 1].map(|axis| (part[axis] as f64 + 0.5) / along[axis] as f64 - 0.5);
        let mut every = found.slice_mut(s![part[0]..;along[0], part[1]..;along[1]]);
        match how {
            _ if steps == [0.0; 2] => every.assign(heights),
            Interpolation::Waves => {
                let offset = [0, 1].map(|axis| steps[axis] * spacing[axis]);
                every.indexed_iter_mut().for_each(|((i, j), height)| {
                    *height = spline.near([i + beyond[0], j + beyond[1]], offset).0;
                });
            }
            Interpolation::Cubic => {
                let before = [0, 1].map(|axis| usize::from(steps[axis] < 0.0));
                let between = cubic(&continued, [0, 1].map(|axis| steps[axis] + before[axis] as f64));
                let [x, y] = [0, 1].map(|axis| beyond[axis] - before[axis]);
                every.assign(&between.slice(s![x..x + points[0], y..y + points[1]]));
            }
        }
    }
    Ok((found, fine))
}

/// Returns the heights of a periodic surface at the cell centres of a patch, whose grid has `times` as many points as
/// another one with points where the waves begin ([`finer_inside`]).
///
/// # Errors
/// Heights that do not have the shape of the grid or are not finite.
pub fn centred(heights: &ArrayRef2<f64>, grid: &Grid, times: usize) -> Result<Array2<f64>, SurfaceError> {
    let step = 0.5 * (times as f64 - 1.0);
    interpolated(heights, grid, [step, if grid.is_line() { 0.0 } else { step }])
}

/// Returns the heights with `beyond` more points at both ends of an axis, point symmetric about its first and last.
fn continued(heights: &ArrayRef2<f64>, axis: Axis, beyond: usize) -> Array2<f64> {
    let length = heights.len_of(axis);
    let mut shape = heights.raw_dim();
    shape[axis.index()] += 2 * beyond;
    let mut all = Array2::zeros(shape);
    for (k, mut lane) in all.axis_iter_mut(axis).enumerate() {
        let at = |index: usize| heights.index_axis(axis, index);
        if k < beyond {
            lane.assign(&(2.0 * &at(0) - at(beyond - k)));
        } else if k < beyond + length {
            lane.assign(&at(k - beyond));
        } else {
            lane.assign(&(2.0 * &at(length - 1) - at(2 * (length - 1) + beyond - k)));
        }
    }
    all
}

/// Returns the heights displaced from the points by these fractions of a grid step.
fn cubic(heights: &ArrayRef2<f64>, steps: [f64; 2]) -> Array2<f64> {
    let (nx, ny) = heights.dim();
    let [x, y] = steps.map(weights);
    let along_y = Array2::from_shape_fn((nx, ny), |(i, j)| -> f64 {
        (0..4).map(|k| y[k] * heights[[i, (j + ny + k - 1) % ny]]).sum()
    });
    Array2::from_shape_fn((nx, ny), |(i, j)| (0..4).map(|k| x[k] * along_y[[(i + nx + k - 1) % nx, j]]).sum())
}

/// Returns the weights of the previous point, the point and the next two points at the fraction `t` of a step.
fn weights(t: f64) -> [f64; 4] {
    let (square, cube) = (t * t, t * t * t);
    [
        square - 0.5 * (cube + t),
        1.0 - 2.5 * square + 1.5 * cube,
        2.0 * square + 0.5 * t - 1.5 * cube,
        0.5 * (cube - square),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn wave(grid: &Grid) -> Array2<f64> {
        let [a, b] = grid.spacing();
        Array2::from_shape_fn(grid.points(), |(i, j)| (TAU * (2.0 * a * i as f64 + b * j as f64)).sin())
    }

    #[test]
    fn waves_of_the_grid_are_exact_between_its_points_and_cubics_are_of_third_order() {
        let grid = Grid::new([16, 24], [1.0, 1.0]).unwrap();
        for times in [1, 2, 3] {
            let (found, fine) = finer(&wave(&grid), &grid, times, Interpolation::Waves).unwrap();
            assert_eq!(fine.points(), [16 * times, 24 * times]);
            let error = (&found - &wave(&fine)).fold(0.0, |most: f64, error| most.max(error.abs()));
            assert!(error < 1e-14, "{times}: {error}");
        }
        let error = |n: usize| {
            let grid = Grid::square(n, 1.0).unwrap();
            let (found, fine) = finer(&wave(&grid), &grid, 2, Interpolation::Cubic).unwrap();
            (&found - &wave(&fine)).fold(0.0, |most: f64, error| most.max(error.abs()))
        };
        let order = (error(64) / error(128)).log2();
        assert!((2.8..4.2).contains(&order), "{order}");
    }

    /// Heights of a tilted wave at the centres of cells, with no period in the patch.
    fn tilted(grid: &Grid) -> Array2<f64> {
        let [a, b] = grid.spacing();
        let at = |step: f64, index: usize| step * (index as f64 + 0.5);
        Array2::from_shape_fn(grid.points(), |(i, j)| 0.5 * at(a, i) + (3.0 * at(a, i) + at(b, j)).sin())
    }

    #[test]
    fn points_of_a_patch_stay_centres_of_cells() {
        let (heights, grid) =
            (tilted(&Grid::new([40, 24], [1.0, 1.0]).unwrap()), Grid::new([40, 24], [1.0, 1.0]).unwrap());
        for how in [Interpolation::Waves, Interpolation::Cubic] {
            for times in [1, 2, 3] {
                let (found, fine) = finer_inside(&heights, &grid, times, how).unwrap();
                assert_eq!((fine.points(), fine.lengths()), ([40 * times, 24 * times], [1.0, 1.0]));
                let error = &found - &tilted(&fine);
                let most = |part: ndarray::ArrayView2<'_, f64>| part.fold(0.0, |most: f64, e| most.max(e.abs()));
                let m = 6 * times;
                let inside = most(error.slice(s![m..40 * times - m, m..24 * times - m]));
                assert!(inside < 1e-4 && most(error.view()) < 5e-3, "{how:?} {times}: {inside} {}", most(error.view()));
            }
        }
        assert!(finer_inside(&heights, &grid, 0, Interpolation::Waves).is_err());
    }

    #[test]
    fn the_interpolation_of_a_patch_has_its_order_and_a_profile_stays_one() {
        let error = |n: usize, how: Interpolation| {
            let grid = Grid::square(n, 1.0).unwrap();
            let (found, fine) = finer_inside(&tilted(&grid), &grid, 2, how).unwrap();
            let error = &found - &tilted(&fine);
            error.slice(s![n / 2..3 * n / 2, n / 2..3 * n / 2]).fold(0.0, |most: f64, e| most.max(e.abs()))
        };
        let order = |how: Interpolation| (error(32, how) / error(64, how)).log2();
        assert!((3.8..4.2).contains(&order(Interpolation::Waves)), "{}", order(Interpolation::Waves));
        assert!((2.8..4.2).contains(&order(Interpolation::Cubic)), "{}", order(Interpolation::Cubic));
        let grid = Grid::line(32, 1.0).unwrap();
        let (found, fine) = finer_inside(&tilted(&grid), &grid, 2, Interpolation::Waves).unwrap();
        assert_eq!((fine.points(), found.dim()), ([64, 1], (64, 1)));
    }

    #[test]
    fn waves_have_exact_heights_at_the_centres() {
        let grid = Grid::new([32, 48], [1.0, 1.0]).unwrap();
        let moved = |grid: &Grid, times: f64| {
            let [a, b] = grid.spacing();
            let at = |step: f64, index: usize| step * (index as f64 - 0.5 * (times - 1.0));
            Array2::from_shape_fn(grid.points(), |(i, j)| (TAU * (2.0 * at(a, i) + at(b, j))).sin())
        };
        for times in [1, 2, 3] {
            let found = centred(&wave(&grid), &grid, times).unwrap();
            let error = (&found - &moved(&grid, times as f64)).fold(0.0, |most: f64, e| most.max(e.abs()));
            assert!(error < 1e-14, "{times}: {error}");
        }
    }

    #[test]
    fn a_profile_stays_one_and_no_times_are_refused() {
        let grid = Grid::line(16, 1.0).unwrap();
        let heights = Array2::from_shape_fn((16, 1), |(i, _)| (TAU * i as f64 / 16.0).cos());
        for how in [Interpolation::Waves, Interpolation::Cubic] {
            let (found, fine) = finer(&heights, &grid, 2, how).unwrap();
            assert_eq!((fine.points(), found.dim()), ([32, 1], (32, 1)));
            assert!((found[[1, 0]] - (TAU / 32.0).cos()).abs() < 2e-3);
        }
        assert!(finer(&heights, &grid, 0, Interpolation::Waves).is_err());
    }
}
