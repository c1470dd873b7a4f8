use gfmd_field::Grid;
use ndarray::ArrayRef2;

use super::scales::steps;
use crate::SurfaceError;
use crate::statistics::checked;

/// Number of bins of a distribution.
const BINS: usize = 100;

/// Largest extent of the bins on either side of the mean, in standard deviations.
const WIDE: f64 = 6.0;

/// Distribution of values in bins of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    /// Centres of the bins.
    pub middles: Vec<f64>,
    /// Number of values in a bin divided by the number of all values and by the bin width.
    pub densities: Vec<f64>,
    /// Fraction of values outside the bins, farther than 6 standard deviations from the mean.
    pub outside: f64,
    /// Mean of all values.
    pub mean: f64,
    /// Standard deviation of all values.
    pub deviation: f64,
}

impl Density {
    /// Computes the distribution of values over 100 bins between the lowest and the highest one, at most 6 standard
    /// deviations on either side of the mean. Returns `None` if all values are equal.
    pub fn of(values: &[f64]) -> Option<Self> {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let deviation = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
        let [lowest, highest] =
            values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &value| [a.min(value), b.max(value)]);
        let (low, high) = (lowest.max(mean - WIDE * deviation), highest.min(mean + WIDE * deviation));
        let width = (high - low) / BINS as f64;
        // Equal values may differ from their mean by rounding.
        if !(lowest < highest && width > 0.0 && low + width > low && high - width < high) {
            return None;
        }
        let mut counts = vec![0_u64; BINS];
        for value in values.iter().filter(|value| (low..=high).contains(*value)) {
            counts[(((value - low) / width) as usize).min(BINS - 1)] += 1;
        }
        let inside: u64 = counts.iter().sum();
        Some(Self {
            middles: (0..BINS).map(|bin| low + (bin as f64 + 0.5) * width).collect(),
            densities: counts.into_iter().map(|own| own as f64 / (count * width)).collect(),
            outside: 1.0 - inside as f64 / count,
            mean,
            deviation,
        })
    }

    /// Returns the density of a Gaussian of the same mean and standard deviation at the bin centres.
    pub fn gaussian(&self) -> Vec<f64> {
        let density = |value: &f64| {
            let x = (value - self.mean) / self.deviation;
            (-0.5 * x * x).exp() / (std::f64::consts::TAU.sqrt() * self.deviation)
        };
        self.middles.iter().map(density).collect()
    }
}

/// Distributions of a surface; `None` without values, or if all values are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct Distributions {
    /// Heights above their mean, length.
    pub height: Option<Density>,
    /// Slopes along x by forward differences.
    pub slope_x: Option<Density>,
    /// Slopes along y by forward differences; `None` for a profile.
    pub slope_y: Option<Density>,
    /// Curvatures by central second differences, 1/length: mean of the curvatures along x and y; h'' for a profile.
    pub curvature: Option<Density>,
}

impl Distributions {
    /// Computes the distributions of heights `[nx, ny]`, or of a profile `[n, 1]`. Differences cross the edges of the
    /// cell if it `repeats`.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid, repeats: bool) -> Result<Self, SurfaceError> {
        let all = checked(heights, grid)?;
        let ([nx, ny], [dx, dy]) = (grid.points(), grid.spacing());
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let above: Vec<f64> = all.iter().map(|height| height - mean).collect();
        let slope = |axis: usize, spacing: f64| {
            let mut slopes = Vec::new();
            steps(&all, [nx, ny], axis, 1, repeats, |[here, ahead]| slopes.push((ahead - here) / spacing));
            if slopes.is_empty() { None } else { Density::of(&slopes) }
        };
        let is_line = grid.is_line();
        let around = |i: usize, n: usize| match (i, repeats) {
            (_, true) => Some([(i + n - 1) % n, (i + 1) % n]),
            (i, false) => (i > 0 && i + 1 < n).then(|| [i - 1, i + 1]),
        };
        let mut curvatures = Vec::new();
        for i in 0..nx {
            let Some([left, right]) = around(i, nx) else { continue };
            for j in 0..ny {
                let here = all[i * ny + j];
                let x = (all[left * ny + j] - 2.0 * here + all[right * ny + j]) / (dx * dx);
                if is_line {
                    curvatures.push(x);
                } else if let Some([below, above]) = around(j, ny) {
                    let y = (all[i * ny + below] - 2.0 * here + all[i * ny + above]) / (dy * dy);
                    curvatures.push(0.5 * (x + y));
                }
            }
        }
        Ok(Self {
            height: Density::of(&above),
            slope_x: slope(0, dx),
            slope_y: if is_line { None } else { slope(1, dy) },
            curvature: if curvatures.is_empty() { None } else { Density::of(&curvatures) },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn shares_add_up_and_far_values_are_outside() {
        let mut values: Vec<f64> = (0..1000).map(|k| f64::from(k) / 999.0).collect();
        let found = Density::of(&values).unwrap();
        let width = found.middles[1] - found.middles[0];
        assert!((found.densities.iter().sum::<f64>() * width - 1.0).abs() < 1e-12 && found.outside == 0.0);
        assert!(found.densities.iter().all(|density| (density - 1.0).abs() < 0.01 + 1e-9));
        assert!((found.deviation - (1.0 / 12.0_f64).sqrt()).abs() < 1e-3);
        let gaussian = found.gaussian();
        let highest = 1.0 / (std::f64::consts::TAU.sqrt() * found.deviation);
        assert!(gaussian.iter().all(|density| *density <= highest) && gaussian[50] > 0.999 * highest);
        values.push(1e3);
        let found = Density::of(&values).unwrap();
        assert!((found.outside - 1.0 / 1001.0).abs() < 1e-12);
        assert_eq!(Density::of(&[0.1; 30]), None);
        assert_eq!(Density::of(&[1.0, f64::from_bits(1.0_f64.to_bits() + 1)]), None);
    }

    #[test]
    fn slopes_and_curvatures_of_a_paraboloid() {
        let grid = Grid::new([20, 30], [10.0, 6.0]).unwrap();
        let (dx, dy) = (0.5, 0.2);
        let heights = Array2::from_shape_fn((20, 30), |(i, j)| {
            1.5 * (i as f64 * dx).powi(2) + 0.5 * (j as f64 * dy).powi(2) + 0.3 * (i * j) as f64
        });
        let found = Distributions::of(&heights, &grid, false).unwrap();
        // (3 + 1)/2 everywhere inside, equal up to rounding, so that there may be no distribution.
        assert!(
            found.curvature.is_none_or(|curvature| (curvature.mean - 2.0).abs() < 1e-12 && curvature.deviation < 1e-12)
        );
        let slope = found.slope_x.unwrap();
        // 3 x at the middle between two points, and 0.3 j/dx.
        assert!((slope.mean - (3.0 * 9.5 * dx + 0.3 * 14.5 / dx)).abs() < 1e-12, "{slope:?}");
        assert!((found.height.unwrap().mean).abs() < 1e-12);
        let line = Grid::line(20, 10.0).unwrap();
        let found = Distributions::of(&heights.slice(ndarray::s![.., ..1]).to_owned(), &line, true).unwrap();
        assert!(
            found.slope_y.is_none() && found.slope_x.unwrap().mean.abs() < 1e-12,
            "a cell that repeats has no slope"
        );
        assert!(
            Distributions::of(&Array2::zeros((4, 4)), &Grid::square(4, 1.0).unwrap(), true).unwrap().slope_x.is_none()
        );
    }
}
