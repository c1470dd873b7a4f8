//! Frictional contact compared with closed forms.

use std::f64::consts::{PI, TAU};

use std::ops::ControlFlow;

use gfmd_contact::{Boundary, Budget, Drive, Equilibrium, Fields, Load, Progress, Refusal, SolveError, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, Parts, Path, QuasistaticContact, QuasistaticState, Refinement, Step};
use gfmd_law::Limit;
use gfmd_response::{FreeFullCompliance, FreeFullTransforms};
use ndarray::Array2;

use crate::{rubbing, traction};

fn incompressible() -> Body {
    // For E* = 4 C44, normal load and shear are uncoupled.
    Body::half_space(Material::from_contact_modulus(1.0, 0.5).unwrap())
}

fn periodic(body: &Body, grid: &Grid, heights: &Array2<f64>, limit: Limit) -> QuasistaticContact {
    rubbing(Boundary::Periodic, body, grid, heights, limit)
}

fn stick_fraction(state: &QuasistaticState) -> f64 {
    state.stick_fraction().unwrap()
}

fn solve(contact: &QuasistaticContact, drive: impl Into<Drive>, start: Option<&QuasistaticState>) -> QuasistaticState {
    contact.press(drive).tolerance(1e-10).starting_from(start).solve().unwrap()
}

fn wave(n: usize) -> Array2<f64> {
    Array2::from_shape_fn((n, 1), |(i, _)| 0.01 * (TAU * i as f64 / n as f64).cos())
}

fn pressed(pressure: f64, x: f64) -> Drive {
    Drive { load: Load::MeanPressure(pressure), lateral: [x, 0.0], time: 0.0, distance: 0.0 }
}

#[test]
fn a_wave_under_shear_sticks_where_the_smaller_of_two_loads_would_press() {
    // Ciavarella (1998), Jäger (1998): τ = μ (p(P) − p(P*)), P* = P − Q/μ, exact where normal and tangential compliance
    // are equal and uncoupled: plane strain, ν = ½. The validation compares the shear point by point.
    let n = 256;
    let contact = periodic(&incompressible(), &Grid::line(n, 1.0).unwrap(), &wave(n), Limit::Coulomb(0.4));
    let load = 0.3 * PI * 0.01;
    let rest = solve(&contact, pressed(load, 0.0), None);
    assert!(rest.mean_shear[0].abs() < 1e-14 && rest.losses.total().abs() < 1e-16);
    for lateral in [2e-4, 1e-3, 2e-3] {
        let state = solve(&contact, pressed(load, lateral), Some(&rest));
        let shear = state.mean_shear[0];
        let core = solve(&contact, pressed(load - shear / 0.4, 0.0), None);
        assert_eq!(stick_fraction(&state), core.summary().area_fraction, "{lateral}");
        // Contact fraction of Westergaard.
        let share = 2.0 / PI * ((load - shear / 0.4) / (PI * 0.01)).sqrt().asin();
        assert!((stick_fraction(&state) - share).abs() < 2.0 / n as f64, "{} {share}", stick_fraction(&state));
        assert!(state.losses.total() > 0.0 && shear < 0.4 * load);
    }
    let sliding = solve(&contact, pressed(load, 0.05), Some(&rest));
    assert!((sliding.mean_shear[0] - 0.4 * load).abs() < 1e-10 && stick_fraction(&sliding) == 0.0);
}

