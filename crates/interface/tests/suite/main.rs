//! Tests of `gfmd-interface` as one program. `cargo test -p gfmd-interface --test suite FILE::` runs one file.

mod adhesion;
mod checkpoint;
mod cohesive;
mod combined;
mod composed;
mod cost;
mod free;
mod free_shear;
mod friction;
mod gradient;
mod kinks;
mod path;
mod plastic;
mod ranks;
mod relaxing;
mod small_loads;
mod squeezed;
mod stiffness;
mod wear;

use gfmd_contact::{Boundary, Fields as _};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Parts, QuasistaticContact, QuasistaticState};
use gfmd_law::Limit;
use ndarray::Array2;
use serde_json::Value;

/// Generator of random numbers between 0 and 1.
struct Numbers(u64);

impl Numbers {
    /// Returns the generator of a small seed.
    fn of(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1))
    }

    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Returns heights of about 0.02: a few waves with random phases.
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

/// Returns the contact with friction at a hard wall.
fn rubbing(boundary: Boundary, body: &Body, grid: &Grid, heights: &Array2<f64>, limit: Limit) -> QuasistaticContact {
    let shear = Some(limit.into());
    QuasistaticContact::new(&Parts { boundary, shear, ..Parts::new(body, grid, heights) }).unwrap()
}

/// Returns all components of the traction on the elastic surface, one after the other.
fn traction(state: &QuasistaticState) -> Vec<f64> {
    let lateral = (0..2).filter_map(|axis| state.shear(axis)).flat_map(|shear| shear.into_iter().copied());
    lateral.chain(state.pressure().iter().map(|p| -p)).collect()
}

/// Divides each leg of a path into equal steps. A leg without duration (or distance) is one step. The first leg begins
/// at zero.
fn legs<L>(values: &[f64], durations: &[f64], steps: usize, load: fn(f64) -> L) -> Vec<(L, f64)> {
    let (mut path, mut before, mut start) = (Vec::new(), 0.0, 0.0);
    for (leg, duration) in durations.iter().enumerate() {
        let value = values[leg.min(values.len() - 1)];
        let count = if *duration == 0.0 { 1 } else { steps };
        for step in 1..=count {
            let share = step as f64 / count as f64;
            path.push((load(before + share * (value - before)), start + share * duration));
        }
        (before, start) = (value, start + duration);
    }
    path
}

/// Returns the numbers of a JSON array.
fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}
