//! Interpolation of heights on a finer grid.

use gfmd_field::Grid;
use ndarray::Array2;

use crate::SurfaceError;
use crate::pair::interpolated;

/// Method of interpolation between the points of a periodic grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Trigonometric interpolation, exact for a surface with waves that the grid resolves.
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
    heights: &Array2<f64>,
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
            _ if part == [0, 0] => heights.clone(),
            // The surface moves in the opposite direction.
            Interpolation::Waves => interpolated(heights, grid, steps.map(|step| -step))?,
            Interpolation::Cubic => cubic(heights, steps),
        };
        let mut every = found.slice_mut(ndarray::s![part[0]..;along[0], part[1]..;along[1]]);
        every.assign(&between);
    }
    Ok((found, fine))
}

/// Returns the heights displaced from the points by these fractions of a grid step.
fn cubic(heights: &Array2<f64>, steps: [f64; 2]) -> Array2<f64> {
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