#[test]
fn a_loop_of_shear_doubles_the_first_branch() {
    // Masing's rule, exact under the same conditions: Q(U − 2 x) = Q(U) − 2 Q₁(x); Q₁ is the first branch.
    let n = 128;
    let contact = periodic(&incompressible(), &Grid::line(n, 1.0).unwrap(), &wave(n), Limit::Coulomb(0.4));
    let load = 0.3 * PI * 0.01;
    let rest = solve(&contact, pressed(load, 0.0), None);
    let first = |x: f64| solve(&contact, pressed(load, x), Some(&rest));
    let far = first(2e-3);
    let mut last = far.clone();
    for x in [2.5e-4, 5e-4, 1e-3, 2e-3] {
        last = solve(&contact, pressed(load, 2e-3 - 2.0 * x), Some(&last));
        let wanted = far.mean_shear[0] - 2.0 * first(x).mean_shear[0];
        assert!((last.mean_shear[0] - wanted).abs() < 1e-7 * far.mean_shear[0], "{x}");
    }
}

#[test]
fn the_shear_under_a_sphere_is_that_of_cattaneo_and_mindlin() {
    // Cattaneo (1938), Mindlin (1949): c = a (1 − Q/μP)^⅓ and τ = μ (p₀ √(1 − r²/a²) − p₀ c/a √(1 − r²/c²)). They take
    // the slip along x everywhere, which causes an error of about one per cent.
    let errors: Vec<f64> = [32, 64, 128]
        .into_iter()
        .map(|n| {
            let grid = Grid::square(n, 1.0).unwrap();
            let at = |i: usize| i as f64 / n as f64 - 0.5;
            let heights = Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (at(i).powi(2) + at(j).powi(2)));
            let contact = periodic(&incompressible(), &grid, &heights, Limit::Coulomb(0.3));
            let a = 0.15_f64;
            let load = 4.0 / 3.0 * a.powi(3);
            let rest = solve(&contact, pressed(load, 0.0), None);
            let strongest = 0.3 * 2.0 * a / PI;
            let mut worst = 0.0_f64;
            for lateral in [2e-3, 3e-3, 4e-3] {
                let state = solve(&contact, pressed(load, lateral), Some(&rest));
                let c = a * (1.0 - state.mean_shear[0] / (0.3 * load)).cbrt();
                let dome = |r: f64, b: f64| (1.0 - (r / b).powi(2)).max(0.0).sqrt();
                let (mut square, shear) = (0.0, state.shear(0).unwrap());
                for i in 0..n {
                    for j in 0..n {
                        let r = at(i).hypot(at(j));
                        let wanted = strongest * (dome(r, a) - c / a * dome(r, c));
                        square += (shear[[i, j]] - wanted).powi(2);
                    }
                }
                worst = worst.max((square / (PI * (a * n as f64).powi(2))).sqrt() / strongest);
                assert!(state.mean_shear[1].abs() < 1e-9 * state.mean_shear[0]);
            }
            worst
        })
        .collect();
    assert!(errors[2] < 0.02 && errors[2] < 0.5 * errors[0], "{errors:?}");
}

#[test]
fn every_condition_holds_under_a_path_of_shear_up_to_sliding() {
    let grid = Grid::new([40, 36], [1.0, 0.9]).unwrap();
    let coupled = Body::slab(Material::from_young(1.0, 0.2).unwrap(), 0.3).unwrap();
    let at =
        |i: usize, j: usize| (TAU * i as f64 / 40.0).cos() + (TAU * (j as f64 / 36.0 + 2.0 * i as f64 / 40.0)).sin();
    let heights = Array2::from_shape_fn((40, 36), |(i, j)| 0.01 * at(i, j));
    for (body, limit) in [
        (&coupled, Limit::Coulomb(0.5)),
        (&incompressible(), Limit::Coulomb(0.5)),
        (&incompressible(), Limit::Tresca(0.004)),
        (&incompressible(), Limit::Orowan { coefficient: 0.5, strength: 0.02 }),
    ] {
        let contact = periodic(body, &grid, &heights, limit);
        for load in [Load::MeanPressure(0.01), Load::Approach(0.015)] {
            let mut last = None;
            let mut work = 0.0;
            for lateral in [[0.0, 0.0], [2e-3, -1e-3], [4e-3, 1e-3], [0.2, 0.1]] {
                let state = solve(&contact, Drive { load, lateral, time: 0.0, distance: 0.0 }, last.as_ref());
                assert!(state.worst() <= 1e-10 && state.losses.total() >= -1e-16);
                work += state.losses.total();
                last = Some(state);
            }
            let state = last.unwrap();
            assert!(work > 0.0 && stick_fraction(&state) == 0.0);
            let wanted = match limit {
                Limit::Coulomb(coefficient) => coefficient * state.mean_pressure(),
                Limit::Tresca(strength) => strength * state.summary().area_fraction,
                Limit::Orowan { .. } => state.pressure().map(|p| limit.at(*p)).mean().unwrap(),
            };
            let found = state.mean_shear[0].hypot(state.mean_shear[1]);
            // The slip direction differs slightly between points.
            assert!(found <= wanted * (1.0 + 1e-9) && found > 0.98 * wanted, "{limit:?} {load:?}: {found} {wanted}");
        }
    }
}

