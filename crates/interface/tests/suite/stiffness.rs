//! Stiffness of states with a law and along paths, compared with small changes of the approach.

use gfmd_contact::{Boundary, Contact, Drive, Equilibrium, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Interface, Parts, QuasistaticContact, QuasistaticState, StiffnessError, Wear};
use gfmd_law::{Exponential, HardWall, Law as _, Limit, Npc, Separation};
use gfmd_medium::{Prony, Relaxes};

use super::{material, rough};

const TOLERANCE: f64 = 1e-11;

fn approached<E: Equilibrium>(contact: &E, approach: f64, drive: Drive, start: Option<&E::State>) -> E::State {
    let drive = Drive { load: Load::Approach(approach), ..drive };
    contact.press(drive).tolerance(TOLERANCE).starting_from(start).solve().unwrap()
}

#[test]
fn with_a_law_it_is_the_derivative_of_the_mean_pressure_also_under_tension_and_on_a_patch() {
    let (grid, body) = (Grid::square(16, 1.0).unwrap(), Body::half_space(material(0.3)));
    let heights = rough(&grid, 3);
    for boundary in [Boundary::Periodic, Boundary::Free] {
        let law = Exponential::new(1e-3, 4e-3).unwrap();
        let interface = Interface::with_boundary(boundary, &body, &grid, &heights, law.into_shared()).unwrap();
        let mut state = None;
        for approach in [0.01, 0.004, -0.003] {
            let reached = approached(&interface, approach, Load::Approach(0.0).into(), state.as_ref());
            let found = interface.stiffness(&reached, 1e-9).unwrap();
            let step = 1e-6;
            let [above, below] = [1.0, -1.0]
                .map(|sign| approached(&interface, approach + sign * step, Load::Approach(0.0).into(), Some(&reached)));
            let slope = (above.mean_pressure - below.mean_pressure) / (2.0 * step);
            approx::assert_relative_eq!(found.value, slope, max_relative = 1e-5);
            assert!(found.error <= 1e-8);
            state = Some(reached);
        }
        assert!(state.unwrap().mean_pressure < 0.0);
    }
}

#[test]
fn a_law_without_attraction_has_the_stiffness_of_the_hard_wall() {
    let (grid, body) = (Grid::square(16, 1.0).unwrap(), Body::half_space(material(0.3)));
    let heights = rough(&grid, 3);
    let interface = Interface::new(&body, &grid, &heights, HardWall).unwrap();
    let contact = Contact::new(&body, &grid, &heights).unwrap();
    let found = interface.stiffness(&approached(&interface, 0.008, Load::Approach(0.0).into(), None), 1e-9).unwrap();
    let wall = contact.stiffness(&approached(&contact, 0.008, Load::Approach(0.0).into(), None), 1e-9).unwrap();
    approx::assert_relative_eq!(found.value, wall.value, max_relative = 1e-8);
}

/// Returns the difference quotient of the mean pressure from a state, for a small change of the approach alone.
fn quotient(contact: &QuasistaticContact, state: &QuasistaticState, step: f64) -> f64 {
    let drive = Drive { time: state.time, distance: state.distance, ..Load::Approach(0.0).into() };
    let moved = approached(contact, state.approach() + step, drive, Some(state));
    (moved.mean_pressure() - state.mean_pressure()) / step
}

#[test]
fn along_a_path_it_is_the_stiffness_of_an_instant() {
    let (grid, body) = (Grid::square(16, 1.0).unwrap(), Body::half_space(material(0.3)));
    let heights = &rough(&grid, 3);
    let prony = Prony::from_fractions(&[(1.0, 0.4)]).unwrap();
    for boundary in [Boundary::Periodic, Boundary::Free] {
        let plain = Parts { boundary, ..Parts::new(&body, &grid, heights) };
        let hard = Parts { hardness: Some(0.15.into()), ..plain.clone() };
        let worn = Parts { wear: Some(Wear { by_distance: 0.05, by_slip: 0.0 }), ..plain.clone() };
        let relaxing = Parts { relaxation: Some((&prony, Relaxes::Both)), ..plain.clone() };
        let all = Parts { hardness: hard.hardness.clone(), wear: worn.wear, ..relaxing.clone() };
        let walls = [("wall", plain), ("hard", hard), ("worn", worn), ("relaxing", relaxing), ("all", all)];
        let law = || Some(Exponential::new(1e-4, 4e-3).unwrap().into_shared());
        let laws = walls.clone().map(|(name, parts)| (name, Parts { law: law(), ..parts }));
        for (name, parts) in walls.into_iter().chain(laws) {
            let contact = QuasistaticContact::new(&parts).unwrap();
            let (mut state, mut least) = (None, f64::INFINITY);
            for (approach, time) in [(0.006, 0.3), (0.01, 0.8), (0.0085, 1.0)] {
                let drive = Drive { time, distance: time, ..Load::Approach(0.0).into() };
                let reached = approached(&contact, approach, drive, state.as_ref());
                let found = contact.stiffness(&reached, 1e-9).unwrap();
                // Unloading keeps the depth pressed in, and loading keeps the points at the hardness.
                let [up, down] = [1e-7, -1e-7].map(|step| quotient(&contact, &reached, step));
                let is_met = |slope: f64| (slope / found.value - 1.0).abs() < 2e-4;
                assert!(is_met(up) || is_met(down), "{boundary:?} {name}: {found:?} {up} {down}");
                least = least.min(found.value);
                let of_fields = contact.stiffness_of_fields(&reached.pressure(), &reached.gap(), 1e-9).unwrap();
                approx::assert_relative_eq!(of_fields.value, found.value, max_relative = 1e-12);
                state = Some(reached);
            }
            assert!(least > 0.0);
        }
    }
}

