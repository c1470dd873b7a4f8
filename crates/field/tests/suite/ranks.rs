//! Transforms over ranks, played by threads, have the same bits as with one process.

use gfmd_field::{Convolution, Cosines, Grid, Real, Rows, Share, Transform};
use gfmd_vector::ThreadRanks;
use num_complex::Complex;
use proptest::prelude::*;

fn noise<T: Real>(n: usize, seed: f64) -> Vec<T> {
    (0..n).map(|i| T::nearest(((i as f64 + 1.0) * 0.618_034 + seed).fract() - 0.5)).collect()
}

fn same<T: Real>(a: &[T], b: &[T]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.widened().to_bits() == b.widened().to_bits())
}

/// Compares convolution, quadratic form and transforms over several ranks with the results of one process.
fn assert_bits_of_one<T: Real>([nx, ny]: [usize; 2], size: usize) {
    let grid = Grid::new([nx, ny], [1.0, 2.0]).unwrap();
    let half = ny / 2 + 1;
    let (field, full) = (noise::<T>(nx * ny, 0.3), noise::<T>(nx * half, 0.1));
    // Even in q_x, as kernels with a stored quarter.
    let line = nx / 2 + 1;
    let quarter: Vec<T> = full.chunks(nx).flat_map(|column| column[..line].iter().copied()).collect();
    let transform = Transform::<T>::new(grid);
    let ws = &mut transform.workspace();
    let mut spectrum = vec![Complex::new(T::ZERO, T::ZERO); nx * half];
    transform.forward(&field, &mut spectrum, ws).unwrap();
    let mut inverse = vec![T::ZERO; nx * ny];
    transform.inverse(&spectrum, &mut inverse, ws).unwrap();
    let whole = [(&full, nx), (&quarter, line)].map(|(kernel, line)| {
        let mut out = vec![T::ZERO; nx * ny];
        transform.convolve(kernel, &field, &mut out, ws).unwrap();
        (out, transform.quadratic_form(kernel, &field, ws).unwrap(), kernel, line)
    });
    ThreadRanks::of(size, |ranks| {
        let share = Share::among(ranks, [nx, ny], 0).unwrap();
        let transform = Transform::<T>::distributed(grid, &share);
        let (ws, lanes, own) = (&mut transform.workspace(), transform.lanes(), share.own());
        let mut out = vec![T::ZERO; own.len()];
        // Twice: the memory of the first call must not affect the second.
        for (whole, form, kernel, line) in whole.iter().chain(&whole) {
            let kernel = &kernel[lanes.start * line..lanes.end * line];
            transform.convolve(kernel, &field[own.clone()], &mut out, ws).unwrap();
            assert!(same(&out, &whole[own.clone()]), "[{nx}, {ny}] on {size}");
            let found = transform.quadratic_form(kernel, &field[own.clone()], ws).unwrap();
            assert_eq!(found.to_bits(), form.to_bits(), "[{nx}, {ny}] on {size}");
        }
        let own_modes = lanes.start * nx..lanes.end * nx;
        let mut modes = vec![Complex::new(T::ZERO, T::ZERO); own_modes.len()];
        transform.forward(&field[own.clone()], &mut modes, ws).unwrap();
        assert!(modes.iter().zip(&spectrum[own_modes]).all(|(a, b)| a == b), "[{nx}, {ny}] on {size}");
        transform.inverse(&modes, &mut out, ws).unwrap();
        assert!(same(&out, &inverse[own]), "[{nx}, {ny}] on {size}");
    });
}

/// Returns the numbers of ranks up to `most`: all in the long tests (`.ci/long`), else some.
fn sizes(most: usize) -> impl Iterator<Item = usize> {
    let is_long = std::env::var_os("GFMD_LONG").is_some();
    (1..=most).filter(move |size| is_long || [1, 2, 5, 7].contains(size))
}

#[test]
fn transforms_over_ranks_have_the_bits_of_one_process() {
    for points in [[256, 256], [512, 1000], [1024, 512], [96, 2048], [33, 4096], [4096, 2], [700, 8]] {
        for size in sizes(Share::most(points, 0).min(7)) {
            assert_bits_of_one::<f64>(points, size);
            assert_bits_of_one::<f32>(points, size);
        }
    }
}

