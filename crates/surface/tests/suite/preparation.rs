//! Removal of trends, and periodic edges.

use approx::assert_relative_eq;
use gfmd_field::Grid;
use gfmd_surface::{Periodisation, SelfAffine, Statistics, SurfaceError, Trend, periodise, remove, window};
use ndarray::Array2;
use proptest::prelude::*;

const TRENDS: [Trend; 4] = [Trend::Mean, Trend::Plane, Trend::Slope, Trend::Quadratic];

fn self_affine(hurst: f64, longest: f64, shortest: f64, rms_gradient: f64) -> SelfAffine {
    SelfAffine {
        hurst,
        longest_wavelength: longest,
        shortest_wavelength: shortest,
        ..SelfAffine::with_rms_gradient(rms_gradient)
    }
}

/// Returns a rough scan that is not periodic: part of a larger surface.
fn scan(points: [usize; 2]) -> (Array2<f64>, Grid) {
    let whole = Grid::new([64, 96], [2.0, 3.0]).unwrap();
    let heights = self_affine(0.7, 3.0, 0.1, 0.2).heights(&whole, 5).unwrap();
    let [nx, ny] = points;
    let grid = Grid::new(points, [nx as f64 / 32.0, ny as f64 / 32.0]).unwrap();
    (heights.slice(ndarray::s![..nx, ..ny]).to_owned(), grid)
}

fn rms(heights: &Array2<f64>) -> f64 {
    let mean = heights.mean().unwrap();
    (heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / heights.len() as f64).sqrt()
}

proptest! {
    #[test]
    fn what_was_added_is_what_is_removed(
        c in prop::array::uniform6(-10.0..10.0_f64), points in [3_usize..30, 3_usize..30], line: bool,
    ) {
        let [nx, ny] = if line { [points[0], 1] } else { points };
        let (scan, _) = scan([nx, ny]);
        for (trend, terms) in TRENDS.into_iter().zip([1, 3, 3, 6]) {
            let polynomial = |(i, j): (usize, usize)| {
                let (x, y) = (i as f64 / 10.0, j as f64 / 10.0);
                [1.0, x, y, x * x, x * y, y * y].iter().zip(c).take(terms).map(|(term, c)| c * term).sum::<f64>()
            };
            let without = remove(&scan, trend).unwrap();
            let again = remove(&(&scan + &Array2::from_shape_fn((nx, ny), polynomial)), trend).unwrap();
            let worst = without.iter().zip(&again).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            prop_assert!(worst < 1e-11, "{trend:?}: {worst}");
        }
    }
}

#[test]
fn each_trend_makes_least_what_it_says() {
    let (scan, grid) = scan([40, 30]);
    let sizes = TRENDS.map(|trend| rms(&remove(&scan, trend).unwrap()));
    assert!(sizes[3] < sizes[1], "{sizes:?}");
    assert!(sizes[1] < sizes[2], "{sizes:?}");
    assert!(sizes[1] < sizes[0], "{sizes:?}");
    assert_relative_eq!(sizes[0], rms(&scan), max_relative = 1e-12);
    // A small additional tilt in any direction increases the rms height (plane) or the rms gradient (slope).
    let tilted = |heights: &Array2<f64>, [x, y]: [f64; 2]| {
        Array2::from_shape_fn(heights.dim(), |(i, j)| heights[[i, j]] + x * i as f64 + y * j as f64)
    };
    let (plane, slope) = (remove(&scan, Trend::Plane).unwrap(), remove(&scan, Trend::Slope).unwrap());
    let gradient = |heights: &Array2<f64>| {
        let inner = heights.slice(ndarray::s![..39, ..29]);
        let (x, y) = (&heights.slice(ndarray::s![1.., ..29]) - &inner, &heights.slice(ndarray::s![..39, 1..]) - &inner);
        x.mapv(|s| s * s).sum() + y.mapv(|s| s * s).sum()
    };
    for tilt in [[1e-4, 0.0], [-1e-4, 0.0], [0.0, 1e-4], [0.0, -1e-4]] {
        assert!(rms(&tilted(&plane, tilt)) > rms(&plane));
        assert!(gradient(&tilted(&slope, tilt)) > gradient(&slope));
    }
    assert!(Statistics::of(&slope, &grid).unwrap().rms_gradient_inside > 0.1);
}

