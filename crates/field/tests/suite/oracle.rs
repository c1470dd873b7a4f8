//! Transforms compared with their defining sums. On larger grids, tests/tests/suite/transforms.rs compares them with
//! `ndrustfft`.

use gfmd_field::{Grid, Transform};
use num_complex::Complex64;

/// Grids with even, odd and prime numbers of points, square and oblong, with full and partial blocks and panels, lines
/// and single rows.
const GRIDS: [[usize; 2]; 24] = [
    [1, 1],
    [2, 1],
    [1, 2],
    [7, 1],
    [1, 8],
    [64, 1],
    [1, 45],
    [2, 2],
    [2, 3],
    [3, 2],
    [3, 3],
    [4, 4],
    [5, 8],
    [8, 5],
    [6, 10],
    [9, 15],
    [16, 16],
    [17, 13],
    [13, 34],
    [32, 4],
    [4, 33],
    [66, 6],
    [65, 7],
    [6, 67],
];
fn grid(points: [usize; 2]) -> Grid {
    Grid::new(points, [1.5, 0.7]).unwrap()
}

/// Reproducible values without any regularity.
fn field(grid: &Grid) -> Vec<f64> {
    (0..grid.len()).map(|i| (0.618_034 * i as f64 + 0.01 * (i as f64).sqrt()).fract() - 0.3).collect()
}

fn largest(differences: impl Iterator<Item = f64>) -> f64 {
    differences.fold(0.0, f64::max)
}

/// Computes the spectrum f̃(q) = (1/N) Σ_r f(r) e^{−i q·r} directly, from wave vectors and positions.
fn sum_of_the_definition(grid: &Grid, field: &[f64]) -> Vec<Complex64> {
    let [nx, ny] = grid.points();
    let [dx, dy] = grid.spacing();
    let at = |q: [f64; 2]| -> Complex64 {
        let points = (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j)));
        points
            .zip(field)
            .map(|((i, j), f)| f * Complex64::cis(-(q[0] * i as f64 * dx + q[1] * j as f64 * dy)))
            .sum::<Complex64>()
            / grid.len() as f64
    };
    grid.modes().map(|mode| at(mode.wavevector)).collect()
}

#[test]
fn forward_is_the_sum_of_the_definition() {
    for points in GRIDS {
        let grid = grid(points);
        let transform = Transform::new(grid);
        let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
        transform.forward(&field(&grid), &mut spectrum, &mut transform.workspace()).unwrap();
        let expected = sum_of_the_definition(&grid, &field(&grid));
        let error = largest(spectrum.iter().zip(&expected).map(|(a, b)| (a - b).norm()));
        assert!(error < 1e-14, "{points:?}: {error:e}");
    }
}

#[test]
fn inverse_is_the_real_part_of_the_sum_over_all_modes() {
    for points in GRIDS {
        let grid = grid(points);
        let transform = Transform::new(grid);
        // Amplitudes of no real field, with imaginary parts in all modes.
        let values = field(&Grid::new([grid.spectrum_len(), 2], [1.0, 1.0]).unwrap());
        let spectrum: Vec<Complex64> = values.chunks(2).map(|pair| Complex64::new(pair[0], pair[1])).collect();
        let mut found = vec![0.0; grid.len()];
        transform.inverse(&spectrum, &mut found, &mut transform.workspace()).unwrap();
        let [dx, dy] = grid.spacing();
        let ny = grid.points()[1];
        let error = largest(found.iter().enumerate().map(|(index, found)| {
            let r = [(index / ny) as f64 * dx, (index % ny) as f64 * dy];
            let terms = grid.modes().zip(&spectrum).map(|(mode, f)| {
                let [qx, qy] = mode.wavevector;
                mode.weight * (f * Complex64::cis(qx * r[0] + qy * r[1])).re
            });
            (found - terms.sum::<f64>()).abs()
        }));
        assert!(error < 2e-14 * grid.len() as f64, "{points:?}: {error:e}");
    }
}