/// Compares convolutions, cosine operators and transforms of a patch over several ranks with the results of one
/// process.
fn assert_patch_has_bits_of_one<T: Real>(points: [usize; 2], size: usize) {
    let grid = Grid::new(points, [1.0, 2.0]).unwrap();
    let kernel = |[i, j]: [usize; 2]| 1.0 / (1.0 + (i as f64).hypot(1.3 * j as f64));
    let [nx, ny] = points;
    let (field, waves) = (noise::<T>(nx * ny, 0.3), noise::<T>(nx * ny, 0.1));
    let results = |share: &Share| {
        let convolution = Convolution::<T>::distributed(grid, share, kernel);
        let (mut ws, own) = (convolution.workspace(), &field[share.own()]);
        let mut convolved = vec![T::ZERO; own.len()];
        // Twice: the memory of the first call must not affect the second.
        for _ in 0..2 {
            convolution.apply(own, &mut convolved, &mut ws).unwrap();
        }
        let form = convolution.quadratic_form(own, &mut ws).unwrap();
        let cosines = Cosines::<T>::distributed(grid, share);
        let (mut ws, columns) = (cosines.workspace(), cosines.columns());
        let mut filtered = vec![T::ZERO; own.len()];
        for _ in 0..2 {
            let source = |i: usize, (): (), row: &mut [T]| row.copy_from_slice(&own[i * ny..(i + 1) * ny]);
            let sink = |_: usize, row: &mut [T], Rows(out, _): Rows<&mut [T]>| out.copy_from_slice(row);
            let kernel = &waves[columns.start * nx..columns.end * nx];
            cosines.apply(kernel, (), source, Rows(&mut filtered[..], ny), sink, &mut ws).unwrap();
        }
        let quotients = Cosines::<f64>::distributed(grid, share).quotients(kernel);
        let transform = Transform::<T>::padded(2, &grid, share).unwrap();
        let [_, lane] = transform.grid().spectrum_shape();
        let mut modes = vec![Complex::new(T::ZERO, T::ZERO); transform.lanes().len() * lane];
        let mut ws = transform.workspace();
        transform.forward(own, &mut modes, &mut ws).unwrap();
        let mut inverse = vec![T::ZERO; own.len()];
        transform.inverse(&modes, &mut inverse, &mut ws).unwrap();
        let form = form.to_bits();
        let modes = modes.iter().flat_map(|mode| [mode.re, mode.im]).map(|x| x.widened().to_bits());
        (
            [convolved, filtered, inverse],
            [quotients.iter().map(|k| k.to_bits()).collect(), modes.collect::<Vec<_>>()],
            form,
        )
    };
    let (fields, by_wave, form) = results(&grid.whole());
    let each = ThreadRanks::of(size, |ranks| results(&Share::among(ranks, points, 0).unwrap()));
    for (which, field) in fields.iter().enumerate() {
        let found: Vec<T> = each.iter().flat_map(|(fields, ..)| &fields[which]).copied().collect();
        assert!(same(&found, field), "field {which} of {points:?} on {size}");
    }
    for (which, values) in by_wave.iter().enumerate() {
        let found = each.iter().flat_map(|(_, by_wave, _)| &by_wave[which]);
        assert!(found.eq(values), "waves {which} of {points:?} on {size}");
    }
    assert!(each.iter().all(|(.., found)| *found == form), "{points:?} on {size}");
}

#[test]
fn patches_over_ranks_have_the_bits_of_one_process() {
    for points in [[256, 256], [130, 176], [512, 1000], [33, 2048], [4096, 2], [700, 8]] {
        for size in sizes(Share::most(points, 0).min(5)) {
            assert_patch_has_bits_of_one::<f64>(points, size);
            assert_patch_has_bits_of_one::<f32>(points, size);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn transforms_over_ranks_have_the_bits_of_one_process_whatever_the_shape(
        rows in 2_usize..300, columns in 2_usize..600, exponent in 0_u32..9, size in 1_usize..=7,
    ) {
        let columns = (columns >> exponent).max(1) << exponent;
        let points = [rows, columns.max(2)];
        assert_bits_of_one::<f64>(points, size.min(Share::most(points, 0)));
        assert_patch_has_bits_of_one::<f64>(points, size.min(Share::most(points, 0)));
    }
}

#[test]
fn slices_that_do_not_fit_the_share_are_refused() {
    let grid = Grid::square(64, 1.0).unwrap();
    ThreadRanks::of(2, |ranks| {
        let share = Share::among(ranks, [64, 64], 0).unwrap();
        let transform = Transform::<f64>::distributed(grid, &share);
        let mut ws = transform.workspace();
        let kernel = vec![1.0; transform.lanes().len() * 64];
        let mut out = vec![0.0; share.own().len()];
        assert!(transform.convolve(&kernel, &[0.0; 4096], &mut out, &mut ws).is_err());
        assert!(transform.quadratic_form(&[1.0; 33 * 64], &out, &mut ws).is_err());
        let half = |_: usize, (): (), _: &mut [f64]| ();
        assert!(transform.convolve_ahead(&kernel, (), half, &mut ws).is_ok());
        assert!(transform.convolve_back(Rows(&mut [0.0; 4096][..], 64), |_, _, _| (), &mut ws).is_err());
    });
}

/// One process has all lanes of the half spectrum, for any shape of the grid.
#[test]
fn one_process_has_all_lanes() {
    for points in [[8, 6], [9, 1], [1, 9], [1, 8], [1, 1], [2, 2]] {
        let grid = Grid::new(points, [1.0, 1.0]).unwrap();
        let [lanes, _] = grid.spectrum_shape();
        assert_eq!(Transform::<f64>::new(grid).lanes(), 0..lanes, "{points:?}");
    }
}