#[test]
fn without_friction_normal_contact_is_that_of_the_wall_alone() {
    let grid = Grid::new([33, 31], [1.0, 1.0]).unwrap();
    let body = Body::half_space(Material::from_young(1.0, 0.3).unwrap());
    let heights = Array2::from_shape_fn((33, 31), |(i, j)| 0.01 * ((i * i + 3 * j) as f64).sin());
    let wall = Interface::in_all_components(&body, &grid, &heights, gfmd_law::HardWall).unwrap();
    // A coefficient or a strength of zero is no friction.
    let orowan = Limit::Orowan { coefficient: 0.3, strength: 0.0 };
    for limit in [Limit::Coulomb(0.0), Limit::Tresca(0.0), orowan] {
        let contact = periodic(&body, &grid, &heights, limit);
        for load in [Load::MeanPressure(0.02), Load::Approach(0.008)] {
            let a = solve(&contact, load, None);
            let b = wall.press(load).tolerance(1e-10).solve().unwrap();
            assert!((&a.gap() - &b.gap).iter().all(|e| e.abs() < 1e-9) && (a.approach() - b.approach).abs() < 1e-9);
            let drive = Drive { lateral: [0.01, 0.02], ..load.into() };
            let moved = contact.press(drive).tolerance(1e-10).starting_from(Some(&a)).solve().unwrap();
            assert_eq!((moved.mean_shear, moved.losses.friction), ([0.0; 2], 0.0), "{limit:?}");
            approx::assert_relative_eq!(moved.mean_pressure(), a.mean_pressure(), max_relative = 1e-9);
        }
    }
}

#[test]
fn bad_input_is_refused_with_what_was_found() {
    let (body, grid) = (Body::half_space(Material::from_contact_modulus(1.0, 0.5).unwrap()), Grid::line(16, 1.0));
    let grid = grid.unwrap();
    let heights = wave(16);
    let make = |heights: &Array2<f64>, coefficient| {
        let shear = Some(Limit::Coulomb(coefficient).into());
        QuasistaticContact::new(&Parts { shear, ..Parts::new(&body, &grid, heights) })
    };
    let contact = make(&heights, 0.4).unwrap();
    let message = |drive: Drive| contact.press(drive).solve().unwrap_err().to_string();
    assert_eq!(message(pressed(-0.1, 0.0)), "the mean pressure is -0.1; it must be positive and finite");
    assert_eq!(message(pressed(0.1, f64::NAN)), "the lateral displacement is NaN; it must be finite");
    assert!(message(Load::Approach(1.0).into()).contains("less than the mean clearance"));
    assert!(matches!(make(&Array2::zeros((16, 1)), 0.4), Err(Refusal::Flat)));
    assert!(make(&heights, -0.4).unwrap_err().to_string().starts_with("mu is -0.4; "));
    let newton = contact.press(pressed(0.01, 1e-3)).solver(Solver::Newton).solve().unwrap_err();
    assert_eq!(newton.to_string(), "the solver is newton; it must be auto");
    let stopped = contact.press(pressed(0.01, 1e-3)).max_iterations(2).solve();
    assert!(matches!(stopped, Err(SolveError::NotConverged { .. })));
    let mut at_once = |_: &Progress| ControlFlow::Break(());
    let broken = contact.press(pressed(0.01, 1e-3)).watch(&mut at_once).solve();
    assert!(matches!(broken, Err(SolveError::Interrupted { .. })));
}

