//! Exact solutions: relaxation, creep, loading and unloading from static solutions, and the sphere.

use approx::assert_relative_eq;
use gfmd_contact::{Boundary, Contact, Drive, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_medium::{Prony, Relaxes};
use ndarray::Array2;

use super::{follow, on, one, relaxing, three};
use crate::{legs, material, rough};

#[test]
fn relaxation_under_a_held_approach_is_exact_in_steps_of_any_length() {
    let grid = Grid::square(16, 1.0).unwrap();
    let heights = rough(&grid, 1);
    for body in [Body::half_space(material(0.3)), Body::slab(material(0.3), 0.3).unwrap()] {
        let contact = relaxing(&body, &grid, &heights, &three(), Relaxes::Both);
        let held = Load::Approach(0.015);
        let states = follow(&contact, &[(held, 0.0), (held, 0.01), (held, 3.0), (held, 3.1), (held, 1e4)], 1e-13);
        let fixed = Contact::new(&body, &grid, &heights).unwrap().press(held).tolerance(1e-13).solve().unwrap();
        for state in &states {
            let expected = three().relaxation(state.time) * fixed.mean_pressure;
            assert_relative_eq!(state.mean_pressure(), expected, max_relative = 1e-11);
            assert_eq!(state.summary().contact_nodes, fixed.summary().contact_nodes);
        }
    }
}

#[test]
fn creep_passes_through_the_statics_with_the_modulus_of_its_time() {
    // Lee and Radok: while the contact grows, it is an elastic contact with the modulus 1/J(t). The steps converge with
    // order 2.
    let grid = Grid::square(16, 1.0).unwrap();
    let heights = rough(&grid, 2);
    let body = Body::half_space(material(0.35));
    for prony in [one(), three()] {
        let contact = relaxing(&body, &grid, &heights, &prony, Relaxes::Both);
        let (load, end) = (Load::MeanPressure(0.012), 2.0);
        let softer = Material::from_young(2.0 / prony.creep(end), 0.35).unwrap();
        let softer = Contact::new(&Body::half_space(softer), &grid, &heights).unwrap();
        let expected = softer.press(load).tolerance(1e-12).solve().unwrap();
        let error = |steps: u32| {
            let path: Vec<(Load, f64)> = (0..=steps).map(|k| (load, end * f64::from(k) / f64::from(steps))).collect();
            let last = follow(&contact, &path, 1e-12).pop().unwrap();
            (last.approach() - expected.approach).abs()
        };
        let [coarse, fine] = [16, 64].map(error);
        let order = 0.5 * (coarse / fine).log2();
        assert!((1.8..2.3).contains(&order), "order {order}: {coarse:e}, {fine:e}");
        assert!(fine <= 1e-4 * expected.approach, "{fine:e} of {:e}", expected.approach);
    }
}

/// Finds the time t₁, during loading to `turn` in unit time, at which the area equals the area at the end of unloading
/// to `end` within `duration` (Ting 1966).
fn equal_area(prony: &Prony, turn: f64, end: f64, duration: f64) -> f64 {
    let t = 1.0 + duration;
    // ∫_{t₁}^t ψ(t − t') δ̇ dt' = 0, with ∫ψ in closed form.
    let whole = |from: f64, to: f64| {
        let of =
            |b: &gfmd_medium::Branch| b.weight * b.time * ((-(t - to) / b.time).exp() - (-(t - from) / b.time).exp());
        (to - from) + prony.branches().iter().map(of).sum::<f64>()
    };
    let rate = (end - turn) / duration;
    let balance = |first: f64| turn * whole(first, 1.0) + rate * whole(1.0, t);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *if balance(middle) > 0.0 { &mut low } else { &mut high } = middle;
    }
    low
}

