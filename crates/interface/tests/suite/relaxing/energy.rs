//! Energy balance, and bounds that hold for steps of any duration.

use gfmd_contact::{Boundary, Contact, Drive, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{QuasistaticContact, QuasistaticState};
use gfmd_medium::{Medium as _, Prony, Relaxes, Relaxing};
use ndarray::Array2;

use super::{follow, on, relaxing, three};
use crate::{Numbers, legs, material, rough};

/// Random contact.
struct Random {
    contact: QuasistaticContact,
    /// Contact with the long-term moduli.
    elastic: Contact,
    medium: Relaxing,
    body: Body,
}

impl Random {
    /// Returns the largest difference between the displacement by `pressure`, with the long-term moduli, and the
    /// displacement by the memory, divided by the largest displacement or elongation.
    fn mismatch(&self, pressure: &Array2<f64>, memory: &[Array2<f64>]) -> f64 {
        let expected = self.elastic.certify(pressure, Load::Approach(0.0)).unwrap().displacement;
        let found = self.medium.long_term_indentation(memory).unwrap();
        // NaN counts as the largest value.
        let larger = |most: f64, x: f64| if x > most || x.is_nan() { x } else { most };
        let apart = found.iter().zip(&expected).map(|(d, u)| (d + u).abs()).fold(0.0, larger);
        apart / expected.iter().chain(memory.iter().flatten()).map(|x| x.abs()).fold(0.0, larger)
    }
}

/// Returns a random contact.
fn random(case: u64, numbers: &mut Numbers) -> Random {
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
    let contact = on(boundary, &body, &grid, &heights, &prony, relaxes);
    let elastic = Contact::with_boundary(boundary, &body, &grid, &heights).unwrap();
    let medium = Relaxing::new(&body, &grid, boundary, 1, &prony, relaxes).unwrap();
    Random { contact, elastic, medium, body }
}

fn step(contact: &QuasistaticContact, load: Load, time: f64, start: Option<&QuasistaticState>) -> QuasistaticState {
    let press = contact.press(Drive::from(load).at(time)).tolerance(1e-10).starting_from(start);
    press.solve().unwrap()
}

#[test]
fn energy_is_never_gained_in_random_steps_and_the_work_of_the_pressure_is_accounted_for() {
    for case in 0..300 {
        let mut numbers = Numbers(case + 17);
        let Random { contact, .. } = random(case, &mut numbers);
        let clearance = contact.surface().mean_clearance();
        let by_load = numbers.next() < 0.5;
        let load = |numbers: &mut Numbers| match by_load {
            true => Load::MeanPressure(0.001 + 0.05 * numbers.next()),
            false => Load::Approach(0.8 * clearance * numbers.next() + 1e-4),
        };
        let mut time = 0.0;
        let mut last: Option<QuasistaticState> = None;
        let mut held = load(&mut numbers);
        for index in 0..6 {
            time += if index % 4 == 1 { 0.0 } else { 10.0_f64.powf(5.0 * numbers.next() - 3.0) };
            if index % 3 != 2 {
                held = load(&mut numbers);
            }
            let state = step(&contact, held, time, last.as_ref());
            assert!(state.losses.total() >= 0.0 && state.elastic_energy() >= 0.0);
            let (pressure, approach, stored) = last
                .as_ref()
                .map_or((0.0, 0.0, 0.0), |last| (last.mean_pressure(), last.approach(), last.elastic_energy()));
            let scale = state.elastic_energy().max(stored) + (state.mean_pressure() * state.approach()).abs();
            // The work of the last pressure bounds the stored energy, for any duration (theory.md, section 7.7).
            let bound = state.mean_pressure() * (state.approach() - approach);
            let gained = state.elastic_energy() - stored;
            assert!(gained <= bound + 1e-8 * scale, "case {case}, step {index}: {gained:e} gained, {bound:e} allowed");
            // Work of the pressure by the trapezoidal rule; p and d are not linear in time together.
            let work = 0.5 * (pressure + state.mean_pressure()) * (state.approach() - approach);
            let missing = (work - gained - state.losses.total()).abs();
            let reported = if last.as_ref().is_some_and(|last| last.time == time) { 0.0 } else { missing };
            assert!((state.work_imbalance - reported).abs() <= 1e-12 * scale, "case {case}, step {index}");
            last = Some(state);
        }
    }
}

#[test]
fn the_error_of_a_loop_falls_with_the_square_of_the_steps() {
    let grid = Grid::square(16, 1.0).unwrap();
    let (heights, prony) = (rough(&grid, 3), three());
    for (body, relaxes) in [
        (Body::half_space(material(0.35)), Relaxes::Both),
        (Body::half_space(material(0.35)), Relaxes::Shear),
        (Body::slab(material(0.35), 0.4).unwrap(), Relaxes::Shear),
    ] {
        let contact = relaxing(&body, &grid, &heights, &prony, relaxes);
        let sum = |steps: usize| -> f64 {
            let path = legs(&[0.03, 0.005], &[1.0, 1.0], steps, Load::MeanPressure);
            follow(&contact, &path, 1e-11).iter().map(|state| state.work_imbalance).sum()
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
        let random = random(case, &mut numbers);
        let contact = &random.contact;
        let first = step(contact, Load::MeanPressure(0.02), 0.3, None);
        let second = step(contact, Load::MeanPressure(0.03), 0.5, Some(&first));
        let memory = second.memory().unwrap();
        assert_eq!(memory.len(), 1 + random.medium.branches());
        let apart = random.mismatch(&second.pressure().to_owned(), &memory);
        assert!(apart <= 1e-10, "case {case}: {apart:e}");
        let energy = random.medium.elastic_energy(&random.body, &memory).unwrap();
        assert_eq!(energy.is_none(), contact.boundary() == Boundary::Free);
        if let Some(energy) = energy {
            let stored = second.elastic_energy();
            assert!((energy - stored).abs() <= 1e-8 * stored, "case {case}: {energy:e} {stored:e}");
        }
        let other = random.mismatch(&first.pressure().to_owned(), &memory);
        assert!(other > 1e-3, "case {case}: {other:e}");
    }
}