/// Returns a sphere of radius 1 on a half-space with E* = 1, on a patch of side 0.5 with 64² points.
fn free_sphere(poisson: f64, limit: Limit) -> QuasistaticContact {
    let (n, side) = (64, 0.5);
    let at = |i: usize| (i as f64 / n as f64 - 0.5) * side;
    let heights = Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (at(i).powi(2) + at(j).powi(2)));
    let body = Body::half_space(Material::from_contact_modulus(1.0, poisson).unwrap());
    rubbing(Boundary::Free, &body, &Grid::square(n, side).unwrap(), &heights, limit)
}

/// Returns the mean pressure over the patch of [`free_sphere`] at the contact radius `a` (Hertz).
fn hertz(a: f64) -> f64 {
    4.0 / 3.0 * a.powi(3) / 0.25
}

/// Follows `drives` from the undeformed surfaces; returns the steps and the last state.
fn along(contact: &QuasistaticContact, drives: &[Drive], solves_per_step: u64) -> (Vec<Step>, QuasistaticState) {
    let refinement = Refinement { solves_per_step, ..Refinement::default() };
    let mut path = Path::new(contact, Budget::default(), refinement);
    let steps = drives.iter().map(|drive| path.step(*drive, &mut ()).unwrap()).collect();
    (steps, path.state().unwrap().clone())
}

/// Returns the larger component of the mean shear.
fn largest_shear(state: &QuasistaticState) -> f64 {
    state.mean_shear[0].abs().max(state.mean_shear[1].abs())
}

