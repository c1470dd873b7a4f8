//! Contacts with a hardness: from first touch to almost the hardness everywhere, and identities.

use gfmd_contact::{Boundary, Contact, Equilibrium, Fields, Hardness, Load, Refusal, Solution, SolveError, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

fn rough(n: usize) -> Array2<f64> {
    let numbers = Discretisation { eps_t_inv: 1.0, eps_f_inv: n as f64 / 4.0, eps_c_inv: 4.0 };
    let family = SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) };
    numbers.self_affine(1.0, family).heights(&Grid::square(n, 1.0).unwrap(), 3).unwrap()
}

fn contact(boundary: Boundary, n: usize) -> Contact {
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
    Contact::with_boundary(boundary, &body, &Grid::square(n, 1.0).unwrap(), &rough(n)).unwrap()
}

fn highest(solution: &Solution) -> f64 {
    solution.pressure.iter().copied().fold(0.0, f64::max)
}

#[test]
fn every_load_up_to_the_hardness_converges() {
    for boundary in Boundary::ALL {
        let contact = contact(boundary, 64);
        for hardness in [0.001, 0.01, 0.05, 0.2, 1.0, 10.0] {
            let contact = contact.clone().with_hardness(hardness).unwrap();
            for share in [1e-3, 0.01, 0.1, 0.3, 0.5, 0.8, 0.95, 0.99, 0.999] {
                let mean = share * hardness;
                let solution = contact.press(Load::MeanPressure(mean)).solve();
                let solution = solution.unwrap_or_else(|error| panic!("{boundary} {hardness} {share}: {error}"));
                let plastic = solution.plastic.as_ref().unwrap();
                assert!(solution.worst() <= 1e-8 && highest(&solution) <= hardness);
                assert!(solution.effort.iterations <= 40, "{boundary} {hardness} {share}: {}", solution.effort);
                let full = solution.pressure.iter().filter(|p| **p == hardness).count();
                assert!((plastic.fraction * 4096.0 - full as f64).abs() < 1e-9);
                assert!((plastic.depth.mean().unwrap() - plastic.volume).abs() <= 1e-13 * plastic.volume);
                assert!(plastic.depth.iter().zip(&solution.pressure).all(|(d, p)| *d == 0.0 || *p == hardness));
            }
        }
    }
}

#[test]
fn a_hardness_that_is_not_reached_changes_nothing_but_rounding() {
    for boundary in Boundary::ALL {
        let contact = contact(boundary, 48);
        let load = Load::MeanPressure(0.01);
        let elastic = contact.press(load).tolerance(1e-11).solve().unwrap();
        let hard = contact.with_hardness(2.0 * highest(&elastic)).unwrap();
        let solution = hard.press(load).tolerance(1e-11).solve().unwrap();
        assert!((&solution.pressure - &elastic.pressure).iter().all(|d| d.abs() < 1e-8 * highest(&elastic)));
        let plastic = solution.plastic.unwrap();
        assert!(plastic.fraction == 0.0);
        assert!(plastic.volume == 0.0);
        assert!(plastic.saturation == 0.0);
    }
}

#[test]
fn a_soft_surface_is_in_contact_where_the_load_needs_it() {
    // With hardly any elasticity, the area is the load divided by the hardness.
    let contact = contact(Boundary::Periodic, 64).with_hardness(1e-4).unwrap();
    for share in [0.1, 0.5, 0.9] {
        let solution = contact.press(Load::MeanPressure(share * 1e-4)).solve().unwrap();
        let area = solution.pressure.iter().filter(|p| **p > 0.0).count() as f64 / 4096.0;
        assert!((area / share - 1.0).abs() < 0.02, "{share}: {area}");
    }
}

#[test]
fn plastic_depth_is_where_the_surfaces_would_cross() {
    let contact = contact(Boundary::Free, 32).with_hardness(0.05).unwrap();
    let solution = contact.press(Load::MeanPressure(0.02)).tolerance(1e-11).solve().unwrap();
    let plastic = solution.plastic.as_ref().unwrap();
    let clearance = contact.surface().clearance();
    for (index, (gap, depth)) in solution.gap.iter().zip(&plastic.depth).enumerate() {
        let u = solution.displacement[[index / 32, index % 32]];
        assert!((gap - depth - (clearance.at(index) - u - solution.approach)).abs() < 1e-12);
    }
    let certified = contact.certify(&solution.pressure, Load::MeanPressure(0.02)).unwrap();
    assert_eq!(certified.plastic, solution.plastic);
    // A pressure beyond the hardness is not certified.
    let beyond = contact.certify(&(&solution.pressure * 1.01), Load::MeanPressure(0.02)).unwrap();
    assert!(beyond.plastic.as_ref().unwrap().saturation > 0.009 && beyond.worst() > 0.009);
}

