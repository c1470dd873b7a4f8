//! Loads so small that the roughness or the tractions of a law hide them: flat tops, where all fields are proportional
//! to the load, and contact by a law without traction far away.

use gfmd_contact::{Boundary, Contact, Drive, Equilibrium, Fields, Load, Refusal, SolveError};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::Interface;
use gfmd_law::{Dugdale, Exponential, HardWall, Limit, Morse};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

use crate::{rubbing, traction};

fn half_space(nu: f64) -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, nu).unwrap())
}

/// Returns a disc of radius 0.3 that protrudes by 0.1.
fn disc(n: usize) -> (Grid, Array2<f64>) {
    let at = |i: usize| i as f64 / n as f64 - 0.5;
    let heights = Array2::from_shape_fn((n, n), |(i, j)| if at(i).hypot(at(j)) <= 0.3 { 0.1 } else { 0.0 });
    (Grid::square(n, 1.0).unwrap(), heights)
}

fn sphere(n: usize) -> (Grid, Array2<f64>) {
    let at = |i: usize| (i as f64 / n as f64 - 0.5).powi(2);
    (Grid::square(n, 1.0).unwrap(), Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (at(i) + at(j))))
}

/// Returns the largest difference divided by the largest value.
fn apart<'a>(found: impl IntoIterator<Item = &'a f64>, expected: impl IntoIterator<Item = &'a f64>) -> f64 {
    let (mut most, mut largest) = (0.0_f64, 0.0_f64);
    for (a, b) in found.into_iter().zip(expected) {
        (most, largest) = (most.max((a - b).abs()), largest.max(b.abs()));
    }
    most / largest
}

/// The reference is the pressure under a load resolved by h_rms, divided by the load.
#[test]
fn a_wall_alone_carries_a_small_load_on_a_flat_top() {
    let (grid, heights) = disc(32);
    let contact = Contact::new(&half_space(0.3), &grid, &heights).unwrap();
    let fixed = contact.press(Load::MeanPressure(1e-2)).tolerance(1e-12).solve().unwrap().pressure / 1e-2;
    let interface = Interface::new(&half_space(0.3), &grid, &heights, HardWall).unwrap();
    for mean in [1e-4, 1e-6, 2e-8] {
        let state = interface.press(Load::MeanPressure(mean)).solve().unwrap();
        let error = apart(&(state.pressure().into_owned() / mean), &fixed);
        assert!(error < 1e-4, "{mean:e}: {error:e}");
        let moved = interface.press(Load::Approach(state.approach)).solve().unwrap();
        let error = apart(&(moved.pressure().into_owned() / mean), &fixed);
        assert!(error < 1e-3, "{mean:e}, approach: {error:e}");
    }
}

#[test]
fn friction_under_a_small_load_is_that_under_a_large_one() {
    let (grid, heights) = disc(24);
    let contact = rubbing(Boundary::Periodic, &half_space(0.2), &grid, &heights, Limit::Coulomb(0.3));
    let tractions = |mean: f64| {
        let pressed = contact.press(Load::MeanPressure(mean)).solve().unwrap();
        let drive = Drive { load: Load::MeanPressure(mean), lateral: [0.3 * mean, 0.0], time: 0.0, distance: 0.0 };
        let sheared = contact.press(drive).starting_from(Some(&pressed)).solve().unwrap();
        [sheared, pressed].map(|state| traction(&state).into_iter().map(|t| t / mean).collect::<Vec<f64>>())
    };
    let expected = tractions(1e-3);
    for mean in [1e-6, 1e-8, 1e-10] {
        for (found, expected) in tractions(mean).iter().zip(&expected) {
            let error = apart(found, expected);
            assert!(error < 1e-3, "{mean:e}: {error:e}");
        }
    }
}

/// On a flat top all fields are proportional to the approach.
#[test]
fn friction_at_a_small_approach_is_that_at_a_large_one() {
    let (grid, heights) = disc(24);
    let contact = rubbing(Boundary::Periodic, &half_space(0.2), &grid, &heights, Limit::Coulomb(0.3));
    let tractions = |approach: f64| {
        let pressed = contact.press(Load::Approach(approach)).solve().unwrap();
        let lateral = [0.1 * approach, 0.0];
        let drive = Drive { load: Load::Approach(approach), lateral, time: 0.0, distance: 0.0 };
        let sheared = contact.press(drive).starting_from(Some(&pressed)).solve().unwrap();
        [sheared, pressed].map(|state| traction(&state).into_iter().map(|t| t / approach).collect::<Vec<f64>>())
    };
    let expected = tractions(1e-2);
    for approach in [1e-5, 1e-6, 1e-9, 1e-30] {
        for (found, expected) in tractions(approach).iter().zip(&expected) {
            let error = apart(found, expected);
            assert!(error < 1e-3, "{approach:e}: {error:e}");
        }
    }
}

