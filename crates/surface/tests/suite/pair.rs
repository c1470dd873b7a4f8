//! Two rough surfaces that face each other.

use std::f64::consts::TAU;

use gfmd_field::Grid;
use gfmd_surface::{SelfAffine, SurfaceError, composite, composite_inside};
use ndarray::{Array2, s};

fn largest(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn rough(grid: &Grid, seed: u64) -> Array2<f64> {
    let spectrum = SelfAffine {
        hurst: 0.8,
        longest_wavelength: 1.0,
        shortest_wavelength: 0.25,
        ..SelfAffine::with_rms_gradient(0.2)
    };
    spectrum.heights(grid, seed).unwrap()
}

#[test]
fn whole_steps_move_the_heights_from_point_to_point() {
    let grid = Grid::new([16, 24], [2.0, 3.0]).unwrap();
    let (first, second) = (rough(&grid, 1), rough(&grid, 2));
    for shift in [[0.0, 0.0], [3.0 * 0.125, -2.0 * 0.125], [-2.0 - 0.125, 9.0]] {
        let found = composite(&first, &second, &grid, shift).unwrap();
        let [i, j] = shift.map(|s: f64| (s / 0.125).round() as isize);
        let at = |k: usize, by: isize, n: usize| (k as isize - by).rem_euclid(n as isize) as usize;
        let expected = Array2::from_shape_fn((16, 24), |(k, l)| first[[k, l]] + second[[at(k, i, 16), at(l, j, 24)]]);
        assert_eq!(found, expected);
    }
    // Decimal lengths are whole steps up to rounding.
    let tenths = Grid::line(10, 1.0).unwrap();
    let ramp = Array2::from_shape_fn((10, 1), |(i, _)| i as f64);
    let found = composite(&Array2::zeros((10, 1)), &ramp, &tenths, [0.1 + 0.2, 0.0]).unwrap();
    assert_eq!(found[[3, 0]], 0.0);
}

#[test]
fn other_shifts_move_the_waves() {
    // A wave below the Nyquist number is known between the points.
    let grid = Grid::new([12, 10], [3.0, 2.0]).unwrap();
    let wave = |x: f64, y: f64| (TAU * (2.0 * x / 3.0 - y / 2.0) + 0.3).cos() + 0.5 * (TAU * 5.0 * x / 3.0).sin();
    let sampled =
        |dx: f64, dy: f64| Array2::from_shape_fn((12, 10), |(i, j)| wave(0.25 * i as f64 - dx, 0.2 * j as f64 - dy));
    let zero = Array2::zeros((12, 10));
    for shift in [[0.1, 0.0], [0.07, -0.33], [-4.21, 0.2]] {
        let found = composite(&zero, &sampled(0.0, 0.0), &grid, shift).unwrap();
        assert!(largest(&found, &sampled(shift[0], shift[1])) < 1e-14, "{shift:?}");
    }
    // The opposite shift restores any heights except their Nyquist waves, and they stay real.
    let odd = Grid::new([9, 15], [1.0, 1.0]).unwrap();
    let heights = Array2::from_shape_fn((9, 15), |(i, j)| ((7 * i + 11 * j * j) % 13) as f64);
    let zero = Array2::zeros((9, 15));
    let there = composite(&zero, &heights, &odd, [0.04, 0.03]).unwrap();
    assert!(largest(&composite(&zero, &there, &odd, [-0.04, -0.03]).unwrap(), &heights) < 1e-13);
    assert!((there.sum() - heights.sum()).abs() < 1e-11);
}

#[test]
fn the_wave_at_the_nyquist_number_is_the_mean_of_both_directions() {
    let grid = Grid::new([4, 6], [4.0, 6.0]).unwrap();
    let comb = Array2::from_shape_fn((4, 6), |(i, j)| if (i + j) % 2 == 0 { 1.0 } else { -1.0 });
    let found = composite(&Array2::zeros((4, 6)), &comb, &grid, [0.25, 0.0]).unwrap();
    assert!(largest(&found, &(&comb * (0.25 * TAU / 2.0).cos())) < 1e-15);
}

#[test]
fn surfaces_that_do_not_repeat_have_the_part_in_common() {
    let grid = Grid::new([16, 24], [2.0, 3.0]).unwrap();
    let (first, second) = (rough(&grid, 1), rough(&grid, 2));
    let (found, part) = composite_inside(&first, &second, &grid, [0.25, -0.375]).unwrap();
    assert_eq!((part.points(), part.lengths()), ([14, 21], [1.75, 2.625]));
    assert_eq!(found, &first.slice(s![2.., ..21]) + &second.slice(s![..14, 3..]));
    assert_eq!(composite_inside(&first, &second, &grid, [0.0, 0.0]).unwrap().0, &first + &second);
}

#[test]
fn shifts_that_make_no_sense_are_refused() {
    let grid = Grid::new([16, 24], [2.0, 3.0]).unwrap();
    let heights = rough(&grid, 1);
    let other = Array2::zeros((16, 23));
    let refused = |second: &Array2<f64>, shift| composite(&heights, second, &grid, shift).unwrap_err();
    assert!(matches!(refused(&other, [0.0, 0.0]), SurfaceError::Shape { found: [16, 23], .. }));
    assert!(matches!(refused(&heights, [f64::NAN, 0.0]), SurfaceError::Shift { .. }));
    let inside = |shift| composite_inside(&heights, &heights, &grid, shift).unwrap_err();
    assert!(matches!(inside([0.1, 0.0]), SurfaceError::PartOfStep { .. }));
    assert!(matches!(inside([0.0, 2.875]), SurfaceError::Apart { .. }));
    let line = Grid::line(8, 1.0).unwrap();
    let profile = Array2::from_shape_fn((8, 1), |(i, _)| i as f64);
    assert!(matches!(composite(&profile, &profile, &line, [0.0, 0.1]).unwrap_err(), SurfaceError::Shift { .. }));
}
