//! Bodies that relax.

mod checkpoint;
mod closed_forms;
mod energy;
mod input;
mod lateral;
mod law;
mod reference;
mod sliding;

use gfmd_contact::{Boundary, Drive, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Parts, QuasistaticContact, QuasistaticState};
use gfmd_medium::{Prony, Relaxes};
use ndarray::Array2;

/// Returns a material with three branches.
fn three() -> Prony {
    Prony::from_fractions(&[(0.05, 0.3), (0.7, 0.25), (6.0, 0.2)]).unwrap()
}

fn one() -> Prony {
    Prony::from_fractions(&[(1.3, 0.6)]).unwrap()
}

fn relaxing(body: &Body, grid: &Grid, heights: &Array2<f64>, prony: &Prony, relaxes: Relaxes) -> QuasistaticContact {
    on(Boundary::Periodic, body, grid, heights, prony, relaxes)
}

fn on(
    boundary: Boundary,
    body: &Body,
    grid: &Grid,
    heights: &Array2<f64>,
    prony: &Prony,
    relaxes: Relaxes,
) -> QuasistaticContact {
    let relaxation = Some((prony, relaxes));
    QuasistaticContact::new(&Parts { boundary, relaxation, ..Parts::new(body, grid, heights) }).unwrap()
}

/// Follows a path of loads, each with its time since the start.
fn follow(contact: &QuasistaticContact, path: &[(Load, f64)], tolerance: f64) -> Vec<QuasistaticState> {
    let mut states: Vec<QuasistaticState> = Vec::new();
    for (load, time) in path {
        let press = contact.press(Drive::from(*load).at(*time)).tolerance(tolerance);
        states.push(press.starting_from(states.last()).solve().unwrap());
    }
    states
}
