//! Identities between transforms that hold for any implementation.

use std::f64::consts::TAU;

use gfmd_field::{Grid, Rows, ShapeError, Transform, Workspace};
use num_complex::Complex64;
use proptest::prelude::*;

fn transform(points: [usize; 2]) -> Transform {
    Transform::new(Grid::new(points, [1.3, 0.9]).unwrap())
}

fn spectrum_of(transform: &Transform, field: &[f64]) -> Vec<Complex64> {
    let mut spectrum = vec![Complex64::ZERO; transform.grid().spectrum_len()];
    transform.forward(field, &mut spectrum, &mut transform.workspace()).unwrap();
    spectrum
}

fn field_of(transform: &Transform, spectrum: &[Complex64]) -> Vec<f64> {
    let mut field = vec![f64::NAN; transform.grid().len()];
    transform.inverse(spectrum, &mut field, &mut transform.workspace()).unwrap();
    field
}

fn convolved(transform: &Transform, kernel: &[f64], field: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::NAN; field.len()];
    transform.convolve(kernel, field, &mut out, &mut transform.workspace()).unwrap();
    out
}

/// Returns a kernel that differs from mode to mode, with k(q) = k(−q) as for any operator on real fields.
fn kernel(grid: &Grid) -> Vec<f64> {
    grid.modes().map(|mode| (0.3 * mode.wavenumber()).cos() + 0.2).collect()
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_cosine_is_one_mode() {
    for points in [[12, 9], [9, 12], [8, 8], [1, 10], [10, 1], [70, 40], [7, 11]] {
        let transform = transform(points);
        let grid = *transform.grid();
        let [nx, ny] = points;
        for (index, mode) in grid.modes().enumerate() {
            let [m, n] = mode.number;
            let phase = if mode.is_self_conjugate() { 0.0 } else { 0.7 };
            let field: Vec<f64> = (0..grid.len())
                .map(|r| {
                    // Whole turns are subtracted before the cosine, so that it is also exact for large numbers.
                    let turns = (m * (r / ny) as i64).rem_euclid(nx as i64) as f64 / nx as f64
                        + (n * (r % ny) as i64).rem_euclid(ny as i64) as f64 / ny as f64;
                    (TAU * turns + phase).cos()
                })
                .collect();
            // cos = (e^{iqr} + e^{−iqr})/2; both halves belong to one mode if q and −q do.
            let half = if mode.is_self_conjugate() { 1.0 } else { 0.5 };
            for (other, (found, at)) in spectrum_of(&transform, &field).iter().zip(grid.modes()).enumerate() {
                let same = |k: usize| points[k] as i64;
                let opposite = (0..2).all(|k| (at.number[k] + mode.number[k]).rem_euclid(same(k)) == 0);
                let expected = match (other == index, opposite) {
                    (true, _) => half * Complex64::cis(phase),
                    (false, true) => half * Complex64::cis(-phase),
                    _ => Complex64::ZERO,
                };
                assert!((found - expected).norm() < 1e-14, "{points:?} {mode:?} seen at {at:?}: {found}");
            }
        }
    }
}

#[test]
fn a_shift_is_a_phase() {
    for points in [[12, 10], [9, 7], [1, 9], [9, 1], [66, 34]] {
        let transform = transform(points);
        let [nx, ny] = points;
        let [dx, dy] = transform.grid().spacing();
        let (a, b) = (5 % nx, 3 % ny);
        let field: Vec<f64> = (0..nx * ny).map(|i| (0.618 * i as f64).fract()).collect();
        let shifted: Vec<f64> =
            (0..nx * ny).map(|i| field[(i / ny + nx - a) % nx * ny + (i % ny + ny - b) % ny]).collect();
        let pairs = spectrum_of(&transform, &field).into_iter().zip(spectrum_of(&transform, &shifted));
        for (mode, (f, g)) in transform.grid().modes().zip(pairs) {
            let [qx, qy] = mode.wavevector;
            let phase = Complex64::cis(-(qx * a as f64 * dx + qy * b as f64 * dy));
            assert!((g - f * phase).norm() < 1e-14, "{points:?} {mode:?}");
        }
    }
}

#[test]
fn convolution_of_cosines_multiplies_them() {
    let transform = transform([24, 15]);
    let [dx, dy] = transform.grid().spacing();
    let kernel = kernel(transform.grid());
    for (mode, k) in transform.grid().modes().zip(&kernel) {
        let wave =
            |i: usize| (mode.wavevector[0] * (i / 15) as f64 * dx + mode.wavevector[1] * (i % 15) as f64 * dy).cos();
        let field: Vec<f64> = (0..360).map(wave).collect();
        let expected: Vec<f64> = field.iter().map(|f| k * f).collect();
        assert!(largest(&convolved(&transform, &kernel, &field), &expected) < 1e-13, "{mode:?}");
    }
}

fn case() -> impl Strategy<Value = (Transform, Vec<f64>, Vec<f64>)> {
    let points = prop_oneof![
        [1usize..90, 1usize..90],
        [1usize..6, 1usize..400],
        [1usize..400, 1usize..6],
        (1usize..2000).prop_map(|n| [n, 1]),
    ];
    let value = || -1.0..1.0f64;
    points.prop_flat_map(move |points| {
        let n = points[0] * points[1];
        (Just(points), prop::collection::vec(value(), n), prop::collection::vec(value(), n))
            .prop_map(|(points, f, g)| (transform(points), f, g))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn there_and_back((transform, f, _) in case()) {
        let back = field_of(&transform, &spectrum_of(&transform, &f));
        prop_assert!(largest(&f, &back) < 1e-13);
    }

    #[test]
    fn mean_and_mean_square_are_in_the_spectrum((transform, f, _) in case()) {
        let n = f.len() as f64;
        let spectrum = spectrum_of(&transform, &f);
        prop_assert!((spectrum[0].re - f.iter().sum::<f64>() / n).abs() < 1e-14);
        let modes = transform.grid().modes().zip(&spectrum);
        let sum: f64 = modes.map(|(mode, f)| mode.weight * f.norm_sqr()).sum();
        prop_assert!((sum - f.iter().map(|f| f * f).sum::<f64>() / n).abs() < 1e-13);
    }

    #[test]
    fn modes_that_are_their_own_conjugate_are_real((transform, f, _) in case()) {
        for (mode, f) in transform.grid().modes().zip(spectrum_of(&transform, &f)) {
            prop_assert!(!mode.is_self_conjugate() || f.im.abs() < 1e-15, "{mode:?}: {f}");
        }
    }

    #[test]
    fn linear((transform, f, g) in case(), a in -3.0..3.0f64) {
        let kernel = kernel(transform.grid());
        let both: Vec<f64> = f.iter().zip(&g).map(|(f, g)| f + a * g).collect();
        let one = convolved(&transform, &kernel, &f);
        let other = convolved(&transform, &kernel, &g);
        let expected: Vec<f64> = one.iter().zip(&other).map(|(f, g)| f + a * g).collect();
        prop_assert!(largest(&convolved(&transform, &kernel, &both), &expected) < 1e-13);
    }

    #[test]
    fn convolution_is_a_product_of_spectra((transform, f, _) in case()) {
        // For any real kernel, also with k(q) ≠ k(−q), the result is the real part.
        let kernel: Vec<f64> = (0..transform.grid().spectrum_len()).map(|i| (0.7 * i as f64).sin()).collect();
        let product: Vec<_> = spectrum_of(&transform, &f).iter().zip(&kernel).map(|(f, k)| f * k).collect();
        prop_assert!(largest(&convolved(&transform, &kernel, &f), &field_of(&transform, &product)) < 1e-13);
    }

    #[test]
    fn quadratic_form_is_the_mean_of_the_product((transform, f, g) in case()) {
        let kernel = kernel(transform.grid());
        let mut ws = transform.workspace();
        let form = transform.quadratic_form(&kernel, &f, &mut ws).unwrap();
        let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
        prop_assert!((form - mean(&f, &convolved(&transform, &kernel, &f))).abs() < 1e-13);
        // And K is symmetric.
        let [fg, gf] = [(&f, &g), (&g, &f)].map(|(f, g)| mean(f, &convolved(&transform, &kernel, g)));
        prop_assert!((fg - gf).abs() < 1e-13);
    }

    #[test]
    fn rows_made_and_handed_on_are_those_of_the_field((transform, f, g) in case()) {
        let kernel = kernel(transform.grid());
        let [mut out, mut changed] = [vec![f64::NAN; f.len()], g.clone()];
        let columns = if transform.grid().points().contains(&1) { f.len() } else { transform.grid().points()[1] };
        let mut numbers = vec![usize::MAX; f.len() / columns];
        transform
            .convolve_rows(
                &kernel,
                (Rows(&f[..], columns), Rows(&mut changed[..], columns)),
                |i, (Rows(f, _), Rows(changed, _)), row| {
                    row.copy_from_slice(f);
                    changed.iter_mut().for_each(|g| *g += i as f64);
                },
                (Rows(&mut out[..], columns), &mut numbers[..]),
                |i, row, (Rows(out, _), number)| {
                    out.copy_from_slice(row);
                    number[0] = i;
                },
                &mut transform.workspace(),
            )
            .unwrap();
        prop_assert_eq!(out, convolved(&transform, &kernel, &f));
        prop_assert!(numbers.iter().enumerate().all(|(i, number)| i == *number));
        prop_assert!(changed.iter().zip(&g).enumerate().all(|(at, (new, g))| *new == g + (at / columns) as f64));
    }

    #[test]
    fn single_precision_is_that_of_seven_digits((transform, f, _) in case()) {
        let kernel = kernel(transform.grid());
        let single = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<_>>();
        let exact = convolved(&transform, &kernel, &f);
        let short = Transform::<f32>::new(*transform.grid());
        let (mut out, mut ws) = (vec![f32::NAN; f.len()], short.workspace());
        short.convolve(&single(&kernel), &single(&f), &mut out, &mut ws).unwrap();
        let largest = exact.iter().chain(&f).fold(0.0, |most: f64, u| most.max(u.abs()));
        prop_assert!(out.iter().zip(&exact).all(|(a, b)| (f64::from(*a) - b).abs() < 3e-6 * largest.max(1e-30)));
        let form = short.quadratic_form(&single(&kernel), &single(&f), &mut ws).unwrap();
        let expected = transform.quadratic_form(&kernel, &f, &mut transform.workspace()).unwrap();
        prop_assert!((form - expected).abs() < 3e-6 * largest * largest, "{} {}", form, expected);
    }
}

#[test]
fn same_bits_for_any_number_of_threads() {
    for points in [[256, 256], [300, 257], [67, 1000], [1000, 66]] {
        let transform = transform(points);
        let grid = *transform.grid();
        let kernel = kernel(&grid);
        let field: Vec<f64> = (0..grid.len()).map(|i| (0.618 * i as f64).fract()).collect();
        let run = || {
            let mut ws = transform.workspace();
            let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
            let [mut out, mut back] = [vec![0.0; grid.len()], vec![0.0; grid.len()]];
            transform.forward(&field, &mut spectrum, &mut ws).unwrap();
            transform.inverse(&spectrum, &mut back, &mut ws).unwrap();
            transform.convolve(&kernel, &field, &mut out, &mut ws).unwrap();
            let form = transform.quadratic_form(&kernel, &field, &mut ws).unwrap();
            let reals = out.into_iter().chain(back).chain([form]).chain(spectrum.iter().flat_map(|f| [f.re, f.im]));
            reals.map(f64::to_bits).collect::<Vec<_>>()
        };
        let on = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
        let alone = on(1);
        assert!(alone == on(2) && alone == on(3), "{points:?}");
    }
}

#[test]
fn plans_and_memory_go_between_threads() {
    let transform = transform([4, 4]);
    let kernel = kernel(transform.grid());
    let field: Vec<f64> = (0..16).map(|i| (0.618 * f64::from(i)).fract()).collect();
    let convolve = |mut ws: Workspace| {
        let mut out = vec![0.0; field.len()];
        transform.convolve(&kernel, &field, &mut out, &mut ws).unwrap();
        out
    };
    let (here, moved) = (transform.workspace(), transform.workspace());
    let there = std::thread::scope(|scope| scope.spawn(|| convolve(moved)).join().unwrap());
    assert_eq!(there, convolve(here));
}

#[test]
fn a_workspace_serves_again_and_in_other_pools() {
    let transform = transform([300, 200]);
    let kernel = kernel(transform.grid());
    let mut ws = transform.workspace();
    let mut run = |threads: usize, salt: f64| {
        let field: Vec<f64> = (0..60_000).map(|i| (salt * i as f64).fract()).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut out = vec![0.0; field.len()];
        pool.install(|| transform.convolve(&kernel, &field, &mut out, &mut ws)).unwrap();
        out
    };
    let first = run(1, 0.618);
    let other = run(4, 0.414);
    assert_ne!(first, other);
    assert_eq!(first, run(4, 0.618));
}

#[test]
fn wrong_lengths_are_refused() {
    let here = transform([8, 6]);
    let mut ws = here.workspace();
    let wrong = |what, found, expected| Err(ShapeError { what, found, expected });
    let mut spectrum = vec![Complex64::ZERO; 32];
    let mut out = vec![0.0; 48];
    let (kernel, field) = (vec![1.0; 32], vec![0.0; 48]);

    assert_eq!(here.forward(&field[1..], &mut spectrum, &mut ws), wrong("field", 47, 48));
    assert_eq!(here.forward(&field, &mut spectrum[1..], &mut ws), wrong("spectrum", 31, 32));
    assert_eq!(here.inverse(&spectrum[..2], &mut out, &mut ws), wrong("spectrum", 2, 32));
    assert_eq!(here.inverse(&spectrum, &mut out[..0], &mut ws), wrong("field", 0, 48));
    assert_eq!(here.convolve(&kernel[1..], &field, &mut out, &mut ws), wrong("kernel", 31, 32));
    assert_eq!(here.convolve(&kernel, &field[1..], &mut out, &mut ws), wrong("field", 47, 48));
    assert_eq!(here.convolve(&kernel, &field, &mut out[1..], &mut ws), wrong("output", 47, 48));
    assert_eq!(
        here.quadratic_form(&kernel[1..], &field, &mut ws),
        Err(ShapeError { what: "kernel", found: 31, expected: 32 })
    );

    let mut other = transform([6, 8]).workspace();
    assert_eq!(here.forward(&field, &mut spectrum, &mut other), wrong("workspace along x", 6, 8));
    let mut line = transform([48, 1]).workspace();
    assert_eq!(here.convolve(&kernel, &field, &mut out, &mut line), wrong("workspace along x", 48, 8));
    let message = wrong("field", 47, 48).unwrap_err().to_string();
    assert_eq!(message, "the field has 47 values; it must have 48 on this grid");
}