/// Computes Ting's solution at the end of the unloading: the approach at which the loading had the present area, and
/// the mean pressure ∫₀^{t₁} ψ(t − t') dp_el(δ(t')), from static solutions.
fn ting(prony: &Prony, fixed: &Contact, turn: f64, end: f64, duration: f64) -> (f64, f64) {
    let (t, low) = (1.0 + duration, equal_area(prony, turn, end, duration));
    let steps = 400;
    let pressure = |time: f64| {
        if time <= 0.0 {
            0.0
        } else {
            fixed.press(Load::Approach(turn * time)).tolerance(1e-10).solve().unwrap().mean_pressure
        }
    };
    let mut sum = 0.0;
    let mut before = 0.0;
    for k in 1..=steps {
        let time = low * f64::from(k) / f64::from(steps);
        let now = pressure(time);
        sum += prony.relaxation(t - (time - 0.5 * low / f64::from(steps))) * (now - before);
        before = now;
    }
    (turn * low, sum)
}

#[test]
fn unloading_follows_ting_with_order_two() {
    let grid = Grid::square(16, 1.0).unwrap();
    let heights = rough(&grid, 4);
    let body = Body::half_space(material(0.35));
    let fixed = Contact::new(&body, &grid, &heights).unwrap();
    let turn = 0.6 * fixed.surface().mean_clearance();
    let end = 0.75 * turn;
    let (equivalent, expected) = ting(&three(), &fixed, turn, end, 0.4);
    let contact = relaxing(&body, &grid, &heights, &three(), Relaxes::Both);
    let last = |steps: usize| {
        let path = legs(&[turn, end], &[1.0, 0.4], steps, Load::Approach);
        follow(&contact, &path, 1e-11).pop().unwrap()
    };
    let states = [10, 20, 40, 80].map(last);
    let same = fixed.press(Load::Approach(equivalent)).tolerance(1e-11).solve().unwrap();
    assert_eq!(states[3].summary().contact_nodes, same.summary().contact_nodes);
    let errors: Vec<f64> = states.iter().map(|state| (state.mean_pressure() - expected).abs() / expected).collect();
    // The reference has its own error, from 400 steps.
    assert!(errors[3] < 2e-4, "{errors:?}");
    let apart = |k: usize| (states[k].mean_pressure() - states[k + 1].mean_pressure()).abs();
    let order = (apart(0) / apart(2)).log2() / 2.0;
    assert!((1.6..2.5).contains(&order), "order {order}, {errors:?}");
}

#[test]
fn a_sphere_creeps_as_lee_and_radok_found() {
    // a³ = (3R/4) P J(t)/E*, δ = a²/R on a free half-space; the remaining errors are grid errors.
    let radius = 1.0;
    let prony = Prony::from_fractions(&[(1.0, 0.7)]).unwrap();
    let worst = |n: usize| {
        let grid = Grid::square(n, 0.4).unwrap();
        let place = |i: usize| 0.4 * (i as f64 / n as f64 - 0.5);
        let heights = Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (place(i).powi(2) + place(j).powi(2)) / radius);
        let body = Body::half_space(Material::from_contact_modulus(1.0, 0.4).unwrap());
        let contact = on(Boundary::Free, &body, &grid, &heights, &prony, Relaxes::Both);
        let force = 1e-3;
        let load = Load::MeanPressure(force / 0.16);
        let mut state = contact.press(load).tolerance(1e-10).solve().unwrap();
        let mut worst: f64 = 0.0;
        for step in 0..=24 {
            if step > 0 {
                let drive = Drive::from(load).at(4.0 * f64::from(step) / 24.0);
                state = contact.press(drive).tolerance(1e-10).starting_from(Some(&state)).solve().unwrap();
            }
            let a = (0.75 * radius * force * prony.creep(state.time)).cbrt();
            worst = worst.max((state.approach() / (a * a / radius) - 1.0).abs());
        }
        worst
    };
    let [coarse, fine] = [32, 64].map(worst);
    assert!(fine < 6e-3 && fine < 0.7 * coarse, "{coarse:e}, {fine:e}");
}