/// At the hardness, loading and unloading differ: pressed on, these points keep their pressure; unloaded, they are
/// points in contact like all others.
#[test]
fn at_the_hardness_it_is_the_stiffness_under_a_growing_load() {
    let (grid, body) = (Grid::square(16, 1.0).unwrap(), Body::half_space(material(0.3)));
    let heights = &rough(&grid, 3);
    let prony = Prony::from_fractions(&[(1.0, 0.4)]).unwrap();
    let wall = Contact::new(&body, &grid, heights).unwrap();
    for (relaxation, factor) in [(None, 1.0), (Some((&prony, Relaxes::Both)), 1.0 / 0.6)] {
        let parts = Parts { hardness: Some(0.1.into()), relaxation, ..Parts::new(&body, &grid, heights) };
        let contact = QuasistaticContact::new(&parts).unwrap();
        let state = approached(&contact, 0.01, Load::Approach(0.0).into(), None);
        assert!(state.plastic_fraction > 0.0);
        let found = contact.stiffness(&state, 1e-9).unwrap().value;
        let unloaded = factor * wall.stiffness_of_pressure(&state.pressure(), 1e-9).unwrap().value;
        approx::assert_relative_eq!(quotient(&contact, &state, 1e-7), found, max_relative = 2e-4);
        approx::assert_relative_eq!(quotient(&contact, &state, -1e-7), unloaded, max_relative = 2e-4);
        assert!(unloaded > 1.05 * found, "{unloaded} {found}");
    }
}

/// With strong friction all points stick, so that loading and unloading follow the stiffness of an instant.
#[test]
fn surfaces_that_stick_have_the_stiffness_of_an_instant() {
    let (grid, body) = (Grid::square(16, 1.0).unwrap(), Body::half_space(material(0.1)));
    let heights = &rough(&grid, 3);
    let prony = Prony::from_fractions(&[(1.0, 0.4)]).unwrap();
    let plain = Parts { shear: Some(Limit::Coulomb(20.0).into()), ..Parts::new(&body, &grid, heights) };
    let hard = Parts { hardness: Some(0.15.into()), ..plain.clone() };
    let relaxing = Parts { relaxation: Some((&prony, Relaxes::Both)), ..plain.clone() };
    let worn = Parts { wear: Some(Wear { by_distance: 0.05, by_slip: 0.1 }), ..plain.clone() };
    let all = Parts { hardness: hard.hardness.clone(), wear: worn.wear, ..relaxing.clone() };
    let walls = [("wall", plain), ("hard", hard), ("worn", worn), ("relaxing", relaxing), ("all", all)];
    let law = || Some(Exponential::new(1e-4, 4e-3).unwrap().into_shared());
    let laws = walls.clone().map(|(name, parts)| (name, Parts { law: law(), ..parts }));
    let periodic = walls.into_iter().chain(laws);
    for (name, parts) in periodic.flat_map(|(name, parts)| {
        [Boundary::Periodic, Boundary::Free].map(|boundary| (name, Parts { boundary, ..parts.clone() }))
    }) {
        let contact = QuasistaticContact::new(&parts).unwrap();
        let frictionless = QuasistaticContact::new(&Parts { shear: None, ..parts.clone() });
        let mut state = None;
        for (approach, lateral) in [(0.008, 0.0), (0.01, 5e-4)] {
            let drive = Drive { lateral: [lateral, 0.0], time: 100.0 * approach, ..Load::Approach(0.0).into() };
            let drive = Drive { distance: if parts.wear.is_some() { approach } else { 0.0 }, ..drive };
            let reached = approached(&contact, approach, drive, state.as_ref());
            let found = contact.stiffness(&reached, 1e-9).unwrap();
            let [up, down] = [1e-6, -1e-6].map(|step| {
                let moved = approached(&contact, approach + step, drive, Some(&reached));
                (moved.mean_pressure() - reached.mean_pressure()) / step
            });
            let is_met = |slope: f64| (slope / found.value - 1.0).abs() < 5e-4;
            assert!(is_met(up) || is_met(down), "{name}: {found:?} {up} {down}");
            let of_fields = contact.stiffness_of_fields(&reached.pressure(), &reached.gap(), 1e-9).unwrap();
            approx::assert_relative_eq!(of_fields.value, found.value, max_relative = 1e-9);
            if let Ok(frictionless) = &frictionless {
                let free = frictionless.stiffness_of_fields(&reached.pressure(), &reached.gap(), 1e-9).unwrap();
                assert!(found.value > 1.01 * free.value, "{name}: {found:?} {free:?}");
            }
            state = Some(reached);
        }
    }
}