#[test]
fn a_mirrored_scan_is_periodic_and_keeps_its_heights() {
    for points in [[40, 30], [33, 1]] {
        let (mut scan, grid) = scan(points);
        scan.indexed_iter_mut().for_each(|((i, j), h)| *h += 0.2 * i as f64 - 0.1 * j as f64);
        let (mirrored, twice) = periodise(&scan, &grid, Periodisation::Mirror).unwrap();
        assert_eq!(twice.points(), if points[1] == 1 { [66, 1] } else { [80, 60] });
        assert_eq!(twice.spacing(), grid.spacing());
        let (before, after) = (Statistics::of(&scan, &grid).unwrap(), Statistics::of(&mirrored, &twice).unwrap());
        assert_eq!([before.lowest, before.highest], [after.lowest, after.highest]);
        assert_relative_eq!(before.mean, after.mean, max_relative = 1e-12);
        assert_relative_eq!(before.moments.rms_height(), after.moments.rms_height(), max_relative = 1e-12);
        assert_eq!(after.seam.across, [0.0, 0.0]);
        assert!(before.seam.ratio()[0].unwrap() > 5.0);
        // The images share their steps; the seams add steps of zero: 2(n − 1) of 2n steps count.
        if points[1] == 1 {
            let expected = before.rms_gradient_inside * (32.0_f64 / 33.0).sqrt();
            assert_relative_eq!(after.rms_gradient_forward, expected, max_relative = 1e-12);
        }
    }
}

#[test]
fn a_window_closes_the_edges_and_keeps_the_mean_square_of_waves() {
    let grid = Grid::square(128, 1.0).unwrap();
    let waves = self_affine(0.5, 1.0 / 20.0, 1.0 / 40.0, 0.3).heights(&grid, 2).unwrap();
    let windowed = |taper| window(&(&waves + 3.0), taper).unwrap();
    let hann = windowed(1.0);
    let edge = hann.row(0).iter().chain(hann.column(127)).map(|h| h.abs()).fold(0.0, f64::max);
    assert!(edge < 1e-3 * hann.iter().fold(0.0, |most: f64, h| most.max(h.abs())));
    for taper in [0.0, 0.3, 1.0] {
        let square = windowed(taper).mapv(|h| h * h).mean().unwrap();
        assert_relative_eq!(square, waves.mapv(|h| h * h).mean().unwrap(), max_relative = 0.1);
    }
    let none = windowed(0.0);
    assert!(none.iter().zip(&waves).all(|(a, b)| (a - b).abs() < 1e-13));
    let as_is = periodise(&waves, &grid, Periodisation::AsIs).unwrap();
    assert_eq!(as_is, (waves, grid));
}

#[test]
fn a_full_taper_is_the_window_of_hann() {
    let signs = Array2::from_shape_fn((64, 1), |(i, _)| if i % 2 == 0 { 1.0 } else { -1.0 });
    let windowed = window(&signs, 1.0).unwrap();
    for (i, (h, sign)) in windowed.iter().zip(&signs).enumerate() {
        let hann = (std::f64::consts::PI * (i as f64 + 0.5) / 64.0).sin().powi(2) / 0.375_f64.sqrt();
        assert_relative_eq!(*h, sign * hann, max_relative = 1e-12);
    }
}

#[test]
fn unusable_scans_are_refused() {
    let (mut scan, grid) = scan([2, 30]);
    let few = SurfaceError::TooFewPoints { what: "removing a paraboloid", least: 3, found: [2, 30] };
    assert_eq!(remove(&scan, Trend::Quadratic), Err(few));
    assert_eq!(window(&scan, 1.5), Err(SurfaceError::Taper(1.5)));
    scan[[1, 7]] = f64::NAN;
    for trend in TRENDS {
        assert!(matches!(remove(&scan, trend), Err(SurfaceError::NotFinite { count: 1, first: [1, 7], .. })));
    }
    assert!(matches!(periodise(&scan, &grid, Periodisation::Mirror), Err(SurfaceError::NotFinite { .. })));
}
