//! Contact with all components against contact with the normal component only, and against contact without lateral
//! displacement.

use std::ops::ControlFlow;
use std::sync::Arc;

use gfmd_contact::{Contact, Equilibrium, Fields, Load, Progress, Refusal, Solution, SolveError, Solver, Why};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_response::FullResponse;
use ndarray::Array2;

/// Returns the sum of a few waves, none of them along a lattice direction only.
fn heights(grid: &Grid) -> Array2<f64> {
    let [nx, ny] = grid.points();
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [i as f64 / nx as f64, j as f64 / ny as f64].map(|s| std::f64::consts::TAU * s);
        0.01 * ((x + 0.3).cos() + 0.4 * (2.0 * x - y + 1.0).cos() + 0.2 * (5.0 * x + 3.0 * y).cos())
    })
}

/// Without Nyquist modes, on odd grids, the two problems are equivalent: on lines and surfaces, slabs and half-spaces.
#[test]
fn frictionless_sideways_motion_does_not_change_the_normal_component() {
    let grids = [Grid::line(81, 1.0).unwrap(), Grid::new([21, 15], [1.0, 0.8]).unwrap()];
    for grid in grids {
        for (poisson, height) in
            [(0.33, None), (0.33, Some(0.3)), (0.45, Some(0.1)), (0.5, Some(0.3)), (-0.5, Some(1.0))]
        {
            let case = format!("{:?}, nu {poisson}, height {height:?}", grid.points());
            let material = Material::from_young(1.0, poisson).unwrap();
            let body = height.map_or_else(|| Body::half_space(material), |h| Body::slab(material, h).unwrap());
            let heights = heights(&grid);
            let full = Arc::new(FullResponse::new(grid, &body));
            let mean = 0.01;
            let contact = Contact::with_full_response(Arc::clone(&full), &heights).unwrap();
            let press = contact.press(Load::MeanPressure(mean)).tolerance(1e-11).max_iterations(200_000);
            let found = press.solve().unwrap_or_else(|error| panic!("{case}: {error}"));
            let contact = Contact::new(&body, &grid, &heights).unwrap();
            let expected = contact.press(Load::MeanPressure(mean)).tolerance(1e-12).solve().unwrap();
            let peak = expected.pressure.iter().copied().fold(0.0, f64::max);
            let touching = expected.pressure.iter().filter(|p| **p > 0.0).count();
            assert!((5..grid.len() - 5).contains(&touching), "{case}: {touching}");
            let worst =
                |a: &Array2<f64>, b: &Array2<f64>| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst(&found.pressure, &expected.pressure) < 1e-9 * peak, "{case}");
            assert!(worst(&found.displacement, &expected.displacement) < 1e-9 * 0.01, "{case}");
            assert!((found.approach - expected.approach).abs() < 1e-9 * expected.approach, "{case}");

            // The traction from the stiffness is the pressure only, except for means that do not affect the
            // displacement.
            let mut displacement: Vec<f64> =
                found.lateral.iter().flat_map(|lateral| &lateral.displacement).flatten().copied().collect();
            displacement.extend(&found.displacement);
            let mut traction = vec![0.0; displacement.len()];
            full.stiffness().apply(&displacement, &mut traction, &mut full.workspace()).unwrap();
            let lateral = traction.len() - grid.len();
            let drift = if full.uniform_compliance()[2] == 0.0 { mean } else { 0.0 };
            for (i, t) in traction.iter().enumerate() {
                let expected = if i < lateral { 0.0 } else { drift - found.pressure.as_slice().unwrap()[i - lateral] };
                assert!((t - expected).abs() < 1e-10 * peak, "{case}, {i}: {t} {expected}");
            }
            let sideways = found
                .lateral
                .iter()
                .flat_map(|lateral| &lateral.displacement)
                .flatten()
                .fold(0.0, |m, u| f64::max(m, u.abs()));
            let down = found.displacement.iter().fold(0.0, |m, u| f64::max(m, u.abs()));
            assert!(sideways > 0.01 * down, "{case}: the surface moves sideways");
        }
    }
}

