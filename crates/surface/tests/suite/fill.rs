//! Undefined points: trends without them and heights for them.

use gfmd_surface::{Fill, SurfaceError, Trend, fill, remove, remove_from_defined};
use ndarray::Array2;
use proptest::prelude::*;

/// Returns a pseudo-random number in [0, 1) that depends only on the arguments.
fn noise(i: usize, j: usize, seed: u64) -> f64 {
    let mut bits =
        (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (j as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9) ^ seed;
    for _ in 0..3 {
        bits = (bits ^ (bits >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
    }
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

fn rough(points: [usize; 2], seed: u64) -> Array2<f64> {
    Array2::from_shape_fn(points, |(i, j)| noise(i, j, seed))
}

fn with_holes(mut heights: Array2<f64>, hole: impl Fn(usize, usize) -> bool) -> Array2<f64> {
    heights.indexed_iter_mut().filter(|((i, j), _)| hole(*i, *j)).for_each(|(_, h)| *h = f64::NAN);
    heights
}

fn worst(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, |worst, d| if d > worst || d.is_nan() { d } else { worst })
}

/// Computes the harmonic fill by elimination of the full matrix.
fn dense(heights: &Array2<f64>, spacing: [f64; 2]) -> Array2<f64> {
    let (nx, ny) = heights.dim();
    let unknown: Vec<[usize; 2]> =
        heights.indexed_iter().filter(|(_, h)| h.is_nan()).map(|((i, j), _)| [i, j]).collect();
    let n = unknown.len();
    let mut rows = vec![vec![0.0; n + 1]; n];
    for (k, &[i, j]) in unknown.iter().enumerate() {
        let (i, j) = (i as isize, j as isize);
        for (di, dj, step) in [(1, 0, spacing[0]), (-1, 0, spacing[0]), (0, 1, spacing[1]), (0, -1, spacing[1])] {
            let (a, b) = (i + di, j + dj);
            if a < 0 || b < 0 || a >= nx as isize || b >= ny as isize {
                continue;
            }
            let (there, w) = ([a as usize, b as usize], 1.0 / step.powi(2));
            rows[k][k] += w;
            match unknown.iter().position(|&point| point == there) {
                Some(l) => rows[k][l] -= w,
                None => rows[k][n] += w * heights[there],
            }
        }
    }
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs())).unwrap();
        rows.swap(k, pivot);
        for l in 0..n {
            if l != k {
                let factor = rows[l][k] / rows[k][k];
                let pivot = rows[k].clone();
                rows[l].iter_mut().zip(&pivot).for_each(|(value, pivot)| *value -= factor * pivot);
            }
        }
    }
    let mut filled = heights.clone();
    unknown.iter().enumerate().for_each(|(k, &point)| filled[point] = rows[k][n] / rows[k][k]);
    filled
}

proptest! {
    #[test]
    fn harmonic_heights_are_those_of_the_dense_equations(
        points in [1_usize..12, 1_usize..12], share in 0.05..0.95_f64, seed: u64, dy in 0.2..5.0_f64,
    ) {
        let holes = with_holes(rough(points, seed), |i, j| noise(i, j, !seed) < share && [i, j] != [0, 0]);
        let filled = fill(&holes, [1.0, dy], Fill::Harmonic).unwrap();
        prop_assert!(worst(&filled, &dense(&holes, [1.0, dy])) < 1e-10);
    }

    #[test]
    fn nearest_heights_are_those_of_all_distances_with_the_lowest_index_first(
        points in [1_usize..12, 1_usize..12], share in 0.05..0.95_f64, seed: u64, square: bool,
    ) {
        let spacing = [0.5, if square { 0.5 } else { 0.8 }];
        let holes = with_holes(rough(points, seed), |i, j| noise(i, j, !seed) < share && [i, j] != [0, 0]);
        let filled = fill(&holes, spacing, Fill::Nearest).unwrap();
        for ((i, j), found) in filled.indexed_iter() {
            let distance = |a: usize, b: usize| {
                let ratio = spacing[1] / spacing[0];
                (a as f64 - i as f64).powi(2) + ((b as f64 - j as f64) * ratio).powi(2)
            };
            let defined = holes.indexed_iter().filter(|(_, h)| !h.is_nan());
            let (least, expected) = defined.map(|((a, b), h)| (distance(a, b), *h))
                .fold((f64::INFINITY, f64::NAN), |best, next| if next.0 < best.0 { next } else { best });
            // Distances on a square lattice are whole numbers; others may tie up to rounding.
            let near = |a, b| distance(a, b) < least * (1.0 + 1e-12);
            let tied = !square && holes.indexed_iter().any(|((a, b), h)| h == found && near(a, b));
            prop_assert!(*found == expected || tied, "[{i}, {j}]: {found}, {expected}");
        }
    }

    #[test]
    fn trends_of_defined_points_are_found_with_and_without_holes(
        c in prop::array::uniform6(-3.0..3.0_f64), points in [6_usize..20, 6_usize..20], seed: u64,
    ) {
        let (nx, ny) = (points[0], points[1]);
        let terms = |i: usize, j: usize| {
            let (x, y) = (i as f64 / 10.0, j as f64 / 10.0);
            [1.0, x, y, x * x, x * y, y * y]
        };
        for (trend, count) in [(Trend::Mean, 1), (Trend::Plane, 3), (Trend::Slope, 3), (Trend::Quadratic, 6)] {
            let polynomial = Array2::from_shape_fn((nx, ny), |(i, j)| {
                terms(i, j).iter().zip(c).take(count).map(|(term, c)| term * c).sum::<f64>()
            });
            let holes = with_holes(polynomial.clone(), |i, j| noise(i, j, seed) < 0.3);
            let rest = remove_from_defined(&holes, trend).unwrap();
            for (rest, whole) in rest.iter().zip(&holes) {
                prop_assert!(if whole.is_nan() { rest.is_nan() } else { rest.abs() <= 1e-11 }, "{trend:?}: {rest}");
            }
            let whole = remove_from_defined(&polynomial, trend).unwrap();
            prop_assert_eq!(whole, remove(&polynomial, trend).unwrap());
        }
    }
}

