//! Operators that are diagonal in cosine waves.

use gfmd_field::{Convolution, Cosines, Grid, Rows};

fn copy(_: usize, row: &mut [f64], Rows(out, _): Rows<&mut [f64]>) {
    out.copy_from_slice(row);
}

fn wave(n: usize, m: usize) -> Vec<f64> {
    (0..n).map(|i| (std::f64::consts::PI * m as f64 * (i as f64 + 0.5) / n as f64).cos()).collect()
}

#[test]
fn every_wave_is_multiplied_by_its_value_of_the_kernel() {
    for points in [[1, 1], [5, 1], [1, 6], [2, 3], [8, 8], [70, 33]] {
        let grid = Grid::new(points, [1.0, 2.0]).unwrap();
        let cosines = Cosines::new(grid);
        let mut ws = cosines.workspace();
        let kernel: Vec<f64> = (0..grid.len()).map(|k| 1.0 + (0.618_034 * k as f64).fract()).collect();
        let [nx, ny] = grid.rows();
        for [m, n] in [[0, 0], [nx - 1, ny - 1], [nx / 2, 0], [0, ny / 2], [nx / 2, ny / 3]] {
            let (x, y) = (wave(nx, m), wave(ny, n));
            let mut out = vec![f64::NAN; grid.len()];
            let source = |i: usize, (): (), row: &mut [f64]| row.iter_mut().zip(&y).for_each(|(r, y)| *r = x[i] * y);
            cosines.apply(&kernel, (), source, Rows(&mut out[..], ny), copy, &mut ws).unwrap();
            for (index, out) in out.iter().enumerate() {
                let exact = kernel[n * nx + m] * x[index / ny] * y[index % ny];
                assert!((out - exact).abs() < 1e-13, "{points:?} {m} {n}: {out} {exact}");
            }
        }
    }
}

#[test]
fn quotients_are_those_of_the_convolution() {
    let kernel = |[i, j]: [usize; 2]| 1.0 / (1.0 + (i as f64).hypot(1.3 * j as f64));
    for points in [[1, 1], [5, 1], [1, 6], [2, 3], [8, 8], [9, 12]] {
        let grid = Grid::new(points, [1.0, 2.0]).unwrap();
        let (cosines, convolution) = (Cosines::new(grid), Convolution::new(grid, kernel));
        let quotients = cosines.quotients(kernel);
        let [nx, ny] = grid.rows();
        let mut ws = convolution.workspace();
        for n in 0..ny {
            for m in 0..nx {
                let (x, y) = (wave(nx, m), wave(ny, n));
                let field: Vec<f64> = x.iter().flat_map(|x| y.iter().map(move |y| x * y)).collect();
                let square: f64 = field.iter().map(|f| f * f).sum();
                let exact = convolution.quadratic_form(&field, &mut ws).unwrap() / square;
                let found = quotients[n * nx + m];
                assert!((found - exact).abs() < 1e-12, "{points:?} {m} {n}: {found} {exact}");
            }
        }
    }
}

#[test]
fn wrong_sizes_are_refused() {
    let cosines = Cosines::new(Grid::square(4, 1.0).unwrap());
    let mut ws = cosines.workspace();
    let mut out = [0.0; 16];
    assert!(cosines.apply(&[1.0; 15], (), |_, (), _| {}, Rows(&mut out[..], 4), copy, &mut ws).is_err());
    assert!(cosines.apply(&[1.0; 16], (), |_, (), _| {}, Rows(&mut out[..9], 4), copy, &mut ws).is_err());
    let mut other = Cosines::new(Grid::square(6, 1.0).unwrap()).workspace();
    assert!(cosines.apply(&[1.0; 16], (), |_, (), _| {}, Rows(&mut out[..], 4), copy, &mut other).is_err());
}