#[test]
fn unusable_input_and_too_few_steps_are_errors() {
    let grid = Grid::square(9, 1.0).unwrap();
    let body = Body::half_space(Material::from_young(1.0, 0.3).unwrap());
    assert!(matches!(Contact::in_all_components(&body, &grid, &Array2::zeros((9, 8))), Err(Refusal::Shape { .. })));
    let contact = Contact::in_all_components(&body, &grid, &heights(&grid)).unwrap();
    let press = |mean| contact.press(Load::MeanPressure(mean));
    let refused = press(-0.1).solve().unwrap_err();
    assert!(matches!(refused, SolveError::Refused(Refusal::MeanPressure { found: -0.1 })));
    assert!(matches!(press(0.1).tolerance(0.0).solve(), Err(SolveError::Refused(Refusal::Tolerance(_)))));
    let refused = press(0.1).solver(Solver::PolonskyKeer).solve().unwrap_err();
    assert!(refused.to_string().contains("cg") && refused.to_string().contains("verlet-critical"), "{refused}");
    let expected = press(0.01).solve().unwrap();
    for solver in [Solver::VerletCritical, Solver::VerletModes, Solver::Fire] {
        let found = press(0.01).solver(solver).solve().unwrap();
        let differences = found.pressure.iter().zip(&expected.pressure).map(|(a, b)| (a - b).abs());
        assert!(differences.fold(0.0, f64::max) < 1e-6 * 0.2, "{solver}");
    }
    // A state follows from its pressure.
    let again = contact.certify(&expected.pressure, Load::MeanPressure(0.01)).unwrap();
    let fields = |state: &Solution| (state.gap.clone(), state.lateral.clone().unwrap().displacement);
    assert_eq!(fields(&again), fields(&expected));
    assert!(contact.certify(&Array2::zeros((9, 8)), Load::MeanPressure(0.01)).is_err());
    let refused = contact.press(Load::Approach(0.1)).solve().unwrap_err();
    assert!(matches!(refused, SolveError::Refused(Refusal::NoApproach)));
    match press(0.001).max_iterations(10).solve() {
        Err(SolveError::NotConverged { state, asked, why: Why::Iterations }) => {
            assert_eq!((state.effort().iterations, asked), (10, 1e-8));
            assert!(state.worst() > 1e-8);
        }
        other => panic!("{other:?}"),
    }
    let mut watch = |now: &Progress| if now.iteration < 7 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
    let stopped = press(0.001).watch(&mut watch).solve().unwrap_err();
    assert!(matches!(&stopped, SolveError::Interrupted { state } if state.effort().iterations == 7));
    // One run starts from the interrupted state, one from the final state.
    let resting = press(0.001).starting_from(stopped.state()).solve().unwrap();
    let again = press(0.001).starting_from(Some(&resting)).solve().unwrap();
    // Number of steps during which the set of touching points must not change.
    assert!(again.effort().iterations <= 25 && again.effort().iterations < resting.effort().iterations);
}

/// The stiffness is the difference quotient of loads a little apart, also on an even grid, and other parts are refused.
#[test]
fn all_components_have_the_stiffness_of_their_pressures() {
    let grid = Grid::square(12, 1.0).unwrap();
    let body = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 0.4).unwrap();
    let contact = Contact::in_all_components(&body, &grid, &heights(&grid)).unwrap();
    let solve = |mean: f64| contact.press(Load::MeanPressure(mean)).tolerance(1e-11).max_iterations(200_000).solve();
    let [below, at, above] = [0.99999e-2, 1e-2, 1.00001e-2].map(|mean| solve(mean).unwrap());
    let touching = |state: &Solution| state.pressure.mapv(|p| p > 0.0);
    assert_eq!(touching(&below), touching(&above));
    let quotient = (above.mean_pressure - below.mean_pressure) / (above.approach - below.approach);
    let stiffness = contact.stiffness(&at, 1e-9).unwrap();
    assert!((stiffness.value / quotient - 1.0).abs() < 1e-5, "{} {quotient}", stiffness.value);
    let normal = Contact::new(&body, &grid, &heights(&grid)).unwrap().stiffness(&at, 1e-9).unwrap();
    assert!((normal.value / quotient - 1.0).abs() > 1e-4, "the shortest waves have another stiffness");

    for refused in [contact.clone().with_hardness(1.0).map(|_| ()), contact.softened(1.0).map(|_| ())] {
        assert!(matches!(refused, Err(Refusal::NotNormal { .. })), "{refused:?}");
    }
}

