//! Tests of `gfmd-curve`.

use approx::assert_relative_eq;
use gfmd_curve::{Curve, CurveError};

/// Reference: values and slopes of scipy.interpolate.PchipInterpolator.
#[test]
fn values_and_slopes_are_those_of_scipy() {
    let points = [[0.0, 1.0], [0.5, 0.9], [1.5, -0.4], [2.0, -0.6], [3.5, -0.6], [4.0, 0.3], [5.0, 0.0]];
    let curve = Curve::new(&points).unwrap();
    for (x, value, slope) in SCIPY {
        let [y, dy] = curve.at(x);
        assert_relative_eq!(y, value, epsilon = 1e-13, max_relative = 1e-13);
        assert_relative_eq!(dy, slope, epsilon = 1e-12, max_relative = 1e-12);
    }
    assert_relative_eq!(curve.integral(5.0), SCIPY_INTEGRAL, max_relative = 1e-13);
    assert_eq!(curve.ends(), [0.0, 5.0]);
}

const SCIPY: [(f64, f64, f64); 10] = [
    (0.0, 1.0, 0.0),
    (0.2, 0.980186301369863, -0.18542465753424653),
    (0.5, 0.9, -0.32054794520547936),
    (0.9, 0.45170776255707756, -1.6486453576864533),
    (1.7, -0.512, -0.5066666666666666),
    (2.6, -0.6, 0.0),
    (3.8, -0.016800000000000426, 2.5919999999999996),
    (4.0, 0.3, 0.0),
    (4.3, 0.2919, -0.08099999999999992),
    (5.0, 0.0, -0.8999999999999999),
];
const SCIPY_INTEGRAL: f64 = -0.2589231354642313;

#[test]
fn errors_fall_with_the_third_power_of_the_spacing_and_those_of_integrals_with_the_fourth() {
    let of = |n: u32| -> [f64; 3] {
        let points: Vec<[f64; 2]> =
            (0..=n).map(|k| 2.0 * f64::from(k) / f64::from(n)).map(|x| [x, (-x).exp()]).collect();
        let curve = Curve::new(&points).unwrap();
        let mut worst = [0.0_f64; 3];
        for k in 0..=1000 {
            let x = 1.0 + 0.5 * f64::from(k) / 1000.0;
            let [y, dy] = curve.at(x);
            let integral = curve.integral(x) - curve.integral(1.0) - ((-1.0_f64).exp() - (-x).exp());
            for (worst, error) in worst.iter_mut().zip([y - (-x).exp(), dy + (-x).exp(), integral]) {
                *worst = worst.max(error.abs());
            }
        }
        worst
    };
    let (coarse, fine) = (of(32), of(64));
    for (k, order) in [3.0, 2.0, 3.0].into_iter().enumerate() {
        let found = (coarse[k] / fine[k]).log2();
        assert!(found > order - 0.2, "{k}: {found}, {coarse:?} {fine:?}");
    }
}

#[test]
fn curves_keep_the_shape_of_their_points_and_continue_along_tangents() {
    // A jump within one step, and a plateau.
    let curve = Curve::new(&[[0.0, 1.0], [1.0, 1.0], [1.001, 0.0], [2.0, 0.0], [3.0, 0.0]]).unwrap();
    let values: Vec<f64> = (0..=3000).map(|k| curve.at(f64::from(k) / 1000.0)[0]).collect();
    assert!(values.windows(2).all(|pair| pair[1] <= pair[0] + 1e-12) && values.iter().all(|y| (0.0..=1.0).contains(y)));
    let curve = Curve::new(&[[-1.0, -2.0], [0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]).unwrap();
    let [value, slope] = curve.at(-1.0);
    assert_relative_eq!(curve.at(-3.0)[0], value - 2.0 * slope, max_relative = 1e-14);
    assert_eq!(curve.at(-3.0)[1], slope);
    assert_relative_eq!(curve.integral(-3.0), -(2.0 * value - 2.0 * slope), max_relative = 1e-14);
    // The derivative of the integral is the curve, and the integral has no jump at a point.
    for x in [-1.7, -1.0, -0.3, 0.0, 0.4, 1.0, 1.6, 2.0, 2.5] {
        let step = 1e-6;
        let found = (curve.integral(x + step) - curve.integral(x - step)) / (2.0 * step);
        assert_relative_eq!(found, curve.at(x)[0], epsilon = 1e-5, max_relative = 1e-5);
    }
}

#[test]
fn slopes_are_bounded_by_their_range() {
    let points: Vec<[f64; 2]> =
        (0..20).map(|k| 0.3 * f64::from(k)).map(|x| [x, (1.3 * x).sin() * (-0.2 * x).exp()]).collect();
    let curve = Curve::new(&points).unwrap();
    for from in [-1.0, 0.0, 1.01, 3.3, 5.69] {
        let [low, high] = curve.slopes(from);
        let found: Vec<f64> =
            (0..=20_000).map(|k| curve.at(from + (5.7 - from) * f64::from(k) / 20_000.0)[1]).collect();
        let [lowest, highest] =
            [found.iter().copied().fold(f64::INFINITY, f64::min), found.iter().copied().fold(-f64::INFINITY, f64::max)];
        assert!(low <= lowest + 1e-12 && highest <= high + 1e-12, "{from}: {low} {lowest}, {highest} {high}");
        assert!(lowest - low < 1e-3 && high - highest < 1e-3, "{from}: {low} {lowest}, {highest} {high}");
    }
    assert_eq!(curve.slopes(6.0), [f64::INFINITY, f64::NEG_INFINITY]);
}

#[test]
fn unusable_points_are_refused_by_their_row() {
    let of = |points: &[[f64; 2]]| Curve::new(points).unwrap_err();
    let good = [[0.0, 1.0], [1.0, 0.5], [2.0, 0.1], [3.0, 0.0]];
    assert_eq!(of(&good[..3]), CurveError::Few { found: 3 });
    for (row, column, bad) in [(1, 1, f64::INFINITY), (2, 0, f64::NEG_INFINITY)] {
        let mut points = good;
        points[row][column] = bad;
        assert_eq!(of(&points), CurveError::Number { row: row + 1, found: bad });
    }
    let mut points = good;
    points[2][1] = f64::NAN;
    assert!(of(&points).to_string().starts_with("row 3 has NaN"));
    points = good;
    points[2][0] = 0.5;
    assert_eq!(of(&points), CurveError::Order { row: 3, found: 0.5, before: 1.0 });
    let steep = [[0.0, 1.0], [1e-300, -1e300], [2e-300, 1.0], [1.0, 0.0]];
    assert!(matches!(of(&steep), CurveError::Overflow { .. }));
}
