//! Tests of `gfmd-heat` as one program; run one file with `cargo test -p gfmd-heat --test suite FILE::`.

mod closed_forms;
mod two_bodies;

use gfmd_field::Grid;
use gfmd_heat::{Budget, Flash, Heated, Thermal};
use ndarray::Array2;

fn thermal(conductivity: f64, diffusivity: f64) -> Thermal {
    Thermal::new(conductivity, diffusivity).unwrap()
}

fn heat(flash: &Flash, flux: &Array2<f64>, tolerance: f64) -> Heated {
    flash.heat(flux, &Budget { tolerance, ..Budget::default() }, &mut ()).unwrap()
}

/// Returns a flux in patches of many sizes.
fn patches(grid: &Grid, seed: u64) -> Array2<f64> {
    let place = |i: usize, n: usize| i as f64 / n as f64;
    let [nx, ny] = grid.points();
    let phase = 0.7 * seed as f64;
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [place(i, nx), place(j, ny)].map(|x| std::f64::consts::TAU * x);
        let wave = (x + phase).cos() * (y - phase).cos() + 0.5 * (3.0 * x - 2.0 * y).sin() + 0.3 * (7.0 * y + x).cos();
        (wave - 0.4).max(0.0)
    })
}
