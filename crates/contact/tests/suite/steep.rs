//! Contact with finite slopes: identities and limits. Dense solutions are compared in `tests/src/steep.rs`.

use gfmd_contact::{
    Contact, Drive, Equilibrium, Fields, Load, MemoryCheckpoint, Refusal, Resumable, SolveError, Solver, SteepContact,
    SteepSolution, Stiffness,
};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use ndarray::Array2;

const N: usize = 31;

/// Returns reproducible waves with wavenumbers up to three and the rms gradient `gradient`.
fn rough(gradient: f64, is_line: bool) -> (Grid, Array2<f64>) {
    let grid = if is_line { Grid::line(N, 1.0).unwrap() } else { Grid::square(N, 1.0).unwrap() };
    let mut heights = Array2::zeros(grid.points());
    let (mut squares, mut phase) = (0.0, 0.3_f64);
    for m in 0..4 {
        for n in if is_line { 0..1 } else { -3..4 } {
            let q = std::f64::consts::TAU * f64::from(m).hypot(f64::from(n));
            phase = (phase * 7.3 + 0.618).fract();
            if q > 0.0 {
                let amplitude = q.powf(-1.7);
                heights.indexed_iter_mut().for_each(|((i, j), h)| {
                    let angle = f64::from(m) * i as f64 / N as f64 + f64::from(n) * j as f64 / N as f64 + phase;
                    *h += amplitude * (std::f64::consts::TAU * angle).cos();
                });
                squares += 0.5 * (amplitude * q).powi(2);
            }
        }
    }
    (grid, heights * (gradient / squares.sqrt()))
}

fn body(nu: f64) -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, nu).unwrap())
}

#[test]
fn the_mean_pressure_is_the_derivative_of_the_energy() {
    for (nu, is_line) in [(0.0, true), (0.3, false)] {
        let (grid, heights) = rough(0.25, is_line);
        let contact = SteepContact::new(&body(nu), &grid, &heights).unwrap();
        let at = |approach: f64| contact.press(Load::Approach(approach)).tolerance(1e-12).solve().unwrap();
        let approach = 0.7 * contact.surface().rms_height();
        let step = 1e-4 * approach;
        let energy = |approach: f64| at(approach).summary().elastic_energy;
        let slope = (energy(approach + step) - energy(approach - step)) / (2.0 * step);
        let state = at(approach);
        assert!(state.worst() <= 1e-12);
        approx::assert_relative_eq!(slope, state.normal.mean_pressure, max_relative = 1e-6);
        // The contact with small slopes has this property too, but at another pressure.
        let flat = Contact::new(&body(nu), &grid, &heights).unwrap().press(Load::Approach(approach)).solve().unwrap();
        assert!((flat.mean_pressure / state.normal.mean_pressure - 1.0).abs() > 0.01);
    }
}

#[test]
fn below_a_hardness_the_mean_pressure_is_the_derivative_of_the_stored_and_the_plastic_energy() {
    let (grid, heights) = rough(0.25, false);
    let contact = SteepContact::new(&body(0.3), &grid, &heights).unwrap().with_hardness(0.08).unwrap();
    let at = |approach: f64| contact.press(Load::Approach(approach)).tolerance(1e-12).solve().unwrap();
    let approach = 0.7 * contact.surface().rms_height();
    let state = at(approach);
    let plastic = state.normal.plastic.as_ref().unwrap();
    let area = state.summary().area_fraction;
    assert!(state.worst() <= 1e-12);
    assert!(plastic.fraction > 0.01 && plastic.fraction < area, "{} {area}", plastic.fraction);
    assert!(state.normal.pressure.iter().all(|p| *p <= 0.08));
    let energy = |approach: f64| {
        let state = at(approach);
        state.summary().elastic_energy + 0.08 * state.normal.plastic.as_ref().unwrap().volume
    };
    let step = 1e-4 * approach;
    let slope = (energy(approach + step) - energy(approach - step)) / (2.0 * step);
    approx::assert_relative_eq!(slope, state.normal.mean_pressure, max_relative = 1e-6);
    // The same load leads back to the same approach.
    let load = Load::MeanPressure(state.normal.mean_pressure);
    let loaded = contact.press(load).tolerance(1e-12).solve().unwrap();
    approx::assert_relative_eq!(loaded.normal.approach, approach, max_relative = 1e-9);
}

