//! Steady sliding: dense solutions, closed forms, and time stepping to the same state.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use gfmd_contact::{Boundary, Budget, Contact, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use gfmd_medium::{Prony, Relaxes, SlidingContact, SlidingError, SlidingState, Velocity};
use ndarray::Array2;
use serde_json::Value;

use crate::numbers;
use crate::{material, one, rough, three};

fn sliding(body: &Body, grid: &Grid, heights: &Array2<f64>, prony: &Prony, relaxes: Relaxes) -> SlidingContact {
    SlidingContact::new(Contact::new(body, grid, heights).unwrap(), body, prony, relaxes).unwrap()
}

fn slide(contact: &SlidingContact, speed: f64, degrees: f64, load: Load, tolerance: f64) -> SlidingState {
    let budget = Budget { tolerance, ..Budget::default() };
    contact.slide(&Velocity::new(speed, degrees).unwrap(), load, &budget, None, &mut ()).unwrap()
}

#[test]
fn every_state_has_the_values_of_dense_solutions() {
    let text = include_str!("../../../../data/reference/viscoelastic/slide.json");
    let all: Value = serde_json::from_str(text).unwrap();
    for problem in all["problems"].as_array().unwrap() {
        let name = problem["name"].as_str().unwrap();
        let of = |key: &str| problem[key].as_f64().unwrap();
        let (shape, lengths) = (numbers(&problem["shape"]), numbers(&problem["length"]));
        let [nx, ny] = [shape[0] as usize, shape[1] as usize];
        let grid = match ny {
            1 => Grid::line(nx, lengths[0]).unwrap(),
            _ => Grid::new([nx, ny], [lengths[0], lengths[1]]).unwrap(),
        };
        let rows: Vec<f64> = problem["heights"].as_array().unwrap().iter().flat_map(numbers).collect();
        let heights = Array2::from_shape_vec((nx, ny), rows).unwrap();
        let pairs: Vec<(f64, f64)> =
            problem["prony"].as_array().unwrap().iter().map(numbers).map(|pair| (pair[0], pair[1])).collect();
        let material = Material::from_young(of("young"), of("poisson")).unwrap();
        let body = match problem["height"].as_f64() {
            Some(height) => Body::slab(material, height).unwrap(),
            None => Body::half_space(material),
        };
        let load = if problem["control"] == "pressure" { Load::MeanPressure } else { Load::Approach };
        let relaxes = problem["relaxes"].as_str().unwrap().parse().unwrap();
        let contact = sliding(&body, &grid, &heights, &Prony::from_fractions(&pairs).unwrap(), relaxes);
        for known in problem["results"].as_array().unwrap() {
            let speed = known["velocity"].as_f64().unwrap();
            let state = slide(&contact, speed, of("direction"), load(of("value")), 1e-11);
            let velocity = Velocity::new(speed, of("direction")).unwrap();
            let persson = contact.persson(&velocity, state.solution.mean_pressure);
            let summary = state.summary();
            for (key, found) in [
                ("mean_pressure", state.solution.mean_pressure),
                ("approach", state.solution.approach),
                ("area_fraction", summary.area_fraction),
                ("mean_gap", summary.mean_gap),
                ("max_pressure", summary.max_pressure),
                ("dissipated_power", state.dissipated_power),
                ("friction", state.friction),
                ("friction_slope", state.friction_slope),
                ("persson_friction", persson.friction),
                ("persson_area", persson.area_fraction),
            ] {
                let known = known[key].as_f64().unwrap();
                let apart = (found - known).abs() / known.abs().max(1e-3);
                assert!(apart <= 1e-8, "{name} at {speed}: {key} is {found:e}, not {known:e} ({apart:.1e})");
            }
        }
    }
}

#[test]
fn a_wave_in_full_contact_has_its_closed_form() {
    let (n, amplitude, k) = (48, 0.01, TAU);
    let grid = Grid::line(n, 1.0).unwrap();
    let wave = |i: usize| (k * i as f64 / n as f64).cos();
    let heights = Array2::from_shape_fn((n, 1), |(i, _)| amplitude * wave(i));
    let body = Body::half_space(material(0.3));
    let contact = sliding(&body, &grid, &heights, &three(), Relaxes::Both);
    let stiffness = 0.5 * material(0.3).contact_modulus() * k;
    for speed in [0.01, 0.3, 5.0] {
        let modulus = three().modulus(k * speed);
        let least = amplitude * stiffness * modulus.norm();
        let state = slide(&contact, speed, 0.0, Load::MeanPressure(1.2 * least), 1e-12);
        let friction = 0.5 * amplitude * amplitude * k * stiffness * modulus.im / (1.2 * least);
        assert_relative_eq!(state.friction, friction, max_relative = 1e-10);
        assert_relative_eq!(state.friction_slope, friction, max_relative = 1e-9);
        // The pressure leads: its peak is ahead of the summit.
        let expected = |i: usize| {
            let x = k * i as f64 / n as f64;
            1.2 * least + amplitude * stiffness * (modulus.re * x.cos() + modulus.im * x.sin())
        };
        let worst = (0..n).map(|i| (state.solution.pressure[[i, 0]] - expected(i)).abs()).fold(0.0, f64::max);
        assert!(worst <= 1e-10 * least, "{worst:e}");
    }
}

