//! Units from 1e-200 to 1e200, loads from hardly any contact to far beyond full contact.

use gfmd_contact::{Contact, Equilibrium, Fields, Load, Refusal, Solution, SolveError, Solver, SteepContact};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use ndarray::Array2;

use super::long;

const METHODS: [Solver; 9] = [
    Solver::PolonskyKeer,
    Solver::ProjectedCg,
    Solver::PreconditionedCg,
    Solver::Verlet,
    Solver::VerletCritical,
    Solver::VerletModes,
    Solver::Fire,
    Solver::Fire2,
    Solver::AugmentedLagrangian,
];

fn heights(grid: &Grid, size: f64) -> Array2<f64> {
    Array2::from_shape_fn(grid.points(), |(i, j)| {
        let (x, y) = (i as f64 * 0.39, j as f64 * 0.39);
        size * (x.cos() * y.cos()
            + 0.3 * (3.0 * x + 1.0).cos() * (2.0 * y).sin()
            + 0.001 * ((7 * i + 3 * j) % 5) as f64)
    })
}

/// Makes a contact in units with modulus, lengths along the surface and heights larger by these factors.
fn contact(height: Height, modulus: f64, lateral: f64, normal: f64) -> Contact {
    let grid = Grid::square(16, lateral).unwrap();
    let height = match height {
        Height::Finite(height) => Height::Finite(height * lateral),
        Height::Infinite => Height::Infinite,
    };
    let body = Body::new(Material::from_contact_modulus(modulus, 0.3).unwrap(), height).unwrap();
    Contact::new(&body, &grid, &heights(&grid, 0.01 * normal)).unwrap()
}

/// Returns fields and numbers without their units.
fn reduced(solution: &Solution, stress: f64, length: f64) -> Vec<f64> {
    let mut all: Vec<f64> = solution.pressure.iter().map(|p| p / stress).collect();
    all.extend(solution.gap.iter().chain(&solution.displacement).map(|u| u / length));
    all.extend([solution.mean_pressure / stress, solution.approach / length]);
    all
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

#[test]
fn powers_of_two_in_the_units_change_no_bit() {
    for height in [Height::Infinite, Height::Finite(0.3)] {
        for solver in METHODS {
            let solve = |contact: &Contact, load| contact.press(load).solver(solver).tolerance(1e-6).solve().unwrap();
            let plain = solve(&contact(height, 1.0, 1.0, 1.0), Load::MeanPressure(0.005));
            let expected = reduced(&plain, 1.0, 1.0);
            for (modulus, lateral) in
                [(-660, 0), (660, 0), (0, -330), (0, 330), (500, 400), (-400, -300), (90, -90), (-500, 300)]
            {
                let [modulus, lateral] = [modulus, lateral].map(|exponent| 2.0_f64.powi(exponent));
                let scaled = solve(&contact(height, modulus, lateral, lateral), Load::MeanPressure(0.005 * modulus));
                let found = reduced(&scaled, modulus, lateral);
                let same = found.iter().zip(&expected).all(|(a, b)| a == b);
                assert!(same, "{solver} {height:?} {modulus:e} {lateral:e}: {:e}", apart(&found, &expected));
                assert_eq!(scaled.residual, plain.residual);
            }
        }
    }
}

#[test]
fn the_reduced_result_is_the_same_in_all_units() {
    let press = |modulus: f64, lateral: f64, normal: f64| {
        let stress = modulus * (normal / lateral);
        let contact = contact(Height::Finite(0.3), modulus, lateral, normal);
        let solution = contact.press(Load::MeanPressure(0.005 * stress)).tolerance(1e-14).solve().unwrap();
        reduced(&solution, stress, normal)
    };
    let expected = press(1.0, 1.0, 1.0);
    for exponent in (-200..=200).step_by(25) {
        let modulus = 10.0_f64.powi(exponent);
        for (lateral, normal) in [(-100, -100), (-100, -90), (-50, -50), (0, 0), (30, 20), (75, 75), (100, 90)] {
            let (lateral, normal) = (10.0_f64.powi(lateral), 10.0_f64.powi(normal));
            let apart = apart(&press(modulus, lateral, normal), &expected);
            assert!(apart < 1e-12, "{modulus:e} {lateral:e} {normal:e}: {apart:e}");
        }
    }
}

/// Returns numbers without units, of contacts with all components (by one of its solvers) or with finite slopes.
fn with_all_components(solver: Option<Solver>, modulus: f64, lateral: f64) -> Vec<f64> {
    let grid = Grid::square(12, lateral).unwrap();
    let material = Material::from_contact_modulus(modulus, 0.3).unwrap();
    let body = Body::new(material, Height::Finite(0.3 * lateral)).unwrap();
    let heights = heights(&grid, 0.02 * lateral);
    let load = Load::MeanPressure(0.01 * modulus);
    let (normal, others, energy) = match solver {
        Some(solver) => {
            let contact = Contact::in_all_components(&body, &grid, &heights).unwrap();
            let press = contact.press(load).solver(solver).tolerance(1e-6).max_iterations(100_000);
            let state = press.solve().unwrap_or_else(|error| panic!("{solver} {modulus:e} {lateral:e}: {error}"));
            let energy = state.summary().elastic_energy;
            (state.clone(), state.lateral.unwrap().displacement, energy)
        }
        None => {
            let contact = SteepContact::new(&body, &grid, &heights).unwrap();
            let state = contact.press(load).tolerance(1e-8).solve();
            let state = state.unwrap_or_else(|error| panic!("{modulus:e} {lateral:e}: {error}"));
            let energy = state.summary().elastic_energy;
            (state.normal, state.lateral, energy)
        }
    };
    let mut all = reduced(&normal, modulus, lateral);
    all.extend(others.iter().flatten().map(|u| u / lateral));
    all.push(energy / modulus / lateral);
    all
}

/// Contacts with all components and with finite slopes have no units of their own: their numbers are homogeneous, and
/// no square of a modulus leaves the range of a number.
#[test]
fn lateral_components_and_finite_slopes_scale_with_the_units() {
    let grid = Grid::square(4, 1.0).unwrap();
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.3).unwrap());
    let any = Contact::in_all_components(&body, &grid, &heights(&grid, 0.02)).unwrap();
    for solver in any.solvers().iter().copied().map(Some).chain([None]) {
        let expected = with_all_components(solver, 1.0, 1.0);
        for [modulus, lateral] in [[430, 0], [-430, 0], [0, 300], [0, -300], [200, -150], [-200, 150], [210, 190]] {
            let [modulus, lateral] = [modulus, lateral].map(|exponent| 2.0_f64.powi(exponent));
            let found = with_all_components(solver, modulus, lateral);
            let same = found.iter().zip(&expected).all(|(a, b)| a == b);
            assert!(same, "{solver:?} {modulus:e} {lateral:e}: {:e}", apart(&found, &expected));
        }
        for modulus in [1e-130, 1e130] {
            let apart = apart(&with_all_components(solver, modulus, 1.0), &expected);
            assert!(apart < 1e-5, "{solver:?} {modulus:e}: {apart:e}");
        }
    }
}