/// Returns the change of the mean pressure divided by the change of the approach, from a state to a larger load, or
/// between loads on both sides if `is_smooth`.
fn quotient(contact: &SteepContact, state: &SteepSolution, is_smooth: bool) -> f64 {
    let at = |factor: f64| {
        let load = Load::MeanPressure(factor * state.normal.mean_pressure);
        contact.press(load).tolerance(1e-11).solve().unwrap().normal
    };
    let below = at(if is_smooth { 1.0 - 1e-5 } else { 1.0 });
    let above = at(1.0 + 1e-5);
    let touches = |state: &gfmd_contact::Solution| state.pressure.mapv(|p| p > 0.0);
    assert_eq!(touches(&below), touches(&above));
    (above.mean_pressure - below.mean_pressure) / (above.approach - below.approach)
}

#[test]
fn the_stiffness_is_the_derivative_of_the_mean_pressure() {
    let slab = |nu: f64| Body::slab(Material::from_contact_modulus(1.0, nu).unwrap(), 0.3).unwrap();
    let bodies = [body(0.0), body(0.3), body(0.5), slab(0.2)];
    for (body, is_line) in bodies.iter().flat_map(|body| [(body, true), (body, false)]) {
        let (grid, heights) = rough(0.3, is_line);
        let [steep, hard] = [None, Some(0.12)].map(|hardness| {
            let contact = SteepContact::new(body, &grid, &heights).unwrap();
            match hardness {
                Some(hardness) => contact.with_hardness(hardness).unwrap(),
                None => contact,
            }
        });
        for pressure in [0.005, 0.05, 0.1] {
            let load = Load::MeanPressure(pressure);
            for (contact, is_smooth) in [(&steep, true), (&hard, false)] {
                let state = contact.press(load).tolerance(1e-11).solve().unwrap();
                let found = contact.stiffness(&state, 1e-9).unwrap();
                assert!(found.error <= 1e-9);
                let slope = quotient(contact, &state, is_smooth);
                let loose = contact.stiffness(&state, Stiffness::TOLERANCE).unwrap();
                approx::assert_relative_eq!(found.value, slope, max_relative = if is_smooth { 2e-6 } else { 1e-5 });
                approx::assert_relative_eq!(loose.value, found.value, max_relative = loose.error + found.error);
            }
        }
    }
}

/// The surface moves sideways, so that the mean level of a half-space does not fix the approach.
#[test]
fn full_contact_has_a_stiffness() {
    let (grid, heights) = rough(0.1, false);
    let contact = SteepContact::new(&body(0.3), &grid, &heights).unwrap();
    let state = contact.press(Load::MeanPressure(0.5)).tolerance(1e-11).solve().unwrap();
    assert_eq!(state.summary().area_fraction, 1.0);
    let found = contact.stiffness(&state, 1e-9).unwrap();
    approx::assert_relative_eq!(found.value, quotient(&contact, &state, true), max_relative = 1e-5);
    assert!(found.error <= 1e-9);
}

#[test]
fn small_slopes_give_the_stiffness_of_the_contact_with_small_slopes() {
    let difference = |gradient: f64| {
        let (grid, heights) = rough(gradient, false);
        let steep = SteepContact::new(&body(0.2), &grid, &heights).unwrap();
        let state = steep.press(Load::MeanPressure(0.1 * gradient)).tolerance(1e-11).solve().unwrap();
        let flat = Contact::new(&body(0.2), &grid, &heights).unwrap();
        let found = steep.stiffness(&state, 1e-9).unwrap().value;
        found / flat.stiffness_of_pressure(&state.normal.pressure, 1e-9).unwrap().value - 1.0
    };
    let [small, large] = [1e-4, 2e-4].map(difference);
    assert!(small.abs() < 1e-4 && (large / small - 2.0).abs() < 0.05, "{small:e} {large:e}");
}