/// Without lateral displacement the waves of a half-space are stiffer by the factor 1/(1 − s²) (theory.md, section 3),
/// as for a modulus that is larger by it.
#[test]
fn a_half_space_that_is_held_sideways_is_stiffer_by_one_factor() {
    let grid = Grid::square(24, 1.0).unwrap();
    let heights = heights(&grid);
    let material = Material::from_young(1.0, 0.33).unwrap();
    let factor = 1.0 / (1.0 - material.s().powi(2));
    assert!((factor - 1.069).abs() < 1e-3);
    let stiffer = Body::half_space(Material::from_contact_modulus(material.contact_modulus() * factor, 0.0).unwrap());
    let solve = |contact: Contact| contact.press(Load::MeanPressure(0.02)).tolerance(1e-10).solve().unwrap();
    let found = solve(Contact::held_sideways(&Body::half_space(material), &grid, &heights).unwrap());
    let expected = solve(Contact::new(&stiffer, &grid, &heights).unwrap());
    let peak = expected.pressure.iter().copied().fold(0.0, f64::max);
    let worst = |a: &Array2<f64>, b: &Array2<f64>| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst(&found.pressure, &expected.pressure) < 1e-8 * peak);
    assert!(worst(&found.displacement, &expected.displacement) < 1e-10);
    // The reduced pressure is formed with the modulus of the body.
    assert!((found.scales().contact_modulus - material.contact_modulus()).abs() < 1e-15);
}

/// In full contact with one wave the pressure is K_N times the heights (theory.md, sections 2 and 3).
#[test]
fn a_slab_that_is_held_sideways_has_the_stiffness_of_its_closed_form() {
    let (grid, height, amplitude) = (Grid::square(16, 1.0).unwrap(), 0.2, 1e-4);
    let (s, shear) = (0.25 / 0.75, 0.4);
    let body = Body::slab(Material::from_young(1.0, 0.25).unwrap(), height).unwrap();
    let q = std::f64::consts::TAU * 5.0_f64.sqrt();
    let h = q * height;
    let denominator = ((1.0 + s) * h.sinh()).powi(2) - ((1.0 - s) * h).powi(2);
    let stiffness = shear * q * ((1.0 + s) * (2.0 * h).sinh() - 2.0 * (s - 1.0) * h) / denominator;
    let wave = |(i, j): (usize, usize)| (std::f64::consts::TAU * (i as f64 - 2.0 * j as f64) / 16.0).cos();
    let heights = Array2::from_shape_fn((16, 16), |place| amplitude * wave(place));
    let contact = Contact::held_sideways(&body, &grid, &heights).unwrap();
    for load in [Load::MeanPressure(0.01), Load::Approach(0.01)] {
        let found = contact.press(load).tolerance(1e-12).solve().unwrap();
        for (place, p) in found.pressure.indexed_iter() {
            let expected = found.mean_pressure + stiffness * amplitude * wave(place);
            assert!((p - expected).abs() < 1e-10 * found.mean_pressure, "{place:?}: {p} {expected}");
        }
        // The mean sinks by the uniform compression, and first touch is an amplitude above the mean.
        let approach = found.mean_pressure * height * s / shear + amplitude;
        assert!((found.approach - approach).abs() < 1e-10 * approach, "{} {approach}", found.approach);
    }
}
