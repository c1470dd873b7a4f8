//! Exact solutions: waves in full contact, a flat punch, and the state after running-in.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use gfmd_contact::{Boundary, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use ndarray::{Array2, ArrayRef2};

use super::{follow, held, on, wearing};
use crate::{material, rough};

/// Returns the order of convergence from two errors; the second has steps of a quarter of the length.
fn order([coarse, fine]: [f64; 2]) -> f64 {
    0.5 * (coarse / fine).log2()
}

#[test]
fn waves_in_full_contact_decay_exponentially_with_order_one() {
    // p(q, s) = p(q, 0) exp(−k S(q) s): two waves, on a half-space and on a slab.
    let grid = Grid::square(16, 1.0).unwrap();
    let place = |i: usize| TAU * i as f64 / 16.0;
    let heights =
        Array2::from_shape_fn((16, 16), |(i, j)| 1e-3 * place(i).cos() + 5e-4 * (2.0 * place(i) + place(j)).cos());
    for (body, coefficient) in [(Body::half_space(material(0.3)), 0.4), (Body::slab(material(0.3), 0.2).unwrap(), 0.3)]
    {
        let contact = wearing(&body, &grid, &heights, coefficient);
        let load = Load::MeanPressure(0.03);
        let start = follow(&contact, &[(load, 0.0)], 1e-12).pop().unwrap();
        let amplitude = |p: &ArrayRef2<f64>, m: f64, n: f64| {
            let wave = p.indexed_iter().map(|((i, j), p)| p * (m * place(i) + n * place(j)).cos());
            wave.sum::<f64>() / 128.0
        };
        let error = |steps: u32| {
            let end = follow(&contact, &held(load, 0.5, steps), 1e-12).pop().unwrap();
            assert_eq!(end.summary().area_fraction, 1.0);
            let apart = |m: f64, n: f64| {
                let stiffness = body.normal_stiffness(TAU * m.hypot(n));
                let exact = amplitude(&start.pressure(), m, n) * (-coefficient * stiffness * 0.5).exp();
                let discrete = (1.0 + coefficient * stiffness * 0.5 / f64::from(steps)).powi(-(steps as i32));
                let found = amplitude(&end.pressure(), m, n);
                // Each step divides the amplitude by 1 + k Δs S.
                assert_relative_eq!(found, amplitude(&start.pressure(), m, n) * discrete, max_relative = 1e-8);
                (found / exact - 1.0).abs()
            };
            apart(1.0, 0.0).max(apart(2.0, 1.0))
        };
        let order = order([16, 64].map(error));
        assert!((0.9..1.1).contains(&order), "order {order}");
    }
}

#[test]
fn a_flat_punch_wears_until_its_pressure_is_uniform() {
    let grid = Grid::line(64, 1.0).unwrap();
    // The surface beside the punch is too deep to touch.
    let heights = Array2::from_shape_fn((64, 1), |(i, _)| if (22..42).contains(&i) { 0.5 } else { 0.0 });
    let body = Body::half_space(material(0.3));
    let contact = wearing(&body, &grid, &heights, 0.05);
    let load = Load::MeanPressure(0.02);
    let mean = 0.02 * 64.0 / 20.0;
    let edge = |steps: u32, distance: f64| {
        let end = follow(&contact, &held(load, distance, steps), 1e-11).pop().unwrap();
        assert_eq!(end.summary().contact_nodes, 20);
        end.pressure()[[22, 0]] / mean
    };
    let unworn = follow(&contact, &[(load, 0.0)], 1e-11).pop().unwrap();
    assert!(unworn.pressure()[[22, 0]] > 1.7 * mean);
    let errors = [8, 32, 128].map(|steps| edge(steps, 1.0));
    let order = 0.5 * ((errors[0] - errors[1]) / (errors[1] - errors[2])).log2();
    assert!((0.9..1.2).contains(&order), "order {order}, {errors:?}");
    assert_relative_eq!(edge(40, 60.0), 1.0, max_relative = 1e-7);
}

#[test]
fn every_rough_surface_runs_in_to_full_contact_with_a_uniform_pressure() {
    let grid = Grid::square(16, 1.0).unwrap();
    for (seed, body, boundary) in [
        (1, Body::half_space(material(0.3)), Boundary::Periodic),
        (2, Body::slab(material(0.3), 0.2).unwrap(), Boundary::Periodic),
        (3, Body::half_space(material(0.3)), Boundary::Free),
        (4, Body::slab(material(0.3), 0.2).unwrap(), Boundary::Free),
    ] {
        let contact = on(boundary, &body, &grid, &rough(&grid, seed), 0.2);
        let states = follow(&contact, &held(Load::MeanPressure(0.004), 4000.0, 40), 1e-8);
        let (first, last) = (states[0].summary(), states[40].summary());
        assert!(first.area_fraction < 0.2 && last.area_fraction == 1.0, "{seed}");
        assert_relative_eq!(last.max_pressure, 0.004, max_relative = 1e-5);
        let areas: Vec<f64> = states.iter().map(|state| state.summary().area_fraction).collect();
        assert!(areas.windows(2).all(|pair| pair[1] >= pair[0]), "{seed}: {areas:?}");
    }
}

#[test]
fn a_held_approach_wears_until_hardly_anything_touches() {
    let grid = Grid::square(16, 1.0).unwrap();
    let body = Body::half_space(material(0.3));
    let contact = wearing(&body, &grid, &rough(&grid, 5), 0.3);
    let states = follow(&contact, &held(Load::Approach(0.01), 3.0, 20), 1e-10);
    assert!(states.windows(2).all(|pair| pair[1].mean_pressure() < pair[0].mean_pressure()));
    assert!(states[20].mean_pressure() < 0.05 * states[0].mean_pressure());
    let end = follow(&contact, &held(Load::Approach(0.01), 1e3, 20), 1e-10).pop().unwrap();
    assert!(end.mean_pressure() < 1e-8 * states[0].mean_pressure());
    // Beyond the mean clearance, which unworn surfaces cannot reach.
    let deep = contact.surface().mean_clearance() + 0.1;
    let pressed = follow(&contact, &[(Load::Approach(deep), 1.0)], 1e-10).pop().unwrap();
    assert_eq!(pressed.summary().area_fraction, 1.0);
    // Drawn back until the worn surfaces are apart, then pressed until they touch again.
    let path = [(Load::Approach(0.01), 50.0), (Load::Approach(0.001), 60.0), (Load::Approach(0.01), 60.0)];
    let drawn = follow(&contact, &path, 1e-10);
    assert_eq!((drawn[1].summary().contact_nodes, drawn[1].losses.total()), (0, 0.0));
    assert_eq!(drawn[1].wear_depth(), drawn[0].wear_depth());
    assert!(drawn[2].mean_pressure() > 0.0);
}
