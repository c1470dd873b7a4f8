//! Wear volume, energy balance, and independence of units, in random cases.

use approx::assert_relative_eq;
use gfmd_contact::{Boundary, Drive, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{QuasistaticContact, QuasistaticState};

use super::{follow, held, on, wearing};
use crate::{Numbers, material, rough};

/// Returns a random contact and its wear coefficient.
fn random(case: u64, numbers: &mut Numbers) -> (QuasistaticContact, f64) {
    let grid = match case % 4 {
        0 => Grid::line(16 + (case % 3) as usize, 1.0).unwrap(),
        1 => Grid::new([10, 9], [1.0, 0.8]).unwrap(),
        _ => Grid::square(12, 1.0).unwrap(),
    };
    let material = material(if case.is_multiple_of(7) { 0.5 } else { 0.45 * numbers.next() });
    let body = match case % 3 {
        0 => Body::half_space(material),
        _ => Body::slab(material, 0.05 + numbers.next()).unwrap(),
    };
    let is_free = case % 5 == 2 && grid.points()[1] > 1;
    let boundary = if is_free { Boundary::Free } else { Boundary::Periodic };
    let coefficient = 10.0_f64.powf(4.0 * numbers.next() - 3.0);
    (on(boundary, &body, &grid, &rough(&grid, case), coefficient), coefficient)
}

#[test]
fn volume_and_energy_are_accounted_for_in_random_steps() {
    for case in 0..200 {
        let mut numbers = Numbers::of(case + 17);
        let (contact, coefficient) = random(case, &mut numbers);
        let by_load = numbers.next() < 0.6;
        let load = |numbers: &mut Numbers| match by_load {
            true => Load::MeanPressure(0.001 + 0.05 * numbers.next()),
            false => Load::Approach(0.6 * contact.surface().mean_clearance() * numbers.next() + 1e-4),
        };
        let (mut distance, mut volume) = (0.0, 0.0);
        let mut last: Option<QuasistaticState> = None;
        let mut now = load(&mut numbers);
        for index in 0..6 {
            let moved = if index % 4 == 1 { 0.0 } else { 10.0_f64.powf(4.0 * numbers.next() - 3.0) };
            distance += moved;
            if index % 3 != 2 {
                now = load(&mut numbers);
            }
            let press = contact.press(Drive::from(now).after(distance)).tolerance(1e-10);
            let state = press.starting_from(last.as_ref()).solve().unwrap();
            let (pressure, approach, stored, before) = last.as_ref().map_or((0.0, 0.0, 0.0, 0.0), |last| {
                (last.mean_pressure(), last.approach(), last.elastic_energy(), last.distance)
            });
            volume += coefficient * state.mean_pressure() * (state.distance - before);
            let (found, deepest) = state.wear_volume_and_depth().unwrap();
            assert_relative_eq!(found, volume, max_relative = 1e-12);
            assert!(state.losses.total() >= 0.0 && deepest >= found * (1.0 - 1e-12), "case {case}");
            let scale = state.elastic_energy().max(stored)
                + state.losses.total()
                + (state.mean_pressure() * state.approach()).abs();
            let missing = 0.5 * (pressure + state.mean_pressure()) * (state.approach() - approach)
                - (state.elastic_energy() - stored)
                - state.losses.total();
            let reported = if moved == 0.0 { 0.0 } else { missing.abs() };
            assert!((state.work_imbalance - reported).abs() <= 1e-12 * scale, "case {case}, step {index}");
            // The work of the load at the end of a step bounds the energy gained and lost, for steps of any length
            // (theory.md, section 7.10).
            let bound = state.mean_pressure() * (state.approach() - approach);
            let gained = state.elastic_energy() - stored + state.losses.total();
            assert!(gained <= bound + 1e-8 * scale, "case {case}, step {index}: {gained:e} gained, {bound:e} allowed");
            last = Some(state);
        }
    }
}

#[test]
fn the_errors_of_the_energy_add_up_to_one_of_order_one() {
    let grid = Grid::square(16, 1.0).unwrap();
    for body in [Body::half_space(material(0.35)), Body::slab(material(0.35), 0.4).unwrap()] {
        let contact = wearing(&body, &grid, &rough(&grid, 3), 0.3);
        let sum = |steps: u32| {
            let states = follow(&contact, &held(Load::MeanPressure(0.02), 1.0, steps), 1e-11);
            states.iter().map(|state| state.work_imbalance).sum::<f64>()
        };
        // Sums over all steps: a quarter of the step length takes four times the steps.
        let [coarse, fine] = [16, 64].map(sum);
        let order = 0.5 * (coarse / fine).log2();
        assert!((0.9..1.4).contains(&order), "order {order}: {coarse:e}, {fine:e}");
    }
}

#[test]
fn units_do_not_matter() {
    let grid = Grid::square(12, 1.0).unwrap();
    let heights = rough(&grid, 6);
    let path = held(Load::MeanPressure(0.02), 1.0, 4);
    let one = follow(&wearing(&Body::slab(material(0.3), 0.4).unwrap(), &grid, &heights, 0.3), &path, 1e-11).pop();
    let one = one.unwrap();
    for (length, stress) in [(1e-6, 1e9), (1e4, 1e-3)] {
        let soft = gfmd_green::Material::from_young(2.0 * stress, 0.3).unwrap();
        let scaled = Grid::square(12, length).unwrap();
        let body = Body::slab(soft, 0.4 * length).unwrap();
        let contact = wearing(&body, &scaled, &(length * &heights), 0.3 / stress);
        let path: Vec<(Load, f64)> =
            path.iter().map(|(_, distance)| (Load::MeanPressure(0.02 * stress), distance * length)).collect();
        let other = follow(&contact, &path, 1e-11).pop().unwrap();
        let [other_depth, depth] = [&other, &one].map(|state| state.wear_volume_and_depth().unwrap().1);
        assert_relative_eq!(other_depth / length, depth, max_relative = 1e-8);
        assert_relative_eq!(other.approach() / length, one.approach(), max_relative = 1e-9);
        assert_relative_eq!(other.losses.total() / (stress * length), one.losses.total(), max_relative = 1e-9);
        assert_eq!(other.summary().contact_nodes, one.summary().contact_nodes);
    }
}

#[test]
fn wear_without_end_keeps_its_digits() {
    // The depth grows to more than a million times the roughness.
    let grid = Grid::square(12, 1.0).unwrap();
    let contact = wearing(&Body::half_space(material(0.3)), &grid, &rough(&grid, 7), 0.3);
    let states = follow(&contact, &held(Load::MeanPressure(0.01), 1e7, 5), 1e-8);
    assert_relative_eq!(states[5].wear_volume_and_depth().unwrap().0, 3e4, max_relative = 1e-12);
    assert_relative_eq!(states[5].summary().max_pressure, 0.01, max_relative = 1e-6);
}
