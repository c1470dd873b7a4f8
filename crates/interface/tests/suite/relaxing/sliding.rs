//! Time stepping to the steady state of a surface that slides.

use std::f64::consts::TAU;

use gfmd_contact::{Budget, Contact, Drive, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_medium::{Prony, Relaxes, SlidingContact, Velocity};
use ndarray::Array2;

use super::relaxing;
use crate::{material, rough};

/// Shifts the heights of a profile by the fraction `share` of the cell length.
fn shifted(grid: &Grid, heights: &Array2<f64>, share: f64) -> Array2<f64> {
    let n = grid.points()[0];
    let wave = |m: i64| {
        let sum = (0..n).map(|i| {
            let angle = -TAU * (m * i as i64) as f64 / n as f64;
            [heights[[i, 0]] * angle.cos(), heights[[i, 0]] * angle.sin()]
        });
        sum.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
    };
    let top = (n as i64 - 1) / 2;
    let waves: Vec<(i64, [f64; 2])> = (-top..=top).map(|m| (m, wave(m))).collect();
    Array2::from_shape_fn((n, 1), |(i, _)| {
        let of = |(m, [re, im]): &(i64, [f64; 2])| {
            let angle = TAU * *m as f64 * (i as f64 / n as f64 - share);
            (re * angle.cos() - im * angle.sin()) / n as f64
        };
        waves.iter().map(of).sum()
    })
}

#[test]
fn a_march_through_time_comes_to_the_steady_state() {
    // In full contact no grid point is out of contact: time stepping converges with order two in the step.
    let n = 15;
    let grid = Grid::line(n, 1.0).unwrap();
    let heights = rough(&grid, 5);
    let body = Body::slab(material(0.3), 0.4).unwrap();
    let (prony, speed, load) = (Prony::from_fractions(&[(0.3, 0.5)]).unwrap(), 0.8, Load::MeanPressure(3.0));
    let elastic = Contact::new(&body, &grid, &heights).unwrap();
    let contact = SlidingContact::new(elastic, &body, &prony, Relaxes::Both).unwrap();
    let (velocity, budget) = (Velocity::new(speed, 0.0).unwrap(), Budget { tolerance: 1e-12, ..Budget::default() });
    let steady = contact.slide(&velocity, load, &budget, None, &mut ()).unwrap();
    assert_eq!(steady.summary().area_fraction, 1.0);
    let march = |steps_of_cell: usize| {
        let mut state = None;
        let cells = 12;
        for step in 0..=cells * steps_of_cell {
            let share = step as f64 / steps_of_cell as f64;
            let contact = relaxing(&body, &grid, &shifted(&grid, &heights, share), &prony, Relaxes::Both);
            let press = contact.press(Drive::from(load).at(share / speed)).tolerance(1e-12);
            state = Some(press.starting_from(state.as_ref()).solve().unwrap());
        }
        let state = state.unwrap();
        (&state.pressure() - &steady.pressure()).iter().fold(0.0, |most: f64, p| most.max(p.abs()))
    };
    let [coarse, fine] = [60, 120].map(march);
    let order = (coarse / fine).log2();
    assert!((1.8..2.2).contains(&order) && fine < 0.05, "order {order}: {coarse:e}, {fine:e}");
}
