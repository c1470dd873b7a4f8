//! Tests of `gfmd-viscoelastic` as one program. `cargo test -p gfmd-viscoelastic --test suite FILE::` runs one file.

mod checkpoint;
mod closed_forms;
mod energy;
mod hunter;
mod input;
mod law;
mod reference;
mod sliding;

use gfmd_contact::{Contact, Drive, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_viscoelastic::{Prony, Relaxes, ViscoelasticContact, ViscoelasticState};
use ndarray::Array2;

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

fn viscoelastic(
    body: &Body,
    grid: &Grid,
    heights: &Array2<f64>,
    prony: &Prony,
    relaxes: Relaxes,
) -> ViscoelasticContact {
    ViscoelasticContact::new(Contact::new(body, grid, heights).unwrap(), body, prony, relaxes).unwrap()
}

/// Follows a path of loads, each with its time since the start.
fn follow(contact: &ViscoelasticContact, path: &[(Load, f64)], tolerance: f64) -> Vec<ViscoelasticState> {
    let mut states: Vec<ViscoelasticState> = Vec::new();
    for (load, time) in path {
        let press = contact.press(Drive::from(*load).at(*time)).tolerance(tolerance);
        states.push(press.starting_from(states.last()).solve().unwrap());
    }
    states
}

/// Divides each leg of a path into equal steps; a leg of zero duration is one step. The first leg begins at zero.
fn legs(values: &[f64], times: &[f64], steps: usize, load: fn(f64) -> Load) -> Vec<(Load, f64)> {
    let (mut path, mut before, mut start) = (Vec::new(), 0.0, 0.0);
    for (leg, time) in times.iter().enumerate() {
        let value = values[leg.min(values.len() - 1)];
        let count = if *time == 0.0 { 1 } else { steps };
        for step in 1..=count {
            let share = step as f64 / count as f64;
            path.push((load(before + share * (value - before)), start + share * time));
        }
        (before, start) = (value, start + time);
    }
    path
}
