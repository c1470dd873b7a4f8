//! Largest value of a field between its points.

use std::array::from_fn;

use ndarray::ArrayView2;

/// Largest value of a periodic field `[x, y]` between its points: the largest maximum of the quadratics through each
/// high point and its eight neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Largest value of the quadratics, in the unit of the field; the value of a point if its quadratic has no maximum.
    pub value: f64,
    /// Sharpness of the peak on this grid: the larger of both second differences at its point, positive for a maximum,
    /// divided by its value.
    pub sharpness: f64,
    /// Skewness of the peak on this grid: the larger of both third differences around its point, divided by its value.
    pub skewness: f64,
}

impl Peak {
    /// Finds the peak of `field`; `None` without points.
    pub fn of(field: ArrayView2<f64>) -> Option<Self> {
        let highest = field.iter().copied().max_by(f64::total_cmp)?;
        let rises = maxima(field, 0.5 * highest).map(|([i, j], around)| {
            let value = field[[i, j]];
            let [xx, yy] = second_differences(&around);
            let skewness = third_differences(field, [i, j]).into_iter().fold(0.0, f64::max) / value;
            Self { value: value + rise(&around), sharpness: -xx.min(yy) / value, skewness }
        });
        let flat = Self { value: highest, sharpness: 0.0, skewness: 0.0 };
        Some(rises.fold(flat, |most, peak| if peak.value >= most.value { peak } else { most }))
    }
}

/// Returns the local maxima of a periodic field with at least this value, with their 3 × 3 values.
fn maxima(field: ArrayView2<f64>, least: f64) -> impl Iterator<Item = ([usize; 2], [[f64; 3]; 3])> {
    let (nx, ny) = field.dim();
    let has_one = move |i: &usize| field.row(*i).iter().any(|value| *value >= least);
    let places = (0..nx).filter(has_one).flat_map(move |i| (0..ny).map(move |j| [i, j]));
    places.filter(move |place| field[*place] >= least).filter_map(move |[i, j]| {
        let around: [[f64; 3]; 3] = from_fn(|di| from_fn(|dj| field[[(i + nx + di - 1) % nx, (j + ny + dj - 1) % ny]]));
        let is_highest = around.iter().flatten().all(|value| *value <= around[1][1]);
        is_highest.then_some(([i, j], around))
    })
}

/// Points on each side used to interpolate a field without waves shorter than four points: the error of a sinc under a
/// Gaussian is e^(−π REACH/4), 5e-8 of the field.
const REACH: usize = 21;

/// Refinement of the grid around a high point.
const ZOOM: usize = 8;

/// Number of high points that are searched.
const CANDIDATES: usize = 8;

/// Returns the largest value between the points of a periodic field `[x, y]` without waves shorter than four points, in
/// the unit of the field: the quadratic through the largest point of an eight times finer grid around the highest
/// maxima, to 3e-5 of the amplitude of the shortest waves. NaN without points.
pub fn top(field: ArrayView2<f64>) -> f64 {
    let highest = field.fold(f64::NEG_INFINITY, |most, value| most.max(*value));
    if !highest.is_finite() {
        return f64::NAN;
    }
    // With four points per wave, a wave exceeds its points by at most 1/cos(π/4) along each axis.
    let mean = field.sum() / field.len() as f64;
    let high = maxima(field, highest - 0.5 * (highest - mean));
    let mut maxima: Vec<(f64, [usize; 2])> =
        high.map(|(place, around)| (field[place] + rise(&around), place)).collect();
    maxima.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    maxima.truncate(CANDIDATES);
    let weights = weights();
    maxima.iter().fold(highest, |top, (_, place)| top.max(zoomed(&field, *place, &weights)))
}

/// Returns the largest value between the points of a patch, which does not repeat, in the unit of the field: the
/// largest maximum of the quadratics through the inner points and their neighbours, or the largest value of a point.
/// NaN without points.
pub fn top_inside(field: ArrayView2<f64>) -> f64 {
    let highest = field.fold(f64::NEG_INFINITY, |most, value| most.max(*value));
    if !highest.is_finite() {
        return f64::NAN;
    }
    let (nx, ny) = field.dim();
    let is_inner = |at: usize, points: usize| points == 1 || at > 0 && at + 1 < points;
    let inner = maxima(field, f64::NEG_INFINITY).filter(|([i, j], _)| is_inner(*i, nx) && is_inner(*j, ny));
    inner.fold(highest, |top, ([i, j], around)| top.max(field[[i, j]] + rise(&around)))
}

/// Points of the finer grid along each side around a point.
const SIDE: usize = 2 * ZOOM + 1;

/// Weights of the points within reach, for each point of the finer grid along an axis.
type Weights = [[f64; 2 * REACH + 1]; SIDE];

