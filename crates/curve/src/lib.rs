//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! The slopes are those by Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 300 (1984)), as in
//! `scipy.interpolate.PchipInterpolator`: the curve and its slope are continuous. The error is of third order in the
//! spacing, and of second order near an extremum of the points.

use std::fmt;

/// Minimum number of points of a curve.
pub const LEAST: usize = 4;

/// A shape-preserving cubic through points, continued along its tangents beyond the first and last point.
#[derive(Clone, PartialEq)]
pub struct Curve {
    /// In increasing order: left tangent, one piece per interval, right tangent.
    pieces: Vec<Piece>,
}

/// Cubic y = c₀ + c₁ s + c₂ s² + c₃ s³ with s = x − `start`.
#[derive(Clone, Copy, PartialEq)]
struct Piece {
    /// Abscissa where the piece begins; for the left tangent, where it ends.
    start: f64,
    cubic: [f64; 4],
    /// Integral from the first point to `start`.
    before: f64,
}

/// Error in the points of a curve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// Too few points.
    #[error("{found} rows; there must be at least {LEAST}")]
    Few {
        /// Number of points.
        found: usize,
    },
    /// A coordinate that is not finite.
    #[error("row {row} has {found}; it must have finite numbers")]
    Number {
        /// Row, counted from 1.
        row: usize,
        /// Coordinate.
        found: f64,
    },
    /// A point that does not lie to the right of the previous one.
    #[error("row {row} begins with {found}; it must begin with a number above that of row {}, {before}", row - 1)]
    Order {
        /// Row, counted from 1.
        row: usize,
        /// Abscissa.
        found: f64,
        /// Abscissa of the previous point.
        before: f64,
    },
    /// A slope or an integral that overflows.
    #[error("slope or integral up to row {row} is not finite; other units of the columns make it so")]
    Overflow {
        /// Row, counted from 1.
        row: usize,
    },
}

impl Curve {
    /// Creates the curve through the points [x, y].
    ///
    /// # Errors
    /// Returns an error for fewer than four points, a point that is not finite, abscissae that do not increase, or a
    /// slope or integral that is not finite.
    pub fn new(points: &[[f64; 2]]) -> Result<Self, CurveError> {
        if points.len() < LEAST {
            return Err(CurveError::Few { found: points.len() });
        }
        for (row, point) in (1..).zip(points) {
            if let Some(&found) = point.iter().find(|number| !number.is_finite()) {
                return Err(CurveError::Number { row, found });
            }
        }
        for (row, pair) in (2..).zip(points.windows(2)) {
            let [before, found] = [pair[0][0], pair[1][0]];
            if found <= before {
                return Err(CurveError::Order { row, found, before });
            }
        }
        let slopes = slopes(points);
        let [first, last] = [points[0], points[points.len() - 1]];
        let mut pieces = vec![Piece { start: first[0], cubic: [first[1], slopes[0], 0.0, 0.0], before: 0.0 }];
        let mut before = 0.0;
        for (row, (pair, slopes)) in (2..).zip(points.windows(2).zip(slopes.windows(2))) {
            let ([x, y], [end, next]) = (pair[0], pair[1]);
            let width = end - x;
            let secant = (next - y) / width;
            let cubic = [
                y,
                slopes[0],
                (3.0 * secant - 2.0 * slopes[0] - slopes[1]) / width,
                (slopes[0] + slopes[1] - 2.0 * secant) / width / width,
            ];
            let piece = Piece { start: x, cubic, before };
            before = piece.integral(end);
            if !cubic.iter().chain([&before]).all(|number| number.is_finite()) {
                return Err(CurveError::Overflow { row });
            }
            pieces.push(piece);
        }
        pieces.push(Piece { start: last[0], cubic: [last[1], slopes[slopes.len() - 1], 0.0, 0.0], before });
        Ok(Self { pieces })
    }

    /// Returns the abscissae of the first and last point.
    pub fn ends(&self) -> [f64; 2] {
        [self.pieces[0].start, self.pieces[self.pieces.len() - 1].start]
    }

    /// Returns the value and slope at `x`.
    pub fn at(&self, x: f64) -> [f64; 2] {
        let Piece { start, cubic: [y, slope, bend, twist], .. } = *self.piece(x);
        let s = x - start;
        [y + s * (slope + s * (bend + s * twist)), slope + s * (2.0 * bend + 3.0 * s * twist)]
    }

    /// Returns the integral from the first point to `x`.
    pub fn integral(&self, x: f64) -> f64 {
        self.piece(x).integral(x)
    }

    /// Returns the lowest and highest slope between `from` and the last point; +∞ and −∞ if `from` is beyond it.
    pub fn slopes(&self, from: f64) -> [f64; 2] {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let mut take = |slope: f64| range = [range[0].min(slope), range[1].max(slope)];
        for pair in self.pieces[1..].windows(2) {
            let (Piece { start, cubic: [_, slope, bend, twist], .. }, end) = (pair[0], pair[1].start);
            if from > end {
                continue;
            }
            let at = |s: f64| slope + s * (2.0 * bend + 3.0 * s * twist);
            let [low, high] = [start.max(from), end].map(|x| x - start);
            take(at(low));
            take(at(high));
            let vertex = -bend / (3.0 * twist);
            if low < vertex && vertex < high {
                take(at(vertex));
            }
        }
        range
    }

    /// Returns the piece at `x`.
    fn piece(&self, x: f64) -> &Piece {
        let inner = &self.pieces[1..];
        match inner.partition_point(|piece| piece.start <= x) {
            0 => &self.pieces[0],
            after => &inner[after - 1],
        }
    }
}

impl fmt::Debug for Curve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Curve").field("ends", &self.ends()).field("points", &(self.pieces.len() - 1)).finish()
    }
}

impl Piece {
    /// Returns the integral from the first point to `x`.
    fn integral(&self, x: f64) -> f64 {
        let [y, slope, bend, twist] = self.cubic;
        let s = x - self.start;
        self.before + s * (y + s * (slope / 2.0 + s * (bend / 3.0 + s * twist / 4.0)))
    }
}

/// Computes the slopes at the points.
fn slopes(points: &[[f64; 2]]) -> Vec<f64> {
    let widths: Vec<f64> = points.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
    let secants: Vec<f64> =
        points.windows(2).zip(&widths).map(|(pair, width)| (pair[1][1] - pair[0][1]) / width).collect();
    let last = widths.len() - 1;
    let mut slopes = vec![edge([widths[0], widths[1]], [secants[0], secants[1]])];
    for (width, secant) in widths.windows(2).zip(secants.windows(2)) {
        // Weighted harmonic mean; zero at an extremum.
        let is_monotone = secant.iter().all(|s| *s > 0.0) || secant.iter().all(|s| *s < 0.0);
        slopes.push(if is_monotone {
            let weights = [2.0 * width[1] + width[0], width[1] + 2.0 * width[0]];
            (weights[0] + weights[1]) / (weights[0] / secant[0] + weights[1] / secant[1])
        } else {
            0.0
        });
    }
    slopes.push(edge([widths[last], widths[last - 1]], [secants[last], secants[last - 1]]));
    slopes
}

/// Computes the slope at the first or last point from the parabola through three points, limited to between zero and
/// three secants.
fn edge([near, far]: [f64; 2], [secant, next]: [f64; 2]) -> f64 {
    let slope = ((2.0 * near + far) * secant - near * next) / (near + far);
    if slope * secant.signum() <= 0.0 || secant == 0.0 {
        0.0
    } else if secant.signum() != next.signum() && slope.abs() > 3.0 * secant.abs() {
        3.0 * secant
    } else {
        slope
    }
}
