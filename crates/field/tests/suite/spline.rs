//! Splines through fields.

use std::f64::consts::TAU;

use gfmd_field::{Grid, Spline};

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
                let beside = |step: f64| {
                    let mut offset = offset;
                    offset[axis] += step;
                    spline.near(point, offset).1
                };
                let [above, below] = [1e-5, -1e-5].map(beside);
                let [xx, yy, xy] = spline.curvatures_near(point, offset);
                let curvatures = if axis == 0 { [xx, xy] } else { [xy, yy] };
                for (curvature, (above, below)) in curvatures.into_iter().zip(above.into_iter().zip(below)) {
                    let slope = (above - below) / 2e-5;
                    assert!((curvature - slope).abs() < 1e-7, "{points:?} {point:?}: {curvature} {slope}");
                }
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
