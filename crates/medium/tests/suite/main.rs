//! Tests of `gfmd-medium` as one program. `cargo test -p gfmd-medium --test suite FILE::` runs one file.

mod hunter;
mod rubbing;
mod sliding;

use gfmd_field::Grid;
use gfmd_green::Material;
use gfmd_medium::Prony;
use ndarray::Array2;
use serde_json::Value;

/// Returns heights of about 0.02: a few waves with random phases.
fn rough(grid: &Grid, seed: u64) -> Array2<f64> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1);
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let waves: Vec<[f64; 4]> = (0..6)
        .map(|_| [(1.0 + 3.0 * next()).floor(), (6.0 * next()).floor() - 3.0, std::f64::consts::TAU * next(), next()])
        .collect();
    let [nx, ny] = grid.points();
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [i as f64 / nx as f64, if ny > 1 { j as f64 / ny as f64 } else { 0.0 }];
        let wave = |[m, n, phase, size]: &[f64; 4]| {
            size * (std::f64::consts::TAU * (m * x + n * y) + phase).cos() / (1.0 + m.hypot(*n))
        };
        0.02 * waves.iter().map(wave).sum::<f64>()
    })
}

/// Returns a material with three branches.
fn three() -> Prony {
    Prony::from_fractions(&[(0.05, 0.3), (0.7, 0.25), (6.0, 0.2)]).unwrap()
}

fn one() -> Prony {
    Prony::from_fractions(&[(1.3, 0.6)]).unwrap()
}

fn material(poisson: f64) -> Material {
    Material::from_young(2.0, poisson).unwrap()
}

/// Returns the numbers of a JSON array.
fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}
