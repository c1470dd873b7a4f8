//! Energy balance, and bounds that hold for steps of any duration.

use gfmd_contact::{Boundary, Contact, Drive, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_viscoelastic::{Prony, Relaxes, ViscoelasticContact, ViscoelasticState};

use crate::{material, rough};

/// Generator of random numbers between 0 and 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Returns a random contact with its mean clearance and body.
fn random(case: u64, numbers: &mut Numbers) -> (ViscoelasticContact, f64, Body) {
    let grid = match case % 4 {
        0 => Grid::line(16 + (case % 3) as usize, 1.0).unwrap(),
        1 => Grid::new([10, 9], [1.0, 0.8]).unwrap(),
        _ => Grid::square(12, 1.0).unwrap(),
    };
    let relaxes = if case.is_multiple_of(3) { Relaxes::Shear } else { Relaxes::Both };
    let poisson = if case.is_multiple_of(7) { 0.5 } else { 0.45 * numbers.next() };
    let body = match case % 5 {
        0 | 1 => Body::half_space(material(poisson)),
        _ => Body::slab(material(poisson), 0.05 + numbers.next()).unwrap(),
    };
    let count = 1 + (case % 3) as i32;
    let pairs: Vec<(f64, f64)> = (0..count)
        .map(|k| {
            (10.0_f64.powf(2.0 * f64::from(k) - 3.0 + numbers.next()), 0.9 / f64::from(count) * numbers.next() + 1e-3)
        })
        .collect();
    let prony = Prony::from_fractions(&pairs).unwrap();
    let is_free = case % 11 == 2 && grid.points()[1] > 1 && (relaxes == Relaxes::Both || case % 5 < 2);
    let boundary = if is_free { Boundary::Free } else { Boundary::Periodic };
    let heights = rough(&grid, case);
    let contact = Contact::with_boundary(boundary, &body, &grid, &heights).unwrap();
    let clearance = contact.surface().mean_clearance();
    (ViscoelasticContact::new(contact, &body, &prony, relaxes).unwrap(), clearance, body)
}

fn step(contact: &ViscoelasticContact, load: Load, time: f64, start: Option<&ViscoelasticState>) -> ViscoelasticState {
    let press = contact.press(Drive::from(load).at(time)).tolerance(1e-10).starting_from(start);
    press.solve().unwrap()
}

#[test]
fn energy_is_never_gained_in_random_steps_and_the_work_of_the_pressure_is_accounted_for() {
    for case in 0..300 {
        let mut numbers = Numbers(case + 17);
        let (contact, clearance, _) = random(case, &mut numbers);
        let by_load = numbers.next() < 0.5;
        let load = |numbers: &mut Numbers| match by_load {
            true => Load::MeanPressure(0.001 + 0.05 * numbers.next()),
            false => Load::Approach(0.8 * clearance * numbers.next() + 1e-4),
        };
        let mut time = 0.0;
        let mut last: Option<ViscoelasticState> = None;
        let mut held = load(&mut numbers);
        for index in 0..6 {
            time += if index % 4 == 1 { 0.0 } else { 10.0_f64.powf(5.0 * numbers.next() - 3.0) };
            if index % 3 != 2 {
                held = load(&mut numbers);
            }
            let state = step(&contact, held, time, last.as_ref());
            assert!(state.dissipated >= 0.0 && state.elastic_energy >= 0.0);
            let (pressure, approach, stored) = last.as_ref().map_or((0.0, 0.0, 0.0), |last| {
                (last.solution.mean_pressure, last.solution.approach, last.elastic_energy)
            });
            let scale =
                state.elastic_energy.max(stored) + (state.solution.mean_pressure * state.solution.approach).abs();
            // The work of the last pressure bounds the stored energy, for any duration (theory.md, section 7.7).
            let bound = state.solution.mean_pressure * (state.solution.approach - approach);
            let gained = state.elastic_energy - stored;
            assert!(gained <= bound + 1e-8 * scale, "case {case}, step {index}: {gained:e} gained, {bound:e} allowed");
            // Work of the pressure by the trapezoidal rule; p and d are not linear in time together.
            let work = 0.5 * (pressure + state.solution.mean_pressure) * (state.solution.approach - approach);
            let missing = (work - gained - state.dissipated).abs();
            let reported = if last.as_ref().is_some_and(|last| last.time == time) { 0.0 } else { missing };
            assert!((state.work_imbalance - reported).abs() <= 1e-12 * scale, "case {case}, step {index}");
            last = Some(state);
        }
    }
}

#[test]
fn the_error_of_a_loop_falls_with_the_square_of_the_steps() {
    let grid = Grid::square(16, 1.0).unwrap();
    let (heights, prony) = (rough(&grid, 3), crate::three());
    for (body, relaxes) in [
        (Body::half_space(material(0.35)), Relaxes::Both),
        (Body::half_space(material(0.35)), Relaxes::Shear),
        (Body::slab(material(0.35), 0.4).unwrap(), Relaxes::Shear),
    ] {
        let contact = crate::viscoelastic(&body, &grid, &heights, &prony, relaxes);
        let sum = |steps: usize| -> f64 {
            let path = crate::legs(&[0.03, 0.005], &[1.0, 1.0], steps, Load::MeanPressure);
            crate::follow(&contact, &path, 1e-11).iter().map(|state| state.work_imbalance).sum()
        };
        let [coarse, fine] = [8, 32].map(sum);
        let order = 0.5 * (coarse / fine).log2();
        assert!((1.8..3.3).contains(&order), "order {order}: {coarse:e}, {fine:e}");
    }
}

#[test]
fn the_memory_gives_the_pressure_back() {
    for case in 0..12 {
        let mut numbers = Numbers(case + 5);
        let (contact, _, body) = random(case, &mut numbers);
        let first = step(&contact, Load::MeanPressure(0.02), 0.3, None);
        let second = step(&contact, Load::MeanPressure(0.03), 0.5, Some(&first));
        let memory = second.memory();
        let apart = contact.consistency(&second.solution.pressure, &memory).unwrap();
        assert!(apart <= 1e-10, "case {case}: {apart:e}");
        let energy = contact.elastic_energy(&body, &memory).unwrap();
        assert_eq!(energy.is_none(), contact.contact().boundary() == Boundary::Free);
        if let Some(energy) = energy {
            let stored = second.elastic_energy;
            assert!((energy - stored).abs() <= 1e-8 * stored, "case {case}: {energy:e} {stored:e}");
        }
        let other = contact.consistency(&first.solution.pressure, &memory).unwrap();
        assert!(other > 1e-3, "case {case}: {other:e}");
    }
}