/// Morse's law repels at negative gaps; far away it vanishes, and tractions are rounding errors.
#[test]
fn rounding_errors_far_from_contact_are_no_contact() {
    let (grid, heights) = sphere(64);
    let interface = Interface::new(&half_space(0.0), &grid, &heights, Morse::new(1e-4, 2e-3).unwrap()).unwrap();
    for load in [1e-3, 1e-4, 0.0].map(Load::MeanPressure) {
        let state = interface.press(load).solve().unwrap();
        let repelled = state.gap.iter().filter(|gap| **gap < 0.0).count();
        assert!(repelled > 4 && repelled < 2000, "{load:?}: {repelled}");
        assert_eq!(state.summary().contact_nodes, repelled as u64, "{load:?}");
        // A certificate of the stored fields counts the same points.
        let again = interface.certify(&state.gap, &state.pressure(), load.into()).unwrap();
        assert_eq!(again.summary().contact_nodes, repelled as u64, "{load:?}, recomputed");
        assert!(again.repulsion().iter().zip(&state.gap).all(|(p, gap)| (*p > 0.0) == (*gap < 0.0)));
    }
}

#[test]
fn an_attraction_across_an_open_gap_is_no_contact() {
    let (grid, heights) = sphere(32);
    let law = Exponential::new(1e-4, 1e-2).unwrap();
    let interface = Interface::new(&half_space(0.0), &grid, &heights, law).unwrap();
    let state = interface.press(Load::Approach(-0.05)).solve().unwrap();
    assert!(state.gap.iter().all(|gap| *gap > 0.0) && state.mean_pressure < 0.0);
    assert_eq!(state.summary().contact_nodes, 0);
}

#[test]
fn a_load_that_the_tractions_hide_is_refused() {
    let (grid, heights) = sphere(32);
    let interface = Interface::new(&half_space(0.0), &grid, &heights, Dugdale::new(2e-4, 1e-2).unwrap()).unwrap();
    for mean in [2e-13, -2e-13, 1e-11] {
        match interface.press(Load::MeanPressure(mean)).solve() {
            Err(SolveError::Refused(Refusal::LoadBelowTractionRounding { found, least, traction })) => {
                assert!(found == mean, "{mean:e} {least:e}");
                assert!(mean.abs() < least, "{mean:e} {least:e}");
                assert!(least == 1e-8 * traction, "{mean:e} {least:e}");
                let message = Refusal::LoadBelowTractionRounding { found, least, traction }.to_string();
                assert!(message.contains("must be 0, or at least") && !message.contains('\n'), "{message}");
            }
            other => panic!("{mean:e}: {:?}", other.map(|state| state.residual)),
        }
    }
    // Zero, and the middle of a loop, which is zero within rounding.
    for mean in [0.0, 1e-19, 1e-5] {
        assert!(interface.press(Load::MeanPressure(mean)).solve().is_ok(), "{mean:e}");
    }
}

/// The reference is the pressure solver.
#[test]
fn a_wall_at_a_prescribed_approach_takes_few_steps() {
    let grid = Grid::square(96, 1.0).unwrap();
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 6.0, eps_c_inv: 8.0 };
    let spectrum = numbers.self_affine(1.0, SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) });
    let load = Load::Approach(0.0063);
    for seed in 100..124 {
        let heights = spectrum.heights(&grid, seed).unwrap();
        let body = half_space(if seed % 2 == 0 { 0.0 } else { 0.5 });
        let expected = Contact::new(&body, &grid, &heights).unwrap().press(load).solve().unwrap();
        let interface = Interface::new(&body, &grid, &heights, HardWall).unwrap();
        let found = interface.press(load).max_iterations(50).solve().unwrap_or_else(|error| panic!("{seed}: {error}"));
        assert!((found.mean_pressure / expected.mean_pressure - 1.0).abs() < 1e-6, "{seed}");
    }
}