#[test]
fn units_without_room_for_all_digits_are_refused() {
    let grid = Grid::square(16, 1.0).unwrap();
    let heights = heights(&grid, 0.01);
    for modulus in [1e-309, 1e-300, 1e300] {
        let body = Body::half_space(Material::from_contact_modulus(modulus, 0.3).unwrap());
        match Contact::new(&body, &grid, &heights) {
            Err(Refusal::Unit { .. }) => {}
            Err(refusal) => panic!("{modulus:e}: {refusal}"),
            Ok(_) => panic!("{modulus:e} was accepted"),
        }
    }
    let contact = contact(Height::Infinite, 1.0, 1.0, 1.0);
    for pressure in [5e-324, 1e-320, 1e-300] {
        let refused = contact.press(Load::MeanPressure(pressure)).solve();
        assert!(matches!(refused, Err(SolveError::Refused(Refusal::UnitOutOfRange { .. }))), "{pressure:e}");
    }
}

/// However small the approach, there is a contact, with the stiffness of a single point.
#[test]
fn a_small_positive_approach_makes_contact() {
    for height in [Height::Infinite, Height::Finite(0.3)] {
        let contact = contact(height, 1.0, 1.0, 1.0);
        let stiffness = |solver, approach: f64| {
            let press = contact.press(Load::Approach(approach)).solver(solver).max_iterations(20_000);
            press.solve().map(|solution| solution.mean_pressure / approach)
        };
        let expected = stiffness(Solver::Auto, 1e-7).unwrap();
        for solver in METHODS.into_iter().chain([Solver::Auto]) {
            for exponent in (-98..-20).step_by(13).chain((-20..-6).step_by(if long() { 1 } else { 6 })) {
                let approach = 10.0_f64.powi(exponent);
                match stiffness(solver, approach) {
                    Ok(found) => assert!((found / expected - 1.0).abs() < 0.02, "{solver} {approach:e}: {found:e}"),
                    // Dynamics takes longer for smaller loads, or cannot start.
                    Err(SolveError::NotConverged { .. } | SolveError::Refused(Refusal::Search(_)))
                        if solver != Solver::Auto => {}
                    Err(error) => panic!("{solver} {approach:e}: {error}"),
                }
            }
            for approach in [1e-320, 1e-300, 1e-150] {
                let refused = stiffness(solver, approach);
                assert!(
                    matches!(refused, Err(SolveError::Refused(Refusal::LoadUnderflows { .. }))),
                    "{solver} {approach:e}"
                );
            }
        }
    }
}

