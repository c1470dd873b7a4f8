use std::f64::consts::TAU;

use gfmd_vector::Share;
use num_complex::Complex64;

use crate::{Grid, ShapeError, Transform};

/// Interpolation of a periodic field by the cubic spline through its points, with two continuous derivatives. The error
/// is of fourth order: (2π/n)⁴/720 of the amplitude for a wave of n points.
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
    /// Coefficients of the B-splines.
    factors: Vec<f64>,
}

/// Values of the four B-splines at a point, and their first and second derivatives with respect to the index.
struct Weights {
    /// Index of the first B-spline.
    first: i64,
    values: [f64; 4],
    slopes: [f64; 4],
    curvatures: [f64; 4],
}

impl Spline {
    /// Creates the spline through a field.
    ///
    /// # Errors
    /// Returns an error if the field has a different size than the grid.
    pub fn through(grid: &Grid, field: &[f64]) -> Result<Self, ShapeError> {
        Self::distributed(grid, &grid.whole(), field)
    }

    /// Creates the spline through a field from the rows of each process in a `share`. Each process has the whole
    /// spline, and every process makes the same call.
    ///
    /// # Errors
    /// Returns an error, on all processes, if the field has a different size than the rows.
    pub fn distributed(grid: &Grid, share: &Share, field: &[f64]) -> Result<Self, ShapeError> {
        let transform = Transform::distributed(*grid, share);
        let mut ws = transform.workspace();
        let [_, positions] = grid.spectrum_shape();
        let lanes = transform.lanes();
        let mut spectrum = vec![Complex64::ZERO; lanes.len() * positions];
        transform.forward(field, &mut spectrum, &mut ws)?;
        let points = grid.points();
        // A B-spline has the values 1/6, 2/3 and 1/6 at the points.
        let of_axis = |number: i64, points: usize| match points {
            1 => 1.0,
            n => (2.0 + (TAU * number as f64 / n as f64).cos()) / 3.0,
        };
        let modes = lanes.flat_map(|lane| (0..positions).map(move |position| grid.mode(lane, position)));
        for (mode, value) in modes.zip(&mut spectrum) {
            *value /= [0, 1].map(|axis| of_axis(mode.number[axis], points[axis])).iter().product::<f64>();
        }
        let mut factors = vec![0.0; field.len()];
        transform.inverse(&spectrum, &mut factors, &mut ws)?;
        let factors = if share.is_whole() { factors } else { share.gather(&factors, share.columns()) };
        Ok(Self { points, spacing: grid.spacing(), factors })
    }

    /// Returns the value at an `offset` (length) from the point `[i, j]`, and its derivatives with respect to x and y.
    /// An axis with one point has no offset.
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

    /// Returns the second derivatives at an `offset` (length) from the point `[i, j]`: xx, yy and xy.
    pub fn curvatures_near(&self, point: [usize; 2], offset: [f64; 2]) -> [f64; 3] {
        let [x, y] = [0, 1].map(|axis| self.weights(axis, point[axis], offset[axis]));
        let [mut xx, mut yy, mut xy] = [0.0; 3];
        for a in 0..4 {
            let row = self.place(0, x.first, a) * self.points[1];
            for b in 0..4 {
                let factor = self.factors[row + self.place(1, y.first, b)];
                xx += x.curvatures[a] * y.values[b] * factor;
                yy += x.values[a] * y.curvatures[b] * factor;
                xy += x.slopes[a] * y.slopes[b] * factor;
            }
        }
        let [dx, dy] = self.spacing;
        [xx / (dx * dx), yy / (dy * dy), xy / (dx * dy)]
    }

    fn weights(&self, axis: usize, point: usize, offset: f64) -> Weights {
        if self.points[axis] == 1 {
            return Weights { first: 0, values: [1.0, 0.0, 0.0, 0.0], slopes: [0.0; 4], curvatures: [0.0; 4] };
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
            curvatures: [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t],
        }
    }

    /// Returns the index along an axis of B-spline `number` after `first`.
    fn place(&self, axis: usize, first: i64, number: usize) -> usize {
        (first + number as i64).rem_euclid(self.points[axis] as i64) as usize
    }
}