#[test]
fn what_cannot_be_done_is_refused() {
    let contact = contact(Boundary::Periodic, 16);
    for hardness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(contact.clone().with_hardness(hardness), Err(Refusal::Hardness { .. })), "{hardness}");
    }
    let contact = contact.with_hardness(0.1).unwrap();
    assert_eq!(contact.hardness(), Some(Hardness::Uniform(0.1)));
    let error = contact.press(Load::MeanPressure(0.1)).solve().unwrap_err();
    assert_eq!(error.to_string(), "the mean pressure is 0.1; it must be less than the hardness 0.1");
    for solver in [Solver::ProjectedCg, Solver::PolonskyKeer, Solver::Verlet] {
        let error = contact.press(Load::MeanPressure(0.01)).solver(solver).solve().unwrap_err();
        assert!(matches!(error, SolveError::Refused(Refusal::Solver { .. })), "{error}");
    }
}

/// Returns grains in stripes, the softest a tenth as hard as the hardest.
fn grains(n: usize, hardness: f64) -> Array2<f64> {
    Array2::from_shape_fn((n, n), |(i, j)| hardness * [1.0, 0.1, 0.4][(i / 5 + j / 7) % 3])
}

#[test]
fn a_field_of_one_hardness_is_that_hardness() {
    for boundary in Boundary::ALL {
        let contact = contact(boundary, 48);
        for load in [Load::MeanPressure(0.02), Load::Approach(0.02)] {
            let one = contact.clone().with_hardness(0.05).unwrap().press(load).tolerance(1e-12).solve().unwrap();
            let field = contact.clone().with_hardness(Array2::from_elem((48, 48), 0.05)).unwrap();
            let field = field.press(load).tolerance(1e-12).solve().unwrap();
            let most = (&one.pressure - &field.pressure).iter().fold(0.0, |most: f64, d| most.max(d.abs()));
            assert!(most < 1e-9, "{boundary} {load:?}: {most}");
            let [one, field] = [one, field].map(|solution| solution.plastic.unwrap());
            assert_eq!(one.fraction, field.fraction);
            approx::assert_relative_eq!(one.volume, field.volume, max_relative = 1e-8);
        }
    }
}

#[test]
fn every_load_up_to_the_mean_of_a_field_converges() {
    for boundary in Boundary::ALL {
        let contact = contact(boundary, 64);
        for hardness in [0.001, 0.05, 1.0, 10.0] {
            let field = grains(64, hardness);
            let contact = contact.clone().with_hardness(field.clone()).unwrap();
            let mean = contact.hardness().unwrap().mean();
            for share in [1e-3, 0.05, 0.3, 0.8, 0.99, 0.999] {
                let solution = contact.press(Load::MeanPressure(share * mean)).solve();
                let solution = solution.unwrap_or_else(|error| panic!("{boundary} {hardness} {share}: {error}"));
                assert!(solution.worst() <= 1e-8, "{boundary} {hardness} {share}");
                assert!(solution.effort.iterations <= 60, "{boundary} {hardness} {share}: {}", solution.effort);
                assert!(solution.pressure.iter().zip(&field).all(|(p, h)| *p <= *h));
                let depth = &solution.plastic.as_ref().unwrap().depth;
                assert!(depth.iter().zip(solution.pressure.iter().zip(&field)).all(|(d, (p, h))| *d == 0.0 || p == h));
                let found = contact.certify(&solution.pressure, Load::MeanPressure(share * mean)).unwrap();
                assert_eq!(found.plastic, solution.plastic);
            }
        }
    }
}

#[test]
fn a_field_that_cannot_be_used_is_refused() {
    let contact = contact(Boundary::Periodic, 16);
    let refused = |field: Array2<f64>| contact.clone().with_hardness(field).unwrap_err();
    let shape = refused(Array2::ones((16, 15)));
    assert!(matches!(shape, Refusal::HardnessShape { found: [16, 15], expected: [16, 16] }));
    for bad in [0.0, f64::NAN, f64::INFINITY] {
        let mut field = Array2::ones((16, 16));
        field[[3, 4]] = bad;
        assert!(matches!(refused(field), Refusal::Hardness { .. }), "{bad}");
    }
    let hard = contact.with_hardness(grains(16, 0.1)).unwrap();
    let mean = hard.hardness().unwrap().mean();
    let error = hard.press(Load::MeanPressure(mean)).solve().unwrap_err();
    assert_eq!(
        error.to_string(),
        format!("the mean pressure is {mean}; it must be less than the mean hardness {mean}")
    );
}