/// A surface without pressure would be within a loose tolerance.
#[test]
fn a_small_approach_makes_contact_at_any_tolerance() {
    for height in [Height::Infinite, Height::Finite(0.3)] {
        let contact = contact(height, 1.0, 1.0, 1.0);
        let stiffness = |tolerance, approach: f64| {
            let press = contact.press(Load::Approach(approach)).tolerance(tolerance);
            press.solve().map(|solution| solution.mean_pressure / approach)
        };
        let expected = stiffness(1e-8, 1e-7).unwrap();
        for tolerance in [1e-6, 1e-4, 1e-3, 1e-2] {
            for approach in [1e-6, 1e-9, 1e-15, 1e-30] {
                let found = stiffness(tolerance, approach);
                let found = found.unwrap_or_else(|error| panic!("{tolerance:e} {approach:e}: {error}"));
                assert!((found / expected - 1.0).abs() < 0.05, "{tolerance:e} {approach:e}: {found:e} {expected:e}");
            }
        }
    }
}

/// A load far beyond full contact is carried, or refused where rounding errors exceed the tolerance.
#[test]
fn large_loads_end() {
    for n in [8, 16] {
        for height in [1e-2, 1.0, 1e8, f64::INFINITY].map(Height::Finite) {
            let grid = Grid::square(n, 1.0).unwrap();
            let material = Material::from_contact_modulus(1.0, 0.3).unwrap();
            let body = Body::new(material, height).unwrap_or_else(|_| Body::half_space(material));
            let contact = Contact::new(&body, &grid, &heights(&grid, 0.01)).unwrap();
            let unit = contact.stiffness_range()[0] * contact.surface().rms_height();
            for solver in [Solver::Auto, Solver::PolonskyKeer, Solver::ProjectedCg, Solver::Verlet, Solver::Fire2] {
                for exponent in (0..10).chain([20, 30, 100, 280]) {
                    let load = unit * 10.0_f64.powi(exponent);
                    let beyond = 10.0_f64.powi(exponent) > 1e-8 / f64::EPSILON;
                    match contact.press(Load::MeanPressure(load)).solver(solver).max_iterations(3000).solve() {
                        Ok(solution) => assert!(!beyond && solution.residual.worst() <= 1e-8, "{solver} {load:e}"),
                        Err(SolveError::Refused(Refusal::Rounding { .. })) => assert!(beyond, "{solver} {load:e}"),
                        Err(error) => panic!("{n} {height:?} {solver} 1e{exponent}: {error}"),
                    }
                }
            }
        }
    }
}

/// A slab ten thousand times longer than wide: without the preconditioner conjugate gradients do not converge.
#[test]
fn the_default_method_converges_on_very_long_cells() {
    for aspect in [1e-4, 1.78e-4, 1e-2, 1e2, 1e4] {
        let grid = Grid::new([2, 32], [1.0, aspect]).unwrap();
        let body = Body::slab(Material::from_contact_modulus(1.0, -0.34).unwrap(), 1342.0).unwrap();
        let heights = Array2::from_shape_fn((2, 32), |(i, j)| {
            let y = j as f64 * std::f64::consts::TAU / 32.0;
            1e-3 * if i == 0 { (1.7 * y).sin() } else { -(1.7 * y).sin() }
        });
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        let unit = contact.stiffness_range()[0] * contact.surface().rms_height();
        for load in [1e-3, 0.1, 1.0, 10.0, 600.0] {
            let pressed = contact.press(Load::MeanPressure(load * unit)).tolerance(1e-7).solve();
            assert!(pressed.is_ok(), "{aspect} {load}: {}", pressed.unwrap_err());
        }
    }
}