fn weights() -> Weights {
    from_fn(|fine| {
        from_fn(|point| {
            let distance = point as f64 - REACH as f64 - (fine as f64 / ZOOM as f64 - 1.0);
            let angle = std::f64::consts::PI * distance;
            let sinc = if angle.abs() < 1e-12 { 1.0 } else { angle.sin() / angle };
            sinc * (-0.25 * angle * distance / REACH as f64).exp()
        })
    })
}

/// Returns the largest value around a point by interpolation.
fn zoomed(field: &ArrayView2<f64>, [i, j]: [usize; 2], weights: &Weights) -> f64 {
    let (nx, ny) = field.dim();
    let at = |middle: usize, point: usize, n: usize| (middle + point + REACH * n - REACH) % n;
    let along_y: Vec<[f64; SIDE]> = (0..=2 * REACH)
        .map(|dx| {
            let row = field.row(at(i, dx, nx));
            let rises: [f64; 2 * REACH + 1] = from_fn(|dy| row[at(j, dy, ny)] - field[[i, j]]);
            from_fn(|fine| weights[fine].iter().zip(&rises).map(|(weight, rise)| weight * rise).sum())
        })
        .collect();
    let values: [[f64; SIDE]; SIDE] =
        from_fn(|x| from_fn(|y| along_y.iter().zip(&weights[x]).map(|(row, weight)| weight * row[y]).sum()));
    let inside = (1..SIDE - 1).flat_map(|x| (1..SIDE - 1).map(move |y| [x, y]));
    let highest = inside.max_by(|[x, y], [u, v]| values[*x][*y].total_cmp(&values[*u][*v]));
    highest.map_or(f64::NAN, |[x, y]| {
        let around = from_fn(|dx| from_fn(|dy| values[x + dx - 1][y + dy - 1]));
        field[[i, j]] + around[1][1] + rise(&around)
    })
}

/// Returns the second differences of 3 × 3 points along x and y.
fn second_differences(at: &[[f64; 3]; 3]) -> [f64; 2] {
    let middle = at[1][1];
    [at[2][1] - 2.0 * middle + at[0][1], at[1][2] - 2.0 * middle + at[1][0]]
}

/// Returns the magnitudes of the third differences of a periodic field along x and y, from two points on each side.
fn third_differences(field: ArrayView2<f64>, [i, j]: [usize; 2]) -> [f64; 2] {
    let (nx, ny) = field.dim();
    let difference = |at: &dyn Fn(usize) -> f64| (0.5 * (at(4) - at(0)) - (at(3) - at(1))).abs();
    [difference(&|k| field[[(i + 2 * nx + k - 2) % nx, j]]), difference(&|k| field[[i, (j + 2 * ny + k - 2) % ny]])]
}