#[test]
fn a_sphere_is_loaded_and_unloaded_as_ting_found() {
    // While the approach grows, a² = R δ and P = (4/3) E* √R ∫ ψ(t − t') d(δ^{3/2}); when it falls, a is the radius at
    // time t₁, where the integral ends.
    let (radius, side, turn, duration) = (1.0_f64, 0.4_f64, 0.012_f64, 0.6);
    let prony = Prony::from_fractions(&[(0.4, 0.6)]).unwrap();
    let force = |first: f64, t: f64| {
        // Integral in s = √t' by Simpson's rule: d(δ^{3/2}) = 3 turn^{3/2} s² ds.
        let n = 400;
        let end = first.sqrt();
        let of = |k: u32| {
            let s = end * f64::from(k) / f64::from(n);
            prony.relaxation(t - s * s) * 3.0 * s * s * if k == 0 || k == n { 1.0 } else { f64::from(2 + 2 * (k % 2)) }
        };
        4.0 / 3.0 * (radius * turn.powi(3)).sqrt() * (0..=n).map(of).sum::<f64>() * end / f64::from(3 * n)
    };
    let worst = |n: usize| {
        let grid = Grid::square(n, side).unwrap();
        let place = |i: usize| side * (i as f64 / n as f64 - 0.5);
        let heights = Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (place(i).powi(2) + place(j).powi(2)) / radius);
        let body = Body::half_space(Material::from_contact_modulus(1.0, 0.4).unwrap());
        let contact = on(Boundary::Free, &body, &grid, &heights, &prony, Relaxes::Both);
        let steps = 16;
        let path = legs(&[turn, 0.4 * turn], &[1.0, duration], steps, Load::Approach);
        let states = follow(&contact, &path, 1e-10);
        let mut worst = [0.0_f64; 3];
        for state in states.iter().skip(steps / 2 - 1) {
            let first = match state.time {
                time if time <= 1.0 => time,
                time => {
                    let end = turn * (1.0 - 0.6 * (time - 1.0) / duration);
                    equal_area(&prony, turn, end, time - 1.0)
                }
            };
            let expected = force(first, state.time) / (side * side);
            let area = std::f64::consts::PI * radius * turn * first / (side * side);
            let load = (state.mean_pressure() / expected - 1.0).abs();
            let which = usize::from(state.time > 1.0);
            worst[which] = worst[which].max(load);
            // Contact radius in grid spacings.
            let radius = |area: f64| (area / std::f64::consts::PI).sqrt() * n as f64;
            worst[2] = worst[2].max((radius(state.summary().area_fraction) - radius(area)).abs());
        }
        worst
    };
    let [coarse, fine] = [32, 64].map(worst);
    assert!(fine[0] < 1e-3 && fine[0] < 0.7 * coarse[0], "loading: {coarse:?}, {fine:?}");
    assert!(fine[1] < 3e-3 && fine[1] < 0.7 * coarse[1], "unloading: {coarse:?}, {fine:?}");
    assert!(coarse[2] < 1.0 && fine[2] < 1.0, "radius in spacings: {coarse:?}, {fine:?}");
}

#[test]
fn units_of_time_do_not_matter() {
    let grid = Grid::square(12, 1.0).unwrap();
    let heights = rough(&grid, 6);
    let body = Body::slab(material(0.3), 0.4).unwrap();
    let last = |unit: f64| {
        let prony = Prony::from_fractions(&[(0.05 * unit, 0.3), (0.7 * unit, 0.25)]).unwrap();
        let contact = relaxing(&body, &grid, &heights, &prony, Relaxes::Shear);
        let path: Vec<(Load, f64)> = [0.1, 0.3, 2.0].iter().map(|t| (Load::MeanPressure(0.02), t * unit)).collect();
        follow(&contact, &path, 1e-11).pop().unwrap()
    };
    let one = last(1.0);
    for unit in [1e9, 1e-9] {
        let other = last(unit);
        assert_relative_eq!(other.approach(), one.approach(), max_relative = 1e-10);
        assert_relative_eq!(other.losses.total(), one.losses.total(), max_relative = 1e-8);
    }
}