#[test]
fn a_harmonic_function_comes_back_from_its_values_around_a_hole() {
    // x² − y² has no Laplacian, nor a finite-difference one, for any spacings.
    let spacing = [0.3, 0.7];
    let whole = Array2::from_shape_fn((120, 90), |(i, j)| {
        let (x, y) = (i as f64 * spacing[0], j as f64 * spacing[1]);
        x * x - y * y + 0.3 * x * y + x - 5.0
    });
    let holes =
        with_holes(whole.clone(), |i, j| (10..110).contains(&i) && (5..80).contains(&j) && (i + 2 * j) % 17 > 0);
    let filled = fill(&holes, spacing, Fill::Harmonic).unwrap();
    let size = whole.iter().map(|h| h.abs()).fold(0.0, f64::max);
    assert!(worst(&filled, &whole) < 1e-11 * size, "{}", worst(&filled, &whole));
    assert!(holes.iter().zip(&filled).all(|(hole, filled)| hole.is_nan() || hole == filled));
}

#[test]
fn half_of_a_large_scan_is_filled_in_few_iterations_with_the_same_bits_for_any_number_of_threads() {
    let whole = rough([300, 257], 3);
    // One block, where the distance to the defined points is largest, and single points.
    for holes in [
        with_holes(whole.clone(), |i, j| (20..280).contains(&i) && (60..250).contains(&j)),
        with_holes(whole.clone(), |_, j| j > 2),
        with_holes(whole.clone(), |i, j| noise(i, j, 8) < 0.5),
    ] {
        for how in [Fill::Harmonic, Fill::Nearest] {
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| fill(&holes, [1.0, 1.0], how).unwrap())
            };
            let filled = on(1);
            assert_eq!(filled, on(3), "{how}");
            // The fill never exceeds the range of the heights around it.
            assert!(filled.iter().all(|h| (0.0..1.0).contains(h)), "{how}");
        }
    }
}

#[test]
fn what_cannot_be_filled_or_fitted_is_refused() {
    let nothing = Array2::from_elem((3, 2), f64::NAN);
    let error = fill(&nothing, [1.0, 1.0], Fill::Nearest).unwrap_err();
    assert_eq!(error.to_string(), "all of the 6 points are undefined; at least one must have a height");
    let mut infinite = rough([3, 3], 1);
    infinite[[1, 1]] = f64::INFINITY;
    assert!(matches!(fill(&infinite, [1.0, 1.0], Fill::Harmonic), Err(SurfaceError::NotFinite { count: 1, .. })));
    assert!(fill(&rough([3, 3], 1), [1.0, f64::NAN], Fill::Harmonic).is_err());
    let line = with_holes(rough([9, 9], 1), |i, _| i != 4);
    assert!(matches!(remove_from_defined(&line, Trend::Plane), Err(SurfaceError::TooFewPoints { .. })));
    assert!(remove_from_defined(&infinite, Trend::Plane).is_err());
}
