//! Tests of `gfmd-wear` as one program. One file runs with `cargo test -p gfmd-wear --test suite FILE::`.

mod balance;
mod checkpoint;
mod closed_forms;
mod input;
mod reference;

use gfmd_contact::{Contact, Drive, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_wear::{WearContact, WearState};
use ndarray::Array2;

/// Pseudo-random numbers between 0 and 1.
struct Numbers(u64);

impl Numbers {
    fn of(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1))
    }

    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Returns heights of a few waves with random phases, of the order of 0.02.
fn rough(grid: &Grid, seed: u64) -> Array2<f64> {
    let mut numbers = Numbers::of(seed);
    let mut next = || numbers.next();
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

fn material(poisson: f64) -> Material {
    Material::from_young(2.0, poisson).unwrap()
}

fn wearing(body: &Body, grid: &Grid, heights: &Array2<f64>, coefficient: f64) -> WearContact {
    WearContact::new(Contact::new(body, grid, heights).unwrap(), coefficient).unwrap()
}

/// Solves for the loads of a path, each with its sliding distance.
fn follow(contact: &WearContact, path: &[(Load, f64)], tolerance: f64) -> Vec<WearState> {
    let mut states: Vec<WearState> = Vec::new();
    for (load, distance) in path {
        let press = contact.press(Drive::from(*load).after(*distance)).tolerance(tolerance);
        states.push(press.starting_from(states.last()).solve().unwrap());
    }
    states
}

/// Returns a load held over a distance in equal steps, after one step over no distance.
fn held(load: Load, distance: f64, steps: u32) -> Vec<(Load, f64)> {
    (0..=steps).map(|step| (load, distance * f64::from(step) / f64::from(steps))).collect()
}
