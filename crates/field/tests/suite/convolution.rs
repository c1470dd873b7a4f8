//! Convolutions on a patch, compared with direct sums.

use gfmd_field::{Convolution, Grid};

/// Reproducible, scattered numbers.
fn noise(n: usize, seed: f64) -> Vec<f64> {
    (0..n).map(|i| ((i as f64 + 1.0) * 0.618_034 + seed).fract() - 0.5).collect()
}

#[test]
fn a_convolution_is_the_sum_on_any_grid() {
    let kernel = |[i, j]: [usize; 2]| 1.0 / (1.0 + (i as f64).hypot(1.3 * j as f64));
    for points in [[1, 1], [5, 1], [1, 6], [2, 2], [3, 8], [8, 3], [16, 16], [13, 11], [70, 33], [33, 130]] {
        let grid = Grid::new(points, [1.0, 2.0]).unwrap();
        let convolution = Convolution::new(grid, kernel);
        let mut ws = convolution.workspace();
        let field = noise(grid.len(), 0.3);
        let mut out = vec![f64::NAN; grid.len()];
        // Twice: the memory of the first call must not affect the second.
        for _ in 0..2 {
            convolution.apply(&field, &mut out, &mut ws).unwrap();
        }
        let [nx, ny] = points;
        let mut form = 0.0;
        for (index, out) in out.iter().enumerate() {
            let [i, j] = [index / ny, index % ny];
            let sum: f64 = (0..nx * ny).map(|s| kernel([i.abs_diff(s / ny), j.abs_diff(s % ny)]) * field[s]).sum();
            form += field[index] * sum;
            assert!((out - sum).abs() < 1e-12, "{points:?} {index}: {out} {sum}");
        }
        let found = convolution.quadratic_form(&field, &mut ws).unwrap();
        assert!((found - form).abs() < 1e-12 * form.abs().max(1.0), "{points:?}: {found} {form}");
    }
}

/// Returns the number of points of the cell around a patch of `points` points.
fn padded(points: usize) -> usize {
    Grid::square(points, 1.0).unwrap().padded().unwrap().points()[1]
}

#[test]
fn lengths_are_even_and_fast_and_hold_two_patches() {
    assert_eq!(padded(1), 1, "there is nothing to repeat");
    for points in 2..2000 {
        let length = padded(points);
        assert!(length.is_multiple_of(2), "{points}: {length}");
        assert!(length >= 2 * points, "{points}: {length}");
        assert!(length <= 3 * points, "{points}: {length}");
    }
    assert_eq!([64, 100, 509, 512].map(padded), [128, 200, 1024, 1024]);
}

#[test]
fn wrong_sizes_are_refused() {
    let convolution = Convolution::new(Grid::square(4, 1.0).unwrap(), |_| 1.0);
    let mut ws = convolution.workspace();
    let mut out = vec![0.0; 16];
    assert!(convolution.apply(&[0.0; 15], &mut out, &mut ws).is_err());
    assert!(convolution.apply(&[0.0; 16], &mut out[..9], &mut ws).is_err());
    let mut other = Convolution::new(Grid::square(6, 1.0).unwrap(), |_| 1.0).workspace();
    assert!(convolution.apply(&[0.0; 16], &mut out, &mut other).is_err());
    assert!(convolution.quadratic_form(&[0.0; 16], &mut other).is_err());
}
