use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::{Grid, ShapeError, Transform};

/// A periodic field between its points: the cubic spline through them, with two continuous derivatives. Between the points
/// of a wave of n points its error is that of the fourth order, (2π/n)⁴/720 of the amplitude.
///
/// ```
/// use gfmd_field::{Grid, Spline};
///
/// let wave = |x: f64| (std::f64::consts::TAU * x / 3.0).sin();
/// let field: Vec<f64> = (0..64).map(|i| wave(3.0 * f64::from(i) / 64.0)).collect();
/// let spline = Spline::through(&Grid::line(64, 3.0)?, &field)?;
/// let (value, [slope, _]) = spline.near([63, 0], [0.1, 0.0]);
/// let x = 3.0 * 63.0 / 64.0 + 0.1;
/// assert!((value - wave(x)).abs() < 2e-7 && (slope - wave(x + 0.75) * std::f64::consts::TAU / 3.0).abs() < 2e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Spline {
    points: [usize; 2],
    spacing: [f64; 2],
    /// The factors of the B-splines.
    factors: Vec<f64>,
}

/// The values of the four B-splines at a point, and their derivatives by the index.
struct Weights {
    /// The index of the first.
    first: i64,
    values: [f64; 4],
    slopes: [f64; 4],
}

impl Spline {
    /// The spline through a field.
    ///
    /// # Errors
    /// A field of another size than the grid.
    pub fn through(grid: &Grid, field: &[f64]) -> Result<Self, ShapeError> {
        let transform = Transform::new(*grid);
        let mut ws = transform.workspace();
        let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
        transform.forward(field, &mut spectrum, &mut ws)?;
        let points = grid.points();
        // A B-spline has the values 1/6, 2/3 and 1/6 at the points.
        let of_axis = |number: i64, points: usize| match points {
            1 => 1.0,
            n => (2.0 + (TAU * number as f64 / n as f64).cos()) / 3.0,
        };
        for (mode, value) in grid.modes().zip(&mut spectrum) {
            *value /= [0, 1].map(|axis| of_axis(mode.number[axis], points[axis])).iter().product::<f64>();
        }
        let mut factors = vec![0.0; grid.len()];
        transform.inverse(&spectrum, &mut factors, &mut ws)?;
        Ok(Self { points, spacing: grid.spacing(), factors })
    }

    /// The value at the `offset` (length) from the point `[i, j]`, and its derivatives by x and y. An axis with one point has
    /// no offset.
    pub fn near(&self, point: [usize; 2], offset: [f64; 2]) -> (f64, [f64; 2]) {
        let [x, y] = [0, 1].map(|axis| self.weights(axis, point[axis], offset[axis]));
        let (mut value, mut slopes) = (0.0, [0.0; 2]);
        for (a, (along_x, slope_x)) in x.values.iter().zip(&x.slopes).enumerate() {
            let row = self.place(0, x.first, a) * self.points[1];
            let (mut sum, mut slope) = (0.0, 0.0);
            for (b, (along_y, slope_y)) in y.values.iter().zip(&y.slopes).enumerate() {
                let factor = self.factors[row + self.place(1, y.first, b)];
                sum += along_y * factor;
                slope += slope_y * factor;
            }
            value += along_x * sum;
            slopes[0] += slope_x * sum;
            slopes[1] += along_x * slope;
        }
        (value, [slopes[0] / self.spacing[0], slopes[1] / self.spacing[1]])
    }

    fn weights(&self, axis: usize, point: usize, offset: f64) -> Weights {
        if self.points[axis] == 1 {
            return Weights { first: 0, values: [1.0, 0.0, 0.0, 0.0], slopes: [0.0; 4] };
        }
        let steps = offset / self.spacing[axis];
        let whole = steps.floor();
        let t = steps - whole;
        let s = 1.0 - t;
        Weights {
            first: point as i64 + whole as i64 - 1,
            values: [s * s * s, 4.0 - 3.0 * t * t * (1.0 + s), 4.0 - 3.0 * s * s * (1.0 + t), t * t * t]
                .map(|sixths| sixths / 6.0),
            slopes: [-s * s, -t * (4.0 - 3.0 * t), s * (4.0 - 3.0 * s), t * t].map(|halves| halves / 2.0),
        }
    }

    /// The index along an axis of the B-spline `number` after the `first`.
    fn place(&self, axis: usize, first: i64, number: usize) -> usize {
        (first + number as i64).rem_euclid(self.points[axis] as i64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spline_goes_through_the_points_and_its_slopes_are_those_of_its_values() {
        for points in [[7, 1], [8, 6], [5, 9]] {
            let grid = Grid::new(points, [2.0, 3.0]).unwrap();
            let field: Vec<f64> = (0..grid.len()).map(|i| (i as f64 * 0.618_034).fract()).collect();
            let spline = Spline::through(&grid, &field).unwrap();
            for (index, value) in field.iter().enumerate() {
                let point = [index / points[1], index % points[1]];
                let (found, _) = spline.near(point, [0.0; 2]);
                assert!((found - value).abs() < 1e-14, "{points:?} {point:?}: {found} {value}");
                let offset = [0.3 - 0.4 * (index as f64).sin(), if points[1] == 1 { 0.0 } else { 7.3 }];
                let (_, slopes) = spline.near(point, offset);
                for axis in (0..2).filter(|axis| points[*axis] > 1) {
                    let beside = |step: f64| {
                        let mut offset = offset;
                        offset[axis] += step;
                        spline.near(point, offset).0
                    };
                    let slope = (beside(1e-5) - beside(-1e-5)) / 2e-5;
                    assert!((slopes[axis] - slope).abs() < 1e-8, "{points:?} {point:?}: {slopes:?} {slope}");
                }
            }
        }
    }

    #[test]
    fn its_error_is_of_the_fourth_order() {
        let error = |n: usize| {
            let grid = Grid::square(n, 1.0).unwrap();
            let wave = |x: f64, y: f64| (TAU * x).sin() * (TAU * y + 0.3).cos();
            let at = |i: usize| i as f64 / n as f64;
            let field: Vec<f64> = (0..n * n).map(|i| wave(at(i / n), at(i % n))).collect();
            let spline = Spline::through(&grid, &field).unwrap();
            let offset = [0.5 / n as f64, -1.4 / n as f64];
            let errors = (0..n * n).map(|i| {
                let (value, _) = spline.near([i / n, i % n], offset);
                (value - wave(at(i / n) + offset[0], at(i % n) + offset[1])).abs()
            });
            errors.fold(0.0, f64::max)
        };
        let [coarse, fine] = [16, 32].map(error);
        assert!((coarse / fine).log2() > 3.8, "{coarse:e} {fine:e}");
    }

    #[test]
    fn a_field_of_another_size_is_refused() {
        assert!(Spline::through(&Grid::square(4, 1.0).unwrap(), &[0.0; 15]).is_err());
    }
}
