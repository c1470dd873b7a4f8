//! Transforms of large grids against `ndrustfft`, axis by axis. They are not tested in gfmd-field, where its planners
//! would be compiled a second time at the highest level.

use std::f64::consts::TAU;

use gfmd_field::{Grid, Transform};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2};
use ndrustfft::{Complex, FftHandler, R2cFftHandler, ndfft, ndfft_r2c, ndifft, ndifft_r2c};
use num_complex::Complex64;

/// Grids that are too large for the plain sum.
const LARGE: [[usize; 2]; 10] = [
    [128, 128],
    [127, 130],
    [130, 127],
    [257, 64],
    [64, 257],
    [300, 200],
    [5, 3000],
    [800, 700],
    [40_000, 14],
    [3000, 5],
];

fn grid(points: [usize; 2]) -> Grid {
    Grid::new(points, [1.5, 0.7]).unwrap()
}

/// Returns reproducible values without regularity.
fn field(grid: &Grid) -> Vec<f64> {
    (0..grid.len()).map(|i| (0.618_034 * i as f64 + 0.01 * (i as f64).sqrt()).fract() - 0.3).collect()
}

fn largest(differences: impl Iterator<Item = f64>) -> f64 {
    differences.fold(0.0, f64::max)
}

/// Computes the convolution K f axis by axis with `ndrustfft`; the kernel is laid out as in this crate, transposed.
fn by_ndrustfft(grid: &Grid, kernel: &[f64], field: &[f64]) -> (Array2<Complex<f64>>, Array2<f64>) {
    let [nx, ny] = grid.points();
    let field = ArrayView2::from_shape((nx, ny), field).unwrap();
    let mut half = Array2::zeros((nx, ny / 2 + 1));
    let mut full = half.clone();
    let along_x = FftHandler::<f64>::new(nx);
    let along_y = R2cFftHandler::<f64>::new(ny);
    ndfft_r2c(&field, &mut half, &along_y, 1);
    ndfft(&half, &mut full, &along_x, 0);
    let spectrum = full.mapv(|f: Complex<f64>| f / grid.len() as f64);
    full *= &ArrayView2::from_shape((ny / 2 + 1, nx), kernel).unwrap().t().mapv(Complex::from);
    ndifft(&full, &mut half, &along_x, 0);
    let mut out = Array2::zeros((nx, ny));
    ndifft_r2c(&half, &mut out, &along_y, 1);
    (spectrum, out)
}

#[test]
fn larger_grids_agree_with_ndrustfft() {
    for points in LARGE {
        let grid = grid(points);
        let transform = Transform::new(grid);
        let mut ws = transform.workspace();
        let field = field(&grid);
        let kernel: Vec<f64> = grid.modes().map(|mode| 1.0 / (TAU + mode.wavenumber())).collect();
        let (expected, expected_out) = by_ndrustfft(&grid, &kernel, &field);

        let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
        transform.forward(&field, &mut spectrum, &mut ws).unwrap();
        let error = largest(spectrum.iter().zip(expected.t()).map(|(a, b)| (a - b).norm()));
        assert!(error < 1e-15, "{points:?}: {error:e}");

        let mut out = vec![0.0; grid.len()];
        transform.convolve(&kernel, &field, &mut out, &mut ws).unwrap();
        let error = largest(out.iter().zip(&expected_out).map(|(a, b)| (a - b).abs()));
        assert!(error < 1e-15, "{points:?}: {error:e}");
    }
}

#[test]
fn a_long_line_agrees_with_ndrustfft() {
    for points in [1 << 16, 3 * 5 * 7 * 11 * 13, 65_537] {
        let grid = Grid::line(points, 3.0).unwrap();
        let transform = Transform::new(grid);
        let field = field(&grid);
        let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
        transform.forward(&field, &mut spectrum, &mut transform.workspace()).unwrap();
        let mut expected = Array1::zeros(points / 2 + 1);
        ndfft_r2c(&ArrayView1::from(&field), &mut expected, &R2cFftHandler::<f64>::new(points), 0);
        let error = largest(spectrum.iter().zip(&expected).map(|(a, b)| (a - b / points as f64).norm()));
        assert!(error < 1e-15, "{points}: {error:e}");
    }
}
