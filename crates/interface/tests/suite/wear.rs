//! Surfaces that wear.

mod balance;
mod checkpoint;
mod closed_forms;
mod input;
mod reference;

use gfmd_contact::{Boundary, Drive, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Parts, QuasistaticContact, QuasistaticState, Wear};
use ndarray::Array2;

/// Returns wear by the distance of the drives alone.
fn by_distance(coefficient: f64) -> Option<Wear> {
    Some(Wear { by_distance: coefficient, by_slip: 0.0 })
}

fn wearing(body: &Body, grid: &Grid, heights: &Array2<f64>, coefficient: f64) -> QuasistaticContact {
    on(Boundary::Periodic, body, grid, heights, coefficient)
}

fn on(boundary: Boundary, body: &Body, grid: &Grid, heights: &Array2<f64>, coefficient: f64) -> QuasistaticContact {
    let wear = by_distance(coefficient);
    QuasistaticContact::new(&Parts { boundary, wear, ..Parts::new(body, grid, heights) }).unwrap()
}

/// Solves for the loads of a path, each with its sliding distance.
fn follow(contact: &QuasistaticContact, path: &[(Load, f64)], tolerance: f64) -> Vec<QuasistaticState> {
    let mut states: Vec<QuasistaticState> = Vec::new();
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