/// Returns the sticking radius divided by the contact radius of a sphere under growing load: Spence (1975), in
/// Johnson's form (Contact Mechanics, section 5.4), (a/2c) ln((a + c)/(a − c)) = (μ/β) K(√(1 − c²/a²)), β = (1 −
/// 2ν)/(2(1 − ν)).
fn spence(coefficient: f64, poisson: f64) -> f64 {
    let beta = (1.0 - 2.0 * poisson) / (2.0 * (1.0 - poisson));
    // Complete elliptic integral K(√(1 − c²)) from the arithmetic-geometric mean of 1 and c.
    let integral = |c: f64| {
        let (mut a, mut b) = (1.0_f64, c);
        for _ in 0..40 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        0.5 * PI / a
    };
    let excess = |c: f64| ((1.0 + c) / (1.0 - c)).ln() / (2.0 * c) - coefficient / beta * integral(c);
    let (mut low, mut high) = (1e-9, 1.0 - 1e-12);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn a_sphere_under_growing_load_sticks_within_the_radius_of_spence_however_it_is_loaded() {
    // By self-similarity the ratio of the radii is the same for every load.
    let long = [(0.3, 0.3, 0.2, &[1, 2, 5][..])].into_iter().filter(|_| std::env::var_os("GFMD_LONG").is_some());
    for (coefficient, poisson, a, numbers) in [(0.3, 0.3, 0.15, &[1, 2][..])].into_iter().chain(long) {
        let contact = free_sphere(poisson, Limit::Coulomb(coefficient));
        let wanted = spence(coefficient, poisson);
        // The edge of the sticking region lies between two points.
        let spacing = 0.5 / 64.0 / a;
        let share = |state: &QuasistaticState| (stick_fraction(state) / state.summary().area_fraction).sqrt();
        for steps in numbers {
            let drives: Vec<Drive> =
                (1..=*steps).map(|k| pressed(hertz(a) * f64::from(k) / f64::from(*steps), 0.0)).collect();
            // The default number of solves suffices.
            let (made, state) = along(&contact, &drives, Refinement::default().solves_per_step);
            let found = share(&state);
            assert!((found - wanted).abs() < spacing, "{coefficient} {poisson} {a}, {steps} steps: {found} {wanted}");
            assert!(made.iter().all(|step| !step.is_unsettled && step.change <= Some(1e-3)), "{made:?}");
            // By symmetry there is no mean shear; increments on the way are solved to 1e-4.
            assert!(largest_shear(&state) < 1e-5 * state.mean_pressure(), "{:e}", largest_shear(&state));
        }
        let one = share(&contact.press(pressed(hertz(a), 0.0)).solve().unwrap());
        assert!(one < wanted - 5.0 * spacing, "one increment: {one} {wanted}");
        let exact: Vec<Drive> = (1..=4).map(|k| pressed(hertz(a) * f64::from(k) / 4.0, 0.0)).collect();
        let (_, state) = along(&contact, &exact, 0);
        assert!(largest_shear(&state) < 1e-6 * state.mean_pressure(), "{:e}", largest_shear(&state));
    }
}

#[test]
fn a_sphere_loaded_unloaded_and_loaded_again_ends_alike_in_one_and_in_three_steps_each() {
    let contact = free_sphere(0.3, Limit::Coulomb(0.3));
    let waypoints = [0.2, 0.1, 0.2].map(hertz);
    let ends = [1_u32, 3].map(|steps| {
        let mut drives = Vec::new();
        let mut from = 0.0;
        for to in waypoints {
            let of_step = |k: u32| pressed(from + (to - from) * f64::from(k) / f64::from(steps), 0.0);
            drives.extend((1..=steps).map(of_step));
            from = to;
        }
        let (made, state) = along(&contact, &drives, 12);
        assert!(made.iter().all(|step| !step.is_unsettled), "{made:?}");
        state
    });
    // Energy of the difference of the shear, divided by the energy of a shear at its limit everywhere.
    let [a, b] = &ends;
    let difference: Vec<f64> = traction(a).iter().zip(traction(b)).map(|(a, b)| a - b).collect();
    let material = Material::from_contact_modulus(1.0, 0.3).unwrap();
    let compliance = FreeFullCompliance::new(Grid::square(64, 0.5).unwrap(), &Body::half_space(material)).unwrap();
    let mut displacement = vec![0.0; difference.len()];
    FreeFullTransforms::of(&compliance.into()).compliance(&difference, &mut displacement);
    let apart = difference.iter().zip(&displacement).map(|(t, u)| t * u).sum::<f64>();
    let apart = 0.5 * apart / b.gap().len() as f64 / (0.3_f64.powi(2) * b.elastic_energy());
    assert!(apart.abs() < 1e-3, "{apart:e}");
    let [a, b] = ends.map(|state| (stick_fraction(&state) / state.summary().area_fraction).sqrt());
    // Grid spacing divided by the radius.
    assert!((a - b).abs() < 0.5 / 64.0 / 0.2, "{a} {b}");
}

#[test]
fn the_energy_lost_by_slip_under_growing_load_is_that_of_many_small_increments() {
    let contact = free_sphere(0.3, Limit::Coulomb(0.3));
    let load = hertz(0.2);
    let lost_in = |increments: u32| {
        let (mut last, mut lost): (Option<QuasistaticState>, f64) = (None, 0.0);
        for k in 1..=increments {
            let drive = pressed(load * f64::from(k) / f64::from(increments), 0.0);
            let state = contact.press(drive).starting_from(last.as_ref()).solve().unwrap();
            lost += state.losses.total();
            last = Some(state);
        }
        (lost, last.unwrap())
    };
    let (many, finest) = lost_in(32);
    let (one, _) = lost_in(1);
    assert!(one > 10.0 * many, "one increment is far off: {one:e}, {many:e}");
    let (steps, state) = along(&contact, &[pressed(load, 0.0)], 4);
    let [lost, error] = [steps[0].dissipated, steps[0].dissipated_error].map(Option::unwrap);
    assert!((lost - many).abs() <= error && error < 0.1 * one, "{lost:e} ± {error:e}, {many:e}");
    assert!(steps[0].increments >= 8 && steps[0].extra_solves > steps[0].increments);
    // Difference of the shear divided by its limit.
    let shear = |state: &QuasistaticState| state.shear(0).unwrap().to_owned();
    let apart = (shear(&state) - shear(&finest)).iter().map(|t| t.abs()).sum::<f64>();
    assert!(apart < 0.03 * 0.3 * state.pressure().sum(), "{apart:e}");
    // Without extra solves a path reports that its change is unknown.
    let (steps, _) = along(&contact, &[pressed(load, 0.0)], 0);
    assert!(steps[0].change.unwrap().is_nan());
    assert!(steps[0].dissipated_error.is_none());
    assert!(steps[0].increments == 1);
}

#[test]
fn a_sphere_pressed_and_sheared_at_once_sticks_as_mindlin_and_deresiewicz_say() {
    // 1953: under a force that grows within the cone of friction nothing slips, and dQ/dP = (2/3) dX/dδ for ν = ½. With
    // X in proportion to P, and δ to P^⅔, Q/P = (9/8) (2/3) X/δ. If the pressure comes first, as in one increment, the
    // edge slips (Cattaneo): Q/P = μ (1 − (1 − (2/3) X/(μ δ))^(3/2)).
    let contact = free_sphere(0.5, Limit::Coulomb(0.3));
    let (a, ratio) = (0.2_f64, 0.15);
    let drive = pressed(hertz(a), 1.5 * ratio * a * a);
    let (steps, state) = along(&contact, &[drive], 8);
    let found = state.mean_shear[0] / state.mean_pressure();
    let exact = 1.125 * ratio;
    assert!((found - exact).abs() < 0.03 * exact, "{found} {exact} {steps:?}");
    let one = contact.press(drive).solve().unwrap();
    let found = one.mean_shear[0] / one.mean_pressure();
    let cattaneo = 0.3 * (1.0 - (1.0_f64 - ratio / 0.3).powf(1.5));
    assert!((found - cattaneo).abs() < 0.03 * cattaneo && cattaneo > 1.1 * exact, "{found} {cattaneo}");
}

#[test]
fn what_does_not_depend_on_the_way_is_solved_once() {
    let load = hertz(0.2);
    let drives = [pressed(load, 0.0), pressed(0.5 * load, 0.0), pressed(0.5 * load, 1e-3), pressed(0.5 * load, -1e-3)];
    // Without coupling, and with constant limits or without shear.
    let (steps, _) = along(&free_sphere(0.5, Limit::Coulomb(0.3)), &drives, 4);
    for step in steps {
        assert_eq!((step.extra_solves, step.increments, step.change, step.dissipated_error), (0, 1, None, None));
    }
    // Without friction.
    let (steps, _) = along(&free_sphere(0.2, Limit::Coulomb(0.0)), &drives, 4);
    assert!(steps.iter().all(|step| step.extra_solves == 0 && step.dissipated == Some(0.0)));
    // Constant shear strength without a change of load.
    let (steps, _) = along(&free_sphere(0.5, Limit::Tresca(0.02)), &[drives[0], pressed(load, 1e-3)], 4);
    assert!(steps.iter().all(|step| step.extra_solves == 0));
    // The sheared contact grows under a higher load: this depends on the path.
    let (steps, _) = along(&free_sphere(0.5, Limit::Coulomb(0.3)), &[drives[2], pressed(load, 2e-3)], 4);
    assert!(steps[1].extra_solves > 0 && steps[1].change.unwrap() <= 1e-3, "{steps:?}");
}