#[test]
fn without_coupling_friction_leaves_the_stiffness_as_it_is() {
    let (grid, body) = (Grid::square(16, 1.0).unwrap(), Body::half_space(material(0.5)));
    let heights = &rough(&grid, 3);
    for law in [None, Some(Exponential::new(1e-4, 4e-3).unwrap().into_shared())] {
        let plain = Parts { law, ..Parts::new(&body, &grid, heights) };
        let sheared = Parts { shear: Some(Limit::Coulomb(0.2).into()), ..plain.clone() };
        let [plain, sheared] = [plain, sheared].map(|parts| QuasistaticContact::new(&parts).unwrap());
        let drive = Drive { lateral: [1e-3, 0.0], ..Load::Approach(0.0).into() };
        let state = approached(&sheared, 0.01, drive, None);
        let found = sheared.stiffness(&state, 1e-9).unwrap().value;
        let free = plain.stiffness_of_fields(&state.pressure(), &state.gap(), 1e-9).unwrap().value;
        // The shortest waves of an even grid differ.
        approx::assert_relative_eq!(found, free, max_relative = 1e-3);
    }
}

#[test]
fn beside_a_law_that_shears_it_is_the_derivative_at_a_fixed_lateral_displacement() {
    let (grid, body) = (Grid::square(16, 1.0).unwrap(), Body::half_space(material(0.2)));
    let heights = &rough(&grid, 3);
    let lengths = Separation { normal_work: 1e-3, tangential_work: 1e-3, normal_length: 0.03, tangential_length: 0.03 };
    let law = || Npc::new(lengths).unwrap().into_shared();
    let prony = Prony::from_fractions(&[(1.0, 0.4)]).unwrap();
    let base = |x: f64| ndarray::Array2::from_elem((16, 16), x);
    let sideways = &[base(2e-3), base(-1e-3)];
    for boundary in [Boundary::Periodic, Boundary::Free] {
        for relaxation in [None, Some((&prony, Relaxes::Both))] {
            let sideways: &[_] = if boundary == Boundary::Periodic { sideways } else { &[] };
            let parts = Parts {
                law: Some(law()),
                all_components: true,
                boundary,
                relaxation,
                sideways,
                ..Parts::new(&body, &grid, heights)
            };
            let contact = QuasistaticContact::new(&parts).unwrap();
            let mut state = None;
            for (approach, lateral) in [(0.004, 0.0), (0.006, 4e-3)] {
                let drive = Drive { lateral: [lateral, 0.0], ..Load::Approach(0.0).into() };
                let reached = approached(&contact, approach, drive, state.as_ref());
                let found = contact.stiffness(&reached, 1e-9).unwrap();
                let [up, down] = [1e-6, -1e-6]
                    .map(|step| approached(&contact, approach + step, drive, Some(&reached)).mean_pressure());
                approx::assert_relative_eq!(found.value, (up - down) / 2e-6, max_relative = 1e-4);
                state = Some(reached);
            }
        }
    }
}

#[test]
fn what_has_no_stiffness_says_why() {
    let (grid, body) = (Grid::square(16, 1.0).unwrap(), Body::half_space(material(0.3)));
    let heights = &rough(&grid, 3);
    let plain = QuasistaticContact::new(&Parts::new(&body, &grid, heights)).unwrap();
    let small = ndarray::Array2::zeros((8, 8));
    let error = plain.stiffness_of_fields(&small, &small, 1e-9).unwrap_err();
    assert!(matches!(error, StiffnessError::Refused(_)) && error.to_string().contains("256"), "{error}");
}