/// Returns the rise of the quadratic through 3 × 3 points above the centre, zero if it has no maximum.
fn rise(at: &[[f64; 3]; 3]) -> f64 {
    let slope = [0.5 * (at[2][1] - at[0][1]), 0.5 * (at[1][2] - at[1][0])];
    let [xx, yy] = second_differences(at);
    let xy = 0.25 * (at[2][2] - at[2][0] - at[0][2] + at[0][0]);
    let determinant = xx * yy - xy * xy;
    if at.iter().all(|row| row[0] == row[1] && row[1] == row[2]) {
        // A profile.
        return if xx < 0.0 { -0.5 * slope[0] * slope[0] / xx } else { 0.0 };
    }
    let has_maximum = xx < 0.0 && determinant > 0.0;
    // Minus half the slope times the step to the maximum.
    let along = yy * slope[0] * slope[0] - 2.0 * xy * slope[0] * slope[1] + xx * slope[1] * slope[1];
    if has_maximum { -0.5 * along / determinant } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn the_maximum_of_a_quadratic_is_exact_and_that_of_a_wave_much_nearer_than_its_points() {
        let quadratic = |x: f64, y: f64| 3.0 - 0.4 * x * x + 0.1 * x * y - 0.3 * y * y;
        let field = Array2::from_shape_fn((9, 8), |(i, j)| quadratic(i as f64 - 4.3, j as f64 - 3.8));
        let peak = Peak::of(field.view()).unwrap();
        assert!((peak.value - 3.0).abs() < 1e-14, "{peak:?}");
        let highest = field.iter().copied().fold(0.0, f64::max);
        assert!((peak.sharpness * highest - 0.8).abs() < 1e-13 && peak.skewness.abs() < 1e-13, "{peak:?}");
        let cubic = Array2::from_shape_fn((9, 8), |(i, j)| {
            let [x, y] = [i as f64 - 4.0, j as f64 - 4.0];
            3.0 - 0.4 * x * x + 0.02 * x * x * x - 0.3 * y * y - 0.01 * y * y * y
        });
        // The third difference of x³ is 6.
        let peak = Peak::of(cubic.view()).unwrap();
        assert!((3.0 * peak.skewness - 0.12).abs() < 1e-13 && (3.0 * peak.sharpness - 0.8).abs() < 1e-13, "{peak:?}");
        let wave = |k: usize, n: usize, at: f64| (std::f64::consts::TAU * (k as f64 - at) / n as f64).cos();
        for at in [0.0, 0.2, 0.5] {
            let field = Array2::from_shape_fn((16, 12), |(i, j)| 2.0 + wave(i, 16, at) + wave(j, 12, 0.4));
            let (most, found) = (field.iter().copied().fold(0.0, f64::max), Peak::of(field.view()).unwrap());
            assert!((found.value - 4.0).abs() < 0.06 * (4.0 - most), "{at}: {most} {found:?}");
        }
        assert_eq!(Peak::of(Array2::<f64>::zeros((0, 3)).view()), None);
    }

    #[test]
    fn the_top_of_a_patch_and_of_a_profile_lies_between_their_points() {
        let sphere = |i: usize, at: f64| -0.3 * (i as f64 - at).powi(2);
        let field = Array2::from_shape_fn((9, 8), |(i, j)| 2.0 + sphere(i, 4.3) + sphere(j, 3.8));
        assert!((top_inside(field.view()) - 2.0).abs() < 1e-14);
        // The highest point at the rim is the top, though the other rim is lower.
        let tilted = Array2::from_shape_fn((9, 8), |(i, j)| i as f64 + sphere(j, 0.2));
        assert_eq!(top_inside(tilted.view()), tilted[[8, 0]]);
        assert!(top_inside(Array2::<f64>::zeros((0, 3)).view()).is_nan());
        let profile = Array2::from_shape_fn((9, 1), |(i, _)| 2.0 + sphere(i, 4.3));
        assert!((top_inside(profile.view()) - 2.0).abs() < 1e-14);
        let wave = Array2::from_shape_fn((64, 1), |(i, _)| (std::f64::consts::TAU * (i as f64 - 20.3) / 8.0).cos());
        // The bound that the function states.
        assert!((top(wave.view()) - 1.0).abs() < 3e-5, "{}", top(wave.view()));
    }

    #[test]
    fn a_peak_between_points_exceeds_a_lower_one_at_a_point() {
        let peak = |x: f64, y: f64, [u, v]: [f64; 2], value: f64| {
            (value - 0.4 * (x - u).powi(2) - 0.4 * (y - v).powi(2)).max(0.0)
        };
        let field = Array2::from_shape_fn((24, 12), |(i, j)| {
            let [x, y] = [i as f64, j as f64];
            peak(x, y, [6.5, 5.5], 3.1).max(peak(x, y, [17.0, 5.0], 3.0))
        });
        assert_eq!(field.fold(0.0, |most: f64, value| most.max(*value)), 3.0);
        let found = Peak::of(field.view()).unwrap();
        assert!((found.value - 3.1).abs() < 1e-14, "{found:?}");
        assert!((found.sharpness - 0.8 / 2.9).abs() < 1e-13, "{found:?}");
        assert_eq!(Peak::of(Array2::zeros((4, 4)).view()).unwrap().value, 0.0);
        assert!(Peak::of(Array2::from_elem((4, 4), f64::NAN).view()).unwrap().value.is_nan());
    }

    #[test]
    fn the_top_of_waves_four_points_long_is_found_between_the_points() {
        let tau = std::f64::consts::TAU;
        for (n, m, phase) in [(64, 64, 0.3), (64, 48, 0.5), (4, 8, 0.21), (128, 16, 0.77)] {
            // One wave of four points along each axis and a long one, with their maxima at the same place.
            let place = [phase * n as f64 / 5.0, 1.3 * phase * m as f64 / 5.0];
            let value = |x: f64, y: f64| {
                let [x, y] = [x - place[0], y - place[1]];
                (0.25 * tau * x).cos() + (0.25 * tau * y).cos() + 0.5 * (tau * (x / n as f64 + y / m as f64)).cos()
            };
            let field = Array2::from_shape_fn((n, m), |(i, j)| value(i as f64, j as f64));
            let most = field.iter().copied().fold(0.0, f64::max);
            let found = top(field.view());
            assert!((found - 2.5).abs() < 3e-5 * 2.5, "{n} {m}: {found}, points {most}");
            assert!(most < 2.475, "{most}");
        }
        assert_eq!(top(Array2::from_elem((5, 4), 0.3).view()), 0.3);
        assert!(top(Array2::<f64>::zeros((0, 3)).view()).is_nan());
        assert!(top(Array2::from_elem((5, 4), f64::NAN).view()).is_nan());
    }
}
