//! Spline of a profile with free ends.

use std::f64::consts::PI;

use ndarray::Array2;

/// Returns the spline w of ISO 16610-22 for a profile z: (W + β α⁴ D₂ᵀD₂ + (1−β) α² D₁ᵀD₁) w = W z, with W = 0 at
/// undefined points and 1 at others, first and second differences D₁ and D₂, and α = 1/(2 sin(π dx/L)).
pub(super) fn open(heights: &Array2<f64>, spacing: f64, index: f64, tension: f64) -> Array2<f64> {
    let points = heights.len();
    let square = 0.25 / (PI * spacing / index).sin().powi(2);
    let (bend, stretch) = (tension * square * square, (1.0 - tension) * square);
    // Diagonals 0, 1 and 2 of the symmetric matrix.
    let mut rows: Vec<[f64; 3]> = heights.iter().map(|z| [if z.is_nan() { 0.0 } else { 1.0 }, 0.0, 0.0]).collect();
    let mut add = |first: usize, weights: &[f64], factor: f64| {
        for (a, x) in weights.iter().enumerate() {
            for (b, y) in weights.iter().enumerate().skip(a) {
                rows[first + a][b - a] += factor * x * y;
            }
        }
    };
    (0..points.saturating_sub(1)).for_each(|first| add(first, &[-1.0, 1.0], stretch));
    (0..points.saturating_sub(2)).for_each(|first| add(first, &[1.0, -2.0, 1.0], bend));
    // L D Lᵀ in place: the diagonal holds D, the others L.
    for k in 0..points {
        let [diagonal, next, second] = rows[k];
        let (below, far) = (next / diagonal, second / diagonal);
        if k + 1 < points {
            rows[k + 1][0] -= below * next;
            rows[k + 1][1] -= below * second;
        }
        if k + 2 < points {
            rows[k + 2][0] -= far * second;
        }
        rows[k] = [diagonal, below, far];
    }
    let mut w: Vec<f64> = heights.iter().map(|z| if z.is_nan() { 0.0 } else { *z }).collect();
    for k in 0..points {
        for (step, factor) in [(1, rows[k][1]), (2, rows[k][2])] {
            if k + step < points {
                w[k + step] -= factor * w[k];
            }
        }
    }
    for k in (0..points).rev() {
        let after = |step: usize| if k + step < points { rows[k][step] * w[k + step] } else { 0.0 };
        w[k] = w[k] / rows[k][0] - after(1) - after(2);
    }
    Array2::from_shape_fn(heights.dim(), |(i, j)| w[i.max(j)])
}
