//! Cost of contacts with a law or friction in transform pairs, which do not depend on the machine, and the states
//! reached. The bounds are about a fifth above the numbers needed when they were set.

use gfmd_contact::{Boundary, Budget, Cotangents, Drive, Equilibrium, Fields, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Increment, Interface, Path, QuasistaticContact, QuasistaticState, Refinement, State};
use gfmd_law::{Exponential, Law, Limit, Morse};
use gfmd_surface::{Discretisation, SelfAffine};

use crate::rubbing;

const N: usize = 128;
const WORK: f64 = 2e-5;

/// Returns the range at which the steepness of the attraction is about half the stiffness of the shortest wave.
fn shortest_range() -> f64 {
    let corner = 0.5 * std::f64::consts::PI * N as f64 * std::f64::consts::SQRT_2;
    (WORK / (0.48 * corner)).sqrt()
}

fn interface(hurst: f64, law: impl Law + 'static) -> Interface {
    let grid = Grid::square(N, 1.0).unwrap();
    let numbers = Discretisation { eps_t_inv: 4.0, eps_f_inv: N as f64 / 32.0, eps_c_inv: 8.0 };
    let spectrum = SelfAffine { hurst, ..SelfAffine::with_rms_gradient(1.0) };
    let heights = numbers.self_affine(1.0, spectrum).heights(&grid, 1).unwrap();
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
    let interface = Interface::new(&body, &grid, &heights, law).unwrap();
    assert!(interface.trapping().is_none());
    interface
}

fn exponential(factor: f64) -> Exponential {
    Exponential::new(factor * WORK, factor * shortest_range()).unwrap()
}

/// Returns the transform pairs of successive loads, each started from the last state.
fn pairs(interface: &Interface, loads: &[Load]) -> Vec<f64> {
    let mut last: Option<State> = None;
    let pairs = loads.iter().map(|load| {
        let state = interface.press(*load).starting_from(last.as_ref()).solve().unwrap();
        assert!(state.residual.worst() <= 1e-8 && state.lowest_curvature > 0.0, "{load:?}: {:?}", state.residual);
        let pairs = state.effort.transform_pairs;
        last = Some(state);
        pairs
    });
    pairs.collect()
}

/// Panics with all numbers if any case takes more pairs than its bound.
fn assert_within(found: &[(String, Vec<f64>, Vec<f64>)]) {
    let within = |(_, pairs, bounds): &(String, Vec<f64>, Vec<f64>)| {
        pairs.len() == bounds.len() && pairs.iter().zip(bounds).all(|(pairs, bound)| pairs <= bound)
    };
    assert!(found.iter().all(within), "case, pairs, bounds: {found:#?}");
}

#[test]
fn loads_of_a_loop() {
    let up_and_down = [0.002, 0.006, 0.01, 0.006].map(Load::MeanPressure);
    let cases = [
        (0.8, 1.0, [110.0, 102.0, 115.0, 100.0]),
        (0.3, 1.0, [80.0, 143.0, 126.0, 123.0]),
        (0.8, 4.0, [91.0, 76.0, 85.0, 77.0]),
        (0.3, 4.0, [97.0, 80.0, 90.0, 85.0]),
    ];
    assert_within(&cases.map(|(hurst, factor, bounds)| {
        let pairs = pairs(&interface(hurst, exponential(factor)), &up_and_down);
        (format!("H {hurst}, {factor} times the shortest range"), pairs, bounds.into())
    }));
}

#[test]
fn cold_starts_from_first_touch_to_full_contact() {
    let interface = interface(0.8, exponential(1.0));
    let cases = [(1e-3, 122.0), (0.01, 210.0), (0.1, 253.0), (1.0, 164.0)];
    assert_within(&cases.map(|(pressure, bound)| {
        (format!("p* {pressure}"), pairs(&interface, &[Load::MeanPressure(pressure)]), vec![bound])
    }));
}

#[test]
fn jumps_under_a_prescribed_approach() {
    let range = 2.0 * shortest_range();
    let approaches = [-30.0, -6.0, 0.0, 4.0, -8.0, -24.0].map(|d| Load::Approach(d * range));
    let pairs = pairs(&interface(0.8, exponential(2.0)), &approaches);
    assert_within(&[("twice the shortest range".into(), pairs, vec![6.0, 15.0, 43.0, 52.0, 24.0, 10.0])]);
}

#[test]
fn a_law_without_a_wall() {
    let law = Morse::new(WORK, shortest_range()).unwrap();
    let pairs = pairs(&interface(0.8, law), &[0.002, 0.01].map(Load::MeanPressure));
    assert_within(&[("Morse".into(), pairs, vec![193.0, 271.0])]);
}

/// A rough surface is pressed and then sheared in five steps, in single increments and with divided steps.
/// Creates a rough contact with friction on 64 x 64 points, and six drives under a load that push it sideways.
fn pushed(poisson: f64) -> (QuasistaticContact, [Drive; 6]) {
    let n = 64;
    let grid = Grid::square(n, 1.0).unwrap();
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n as f64 / 8.0, eps_c_inv: 4.0 };
    let spectrum = SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) };
    let heights = numbers.self_affine(1.0, spectrum).heights(&grid, 1).unwrap();
    let body = Body::half_space(Material::from_young(1.0, poisson).unwrap());
    let load = Load::MeanPressure(0.05 * 0.1 * body.contact_modulus());
    let drive = |step: u8| Drive { lateral: [2e-4 * f64::from(step), 0.0], ..load.into() };
    let contact = rubbing(Boundary::Periodic, &body, &grid, &heights, Limit::Coulomb(0.3));
    (contact, [0, 1, 2, 3, 4, 5].map(drive))
}

#[test]
fn steps_with_friction() {
    let mut found = Vec::new();
    for (poisson, bounds) in [(0.0, [400.0, 2450.0]), (0.3, [315.0, 1970.0])] {
        let (contact, drives) = pushed(poisson);
        for (solves_per_step, bound) in [0, 10].into_iter().zip(bounds) {
            let mut path = Path::new(&contact, Budget::default(), Refinement { tolerance: 1e-3, solves_per_step });
            let pairs = drives.iter().map(|drive| {
                let made = path.step(*drive, &mut ()).unwrap();
                assert!(path.state().unwrap().worst() <= 1e-8 && (solves_per_step == 0 || !made.is_unsettled));
                made.effort.transform_pairs
            });
            let mean = pairs.sum::<f64>() / 6.0;
            found.push((format!("poisson {poisson}, {solves_per_step} solves"), vec![mean], vec![bound]));
        }
    }
    assert_within(&found);
}

#[test]
fn derivatives_along_a_path_with_friction() {
    let mut found = Vec::new();
    for (poisson, bound) in [(0.0, 1360.0), (0.3, 980.0)] {
        let (contact, drives) = pushed(poisson);
        let mut states: Vec<QuasistaticState> = Vec::new();
        for drive in drives {
            let state = contact.press(drive).starting_from(states.last()).solve().unwrap();
            states.push(state);
        }
        let of = Cotangents { elastic_energy: 1.0, mean_shear: [1.0, 0.0], ..Cotangents::default() };
        let increments: Vec<Increment> =
            states.iter().map(|state| Increment { load: drives[0].load, state, of: Some(&of) }).collect();
        let gradient = contact.gradient_along(&increments).unwrap();
        assert!(gradient.error <= 1e-9, "{}", gradient.error);
        let mean = gradient.effort.transform_pairs / 6.0;
        found.push((format!("poisson {poisson}"), vec![mean], vec![bound]));
    }
    assert_within(&found);
}