#[test]
fn a_hardness_that_is_not_reached_changes_no_steep_contact_and_small_slopes_give_that_of_small_ones() {
    let (grid, heights) = rough(0.25, false);
    let (contact, load) = (SteepContact::new(&body(0.3), &grid, &heights).unwrap(), Load::MeanPressure(0.05));
    let without = contact.press(load).tolerance(1e-11).solve().unwrap();
    let with = contact.clone().with_hardness(50.0).unwrap().press(load).tolerance(1e-11).solve().unwrap();
    approx::assert_relative_eq!(with.normal.approach, without.normal.approach, max_relative = 1e-9);
    assert_eq!(with.normal.plastic.as_ref().unwrap().fraction, 0.0);
    let gradient = 1e-4;
    let (grid, heights) = rough(gradient, false);
    let load = Load::MeanPressure(0.1 * gradient);
    let steep = SteepContact::new(&body(0.3), &grid, &heights).unwrap().with_hardness(0.4 * gradient).unwrap();
    let steep = steep.press(load).tolerance(1e-11).solve().unwrap();
    let flat = Contact::new(&body(0.3), &grid, &heights).unwrap().with_hardness(0.4 * gradient).unwrap();
    let flat = flat.press(load).tolerance(1e-11).solve().unwrap();
    let volume = |state: &gfmd_contact::Solution| state.plastic.as_ref().unwrap().volume;
    approx::assert_relative_eq!(volume(&steep.normal), volume(&flat), max_relative = 1e-3);
    for wrong in [0.0, f64::NAN, -1.0] {
        assert!(matches!(contact.clone().with_hardness(wrong), Err(Refusal::Hardness { .. })), "{wrong}");
    }
    let soft = contact.with_hardness(0.01).unwrap();
    assert!(matches!(soft.check(load.into()), Ok(())) && soft.check(Load::MeanPressure(0.02).into()).is_err());
}

#[test]
fn small_slopes_give_the_contact_with_small_slopes_and_the_difference_is_of_first_order() {
    let difference = |gradient: f64| {
        let (grid, heights) = rough(gradient, false);
        let load = Load::MeanPressure(0.1 * gradient);
        let steep =
            SteepContact::new(&body(0.2), &grid, &heights).unwrap().press(load).tolerance(1e-11).solve().unwrap();
        let flat = Contact::new(&body(0.2), &grid, &heights).unwrap().press(load).tolerance(1e-11).solve().unwrap();
        (steep.normal.approach - flat.approach).abs() / flat.approach
    };
    let [small, large] = [1e-4, 2e-4].map(difference);
    assert!(small < 1e-4 && (large / small - 2.0).abs() < 0.05, "{small:e} {large:e}");
}

#[test]
fn an_incompressible_body_feels_the_first_order_in_its_lateral_displacement_only() {
    let (grid, heights) = rough(0.01, false);
    let contact = SteepContact::new(&body(0.5), &grid, &heights).unwrap();
    let state = contact.press(Load::MeanPressure(0.001)).tolerance(1e-11).solve().unwrap();
    let flat = Contact::new(&body(0.5), &grid, &heights).unwrap();
    let flat = flat.press(Load::MeanPressure(0.001)).tolerance(1e-11).solve().unwrap();
    let change = state.normal.approach / flat.approach - 1.0;
    assert!(change.abs() < 1e-3, "{change:e}");
    // Its surface moves sideways in second order, a compressible one in first order.
    assert!((state.projected_area().unwrap() / state.summary().area_fraction - 1.0).abs() < 1e-3);
    let soft =
        SteepContact::new(&body(0.0), &grid, &heights).unwrap().press(Load::MeanPressure(0.001)).solve().unwrap();
    // The lateral strains of a half-space add up to -(1 - 2 nu)(1 + nu)/E times the pressure minus its mean (Johnson
    // 1985, section 3.6).
    let ratio = soft.projected_area().unwrap() / soft.summary().area_fraction - 1.0;
    let strain = soft.summary().mean_pressure_in_contact - soft.normal.mean_pressure;
    assert!((ratio / -strain - 1.0).abs() < 0.05, "{ratio:e} {strain:e}");
    // The rigid surface is held sideways against the push of its slopes.
    let [x, y] = state.mean_shear;
    assert!(x.hypot(y) < 0.01 * state.normal.mean_pressure && x != 0.0);
}

#[test]
fn a_slab_and_both_controls_give_the_same_state() {
    let (grid, heights) = rough(0.2, false);
    let body = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 0.4).unwrap();
    let contact = SteepContact::new(&body, &grid, &heights).unwrap();
    let pressed = contact.press(Load::MeanPressure(0.02)).tolerance(1e-11).solve().unwrap();
    let moved = contact.press(Load::Approach(pressed.normal.approach)).tolerance(1e-11).solve().unwrap();
    approx::assert_relative_eq!(moved.normal.mean_pressure, 0.02, max_relative = 1e-9);
    // Another start leads to the same state.
    let larger = contact.press(Load::MeanPressure(0.03)).solve().unwrap();
    let again = contact.press(Load::MeanPressure(0.02)).tolerance(1e-11).starting_from(Some(&larger)).solve().unwrap();
    approx::assert_relative_eq!(again.normal.approach, pressed.normal.approach, max_relative = 1e-9);
}