#[test]
fn very_slow_and_very_fast_sliding_are_statics() {
    let grid = Grid::line(32, 1.0).unwrap();
    let heights = rough(&grid, 3);
    let half_space = |young: f64| Body::half_space(Material::from_young(young, 0.35).unwrap());
    let contact = sliding(&half_space(2.0), &grid, &heights, &three(), Relaxes::Both);
    let load = Load::MeanPressure(0.1);
    for (speed, young) in [(1e-7, 2.0), (1e7, 8.0)] {
        let fixed = Contact::new(&half_space(young), &grid, &heights).unwrap();
        let fixed = fixed.press(load).tolerance(1e-11).solve().unwrap();
        let state = slide(&contact, speed, 0.0, load, 1e-11);
        assert_relative_eq!(state.solution.approach, fixed.approach, max_relative = 1e-5);
        assert_eq!(state.summary().contact_nodes, fixed.summary().contact_nodes);
        assert!(state.friction > 0.0 && state.friction < 1e-5);
    }
}

#[test]
fn rough_sliding_is_found_at_any_loss_from_the_state_beside_it() {
    let grid = Grid::square(32, 1.0).unwrap();
    let heights = rough(&grid, 7);
    let body = Body::half_space(material(0.5));
    let seven: Vec<(f64, f64)> = (0..7).map(|k| (10.0_f64.powi(k - 4), 0.999 / 7.0)).collect();
    for (prony, name) in [(one(), "one"), (three(), "three"), (Prony::from_fractions(&seven).unwrap(), "seven")] {
        let contact = sliding(&body, &grid, &heights, &prony, Relaxes::Both);
        let fixed = contact.contact().press(Load::MeanPressure(0.02)).solve().unwrap();
        let mut last: Option<SlidingState> = None;
        for exponent in -3..=3 {
            let velocity = Velocity::new(10.0_f64.powi(exponent), 25.0).unwrap();
            let budget = Budget::default();
            let state = contact.slide(&velocity, Load::MeanPressure(0.02), &budget, last.as_ref(), &mut ()).unwrap();
            assert!(state.worst() <= 1e-8 && state.friction > 0.0, "{name}");
            let pairs = state.effort().transform_pairs / fixed.effort.transform_pairs;
            // With a loss of nearly all of the modulus, the contact of each step is difficult.
            assert!(pairs <= 16.0 || name == "seven", "{name} at 1e{exponent}: {pairs} times the static pairs");
            last = Some(state);
        }
    }
}

/// The contact of a single point is linear.
#[test]
fn a_small_approach_makes_contact() {
    let grid = Grid::square(16, 1.0).unwrap();
    let heights = rough(&grid, 3);
    for (poisson, height) in [(0.5, Height::Infinite), (0.4, Height::Finite(0.3))] {
        let body = Body::new(material(poisson), height).unwrap();
        let contact = sliding(&body, &grid, &heights, &three(), Relaxes::Both);
        let stiffness = |approach: f64, tolerance: f64| {
            let state = slide(&contact, 0.5, 10.0, Load::Approach(approach), tolerance);
            state.solution.mean_pressure / approach
        };
        let expected = stiffness(1e-7, 1e-10);
        for (approach, tolerance) in [(1e-6, 1e-8), (1e-9, 1e-8), (1e-9, 1e-4), (1e-15, 1e-6), (1e-30, 1e-8)] {
            let found = stiffness(approach, tolerance);
            // Residuals are relative to a thousand times the displacement.
            assert!(
                (found / expected - 1.0).abs() < (1e3 * tolerance).max(1e-3),
                "{approach:e} {tolerance:e}: {found:e} {expected:e}"
            );
        }
    }
}

#[test]
fn an_oblique_velocity_costs_as_one_along_an_axis() {
    // The storage moduli of an oblique velocity are not even along x; no solver may assume that they are.
    let grid = Grid::square(128, 1.0).unwrap();
    let heights = rough(&grid, 7);
    let body = Body::half_space(material(0.5));
    let contact = sliding(&body, &grid, &heights, &Prony::from_fractions(&[(1.0, 0.9)]).unwrap(), Relaxes::Both);
    let pairs = |degrees: f64| slide(&contact, 0.1, degrees, Load::MeanPressure(0.02), 1e-8).effort().transform_pairs;
    let [along, oblique] = [0.0, 30.0].map(pairs);
    assert!(oblique < 4.0 * along && oblique < 1000.0, "{along} {oblique}");
}

#[test]
fn unusable_input_is_refused() {
    for speed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Velocity::new(speed, 0.0).unwrap_err().to_string().ends_with("it must be positive and finite"));
    }
    assert_eq!(
        Velocity::new(1.0, f64::NAN).unwrap_err().to_string(),
        "the direction is NaN degrees; it must be finite"
    );
    let grid = Grid::square(8, 1.0).unwrap();
    let body = Body::half_space(material(0.3));
    let free = Contact::with_boundary(Boundary::Free, &body, &grid, &rough(&grid, 1)).unwrap();
    let refused = SlidingContact::new(free, &body, &one(), Relaxes::Both);
    assert!(matches!(refused, Err(SlidingError::Free)));
}
