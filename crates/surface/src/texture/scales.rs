use gfmd_field::Grid;
use ndarray::ArrayRef2;
use rayon::prelude::*;

use crate::SurfaceError;
use crate::statistics::checked;

/// Number of distances per decade.
const PER_DECADE: f64 = 10.0;

/// Roughness of a surface against the distance of its measurement, along x and along y, as pairs of distance and value.
///
/// The slope at a distance r is √⟨(h(x+r) − h(x))²⟩/r; the curvature at a distance r, the length of its three points,
/// is √⟨(h(x+r/2) − 2h(x) + h(x−r/2))²⟩/(r/2)² (A. Sanner et al., Appl. Surf. Sci. Adv. 7, 100190 (2022)). Distances
/// are whole numbers of grid steps up to half of the side, about ten per decade. Means are over all points if the
/// heights repeat, otherwise over the differences inside.
#[derive(Clone, Debug, PartialEq)]
pub struct Scales {
    /// Root-mean-square slopes along x and along y; empty along y for a profile.
    pub slope: [Vec<[f64; 2]>; 2],
    /// Root-mean-square curvatures along x and along y, 1/length.
    pub curvature: [Vec<[f64; 2]>; 2],
}

impl Scales {
    /// Computes the roughness of heights `[nx, ny]`, or of a profile `[n, 1]`.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid, repeats: bool) -> Result<Self, SurfaceError> {
        let all = checked(heights, grid)?;
        let (points, spacing) = (grid.points(), grid.spacing());
        let root = |axis: usize, by: usize, order: i32| {
            let step = by as f64 * spacing[axis];
            let (mut sum, mut count) = (0.0, 0_usize);
            let mut add = |difference: f64| (sum, count) = (sum + difference * difference, count + 1);
            match order {
                1 => steps(&all, points, axis, by, repeats, |[here, ahead]| add(ahead - here)),
                _ => bends(&all, points, axis, by, repeats, |[behind, here, ahead]| add(behind - 2.0 * here + ahead)),
            }
            [f64::from(order) * step, (sum / count as f64).sqrt() / step.powi(order)]
        };
        let along = |axis: usize, order: i32| -> Vec<[f64; 2]> {
            if points[axis] == 1 {
                return Vec::new();
            }
            distances(points[axis] / (2 * order as usize)).into_par_iter().map(|by| root(axis, by, order)).collect()
        };
        Ok(Self { slope: [along(0, 1), along(1, 1)], curvature: [along(0, 2), along(1, 2)] })
    }
}

/// Returns whole numbers from 1 to `most`, about ten per decade.
fn distances(most: usize) -> Vec<usize> {
    let rounded = (0..).map(|k| 10_f64.powf(f64::from(k) / PER_DECADE).round() as usize);
    let mut found: Vec<usize> = rounded.take_while(|by| *by <= most).collect();
    found.dedup();
    found
}

/// Calls `take` with each pair of heights `by` steps apart along an axis.
pub(super) fn steps(
    all: &[f64],
    [nx, ny]: [usize; 2],
    axis: usize,
    by: usize,
    repeats: bool,
    mut take: impl FnMut([f64; 2]),
) {
    let last = |n: usize| if repeats { n } else { n.saturating_sub(by) };
    match axis {
        0 => {
            for i in 0..last(nx) {
                let (here, ahead) = (&all[i * ny..][..ny], &all[(i + by) % nx * ny..][..ny]);
                here.iter().zip(ahead).for_each(|(here, ahead)| take([*here, *ahead]));
            }
        }
        _ => {
            for row in all.chunks_exact(ny) {
                (0..last(ny)).for_each(|j| take([row[j], row[(j + by) % ny]]));
            }
        }
    }
}

/// Calls `take` with each triple of heights `by` steps apart along an axis.
fn bends(all: &[f64], [nx, ny]: [usize; 2], axis: usize, by: usize, repeats: bool, mut take: impl FnMut([f64; 3])) {
    let last = |n: usize| if repeats { n } else { n.saturating_sub(2 * by) };
    match axis {
        0 => {
            for i in 0..last(nx) {
                let row = |i: usize| &all[i % nx * ny..][..ny];
                let rows = row(i).iter().zip(row(i + by)).zip(row(i + 2 * by));
                rows.for_each(|((behind, here), ahead)| take([*behind, *here, *ahead]));
            }
        }
        _ => {
            for row in all.chunks_exact(ny) {
                (0..last(ny)).for_each(|j| take([row[j], row[(j + by) % ny], row[(j + 2 * by) % ny]]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use std::f64::consts::TAU;

    use super::*;
    use crate::Autocorrelation;

    #[test]
    fn a_wave_has_its_slopes_and_curvatures() {
        let (n, length) = (512, 3.0);
        let q = TAU * 5.0 / length;
        let grid = Grid::new([n, 16], [length, 1.0]).unwrap();
        let wave = Array2::from_shape_fn((n, 16), |(i, _)| (q * i as f64 * length / n as f64).cos());
        let found = Scales::of(&wave, &grid, true).unwrap();
        for [r, slope] in &found.slope[0] {
            let wanted = 2.0_f64.sqrt() * (0.5 * q * r).sin().abs() / r;
            assert!((slope - wanted).abs() < 1e-12 * q, "{r} {slope} {wanted}");
        }
        for [r, curvature] in &found.curvature[0] {
            let wanted = 0.5_f64.sqrt() * 4.0 * (0.25 * q * r).sin().powi(2) / (0.5 * r).powi(2);
            assert!((curvature - wanted).abs() < 1e-10 * q * q, "{r} {curvature} {wanted}");
        }
        assert!(found.slope[1].iter().chain(&found.curvature[1]).all(|[_, value]| *value == 0.0));
        assert_eq!(found.slope[0].last().map(|[r, _]| *r <= 0.5 * length), Some(true));
        assert_eq!(distances(20), [1, 2, 3, 4, 5, 6, 8, 10, 13, 16, 20]);
    }

    #[test]
    fn slopes_are_those_of_the_autocorrelation() {
        let grid = Grid::new([24, 18], [2.0, 1.0]).unwrap();
        let heights = Array2::from_shape_fn((24, 18), |(i, j)| ((i * 7 + j * 5) % 9) as f64);
        for repeats in [true, false] {
            let found = Scales::of(&heights, &grid, repeats).unwrap();
            let correlation = Autocorrelation::of(&heights, &grid, repeats).unwrap();
            for axis in 0..2 {
                let along = correlation.along(axis);
                for [r, slope] in &found.slope[axis] {
                    let [_, difference] = along[(r / grid.spacing()[axis]).round() as usize];
                    assert!((slope - (2.0 * difference).sqrt() / r).abs() < 1e-10);
                }
            }
        }
        let line = Scales::of(&Array2::zeros((3, 1)), &Grid::line(3, 1.0).unwrap(), false).unwrap();
        assert_eq!((line.slope[0].len(), line.curvature[0].len(), line.slope[1].len()), (1, 0, 0));
    }
}