#[test]
fn a_state_follows_from_its_pressure_to_the_last_bit() {
    let (grid, heights) = rough(0.2, false);
    let contact = SteepContact::new(&body(0.1), &grid, &heights).unwrap();
    let load = Load::MeanPressure(0.02);
    let mut state = contact.press(load).solve().unwrap();
    let mut checkpoint = MemoryCheckpoint::default();
    contact.keep(&mut state, &mut checkpoint);
    checkpoint.rewind();
    let restored = contact.restore(load.into(), &mut checkpoint).unwrap();
    assert_eq!(restored, state);
    let certified = contact.certify(&state.normal.pressure, load).unwrap();
    assert_eq!(certified.normal.gap, state.normal.gap);
}

#[test]
fn slopes_that_are_too_large_and_wrong_input_are_refused() {
    let (grid, heights) = rough(3.0, true);
    let contact = SteepContact::new(&body(0.0), &grid, &heights).unwrap();
    let error = contact.press(Load::MeanPressure(1.0)).solve().unwrap_err();
    assert!(matches!(error, SolveError::NotConverged { .. }), "{error}");
    assert!(error.state().is_some_and(|state| state.worst().is_nan() || state.worst() > 1e-8));
    let refused = |result: Result<_, SolveError<_>>| matches!(result, Err(SolveError::Refused(_)));
    assert!(refused(contact.press(Load::MeanPressure(-1.0)).solve()));
    assert!(refused(contact.press(Load::Approach(0.0)).solve()));
    assert!(refused(contact.press(Load::MeanPressure(0.1)).solver(Solver::Fire).solve()));
    assert!(contact.check(Drive::from(Load::MeanPressure(f64::NAN))).is_err());
    assert!(matches!(contact.certify(&Array2::zeros((3, 3)), Load::MeanPressure(1.0)), Err(Refusal::Shape { .. })));
    assert!(matches!(SteepContact::new(&body(0.0), &grid, &Array2::zeros((N, 1))), Err(Refusal::Flat)));
}

#[test]
fn a_loose_tolerance_is_met() {
    let (grid, heights) = rough(0.2, false);
    let contact = SteepContact::new(&body(0.2), &grid, &heights).unwrap();
    for tolerance in [1e-2, 0.1] {
        let state = contact.press(Load::MeanPressure(0.02)).tolerance(tolerance).solve().unwrap();
        assert!(state.worst() <= tolerance, "{tolerance}: {}", state.worst());
    }
}

/// The displacement under this pressure is not finite: a certificate of the undeformed surface would be wrong.
#[test]
fn a_displacement_that_is_not_finite_has_no_certificate() {
    let (grid, heights) = rough(0.2, false);
    let contact = SteepContact::new(&body(0.1), &grid, &heights).unwrap();
    let pressure = Array2::from_shape_fn(grid.points(), |(i, j)| if (i + j) % 3 == 0 { 1e308 } else { 0.0 });
    match contact.certify(&pressure, Load::MeanPressure(1e307)) {
        Ok(state) => assert!(state.worst().is_nan()),
        Err(refusal) => assert!(matches!(refusal, Refusal::Height { .. } | Refusal::RmsHeight { .. }), "{refusal}"),
    }
}

#[test]
fn fields_of_another_layout_have_the_same_projected_area() {
    let (grid, heights) = rough(0.2, false);
    let contact = SteepContact::new(&body(0.1), &grid, &heights).unwrap();
    let mut state = contact.press(Load::MeanPressure(0.02)).solve().unwrap();
    let expected = state.projected_area().unwrap();
    for u in &mut state.lateral {
        *u = u.t().as_standard_layout().into_owned().reversed_axes();
        assert!(u.as_slice().is_none());
    }
    assert_eq!(state.projected_area(), Ok(expected));
    state.lateral[0] = Array2::zeros((N, N + 1));
    assert!(state.projected_area().is_err());
}
