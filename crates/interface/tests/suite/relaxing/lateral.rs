//! Laws that move all components of a viscoelastic body, or of a body on a base that moves.

use gfmd_contact::{Boundary, Drive, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Parts, QuasistaticContact, QuasistaticState};
use gfmd_law::{Law, Npc, Separation};
use gfmd_medium::Relaxes;
use ndarray::Array2;

use super::three;
use crate::{material, rough};

fn law() -> Npc {
    // Attraction that this grid resolves.
    let lengths = Separation { normal_work: 2e-3, tangential_work: 2e-3, normal_length: 0.03, tangential_length: 0.03 };
    Npc::new(lengths).unwrap()
}

/// Returns a drive under a mean pressure.
fn drive(pressure: f64, x: f64, time: f64) -> Drive {
    Drive { lateral: [x, 0.4 * x], ..Drive::from(Load::MeanPressure(pressure)).at(time) }
}

fn follow(contact: &QuasistaticContact, path: &[Drive]) -> Vec<QuasistaticState> {
    let mut states: Vec<QuasistaticState> = Vec::new();
    for drive in path {
        states.push(contact.press(*drive).tolerance(1e-11).starting_from(states.last()).solve().unwrap());
    }
    states
}

fn same(found: &QuasistaticState, known: &QuasistaticState, what: &str) {
    let close = |a: f64, b: f64, size: f64| assert!((a - b).abs() <= 1e-7 * size, "{what}: {a} {b}");
    let most = known.pressure().iter().fold(0.0, |most: f64, p| most.max(p.abs()));
    found.pressure().iter().zip(&known.pressure()).for_each(|(a, b)| close(*a, *b, most));
    found.displacement_z().iter().zip(known.displacement_z()).for_each(|(a, b)| close(*a, *b, 0.02));
    (0..2).for_each(|axis| close(found.mean_shear[axis], known.mean_shear[axis], most));
    close(found.approach(), known.approach(), 0.02);
    close(found.interface_energy(), known.interface_energy(), known.elastic_energy());
}

/// At once the body has its instantaneous moduli, and long after its long-term moduli, also where it was sheared.
#[test]
fn the_limits_of_short_and_long_times_are_elastic_bodies() {
    let grid = Grid::square(12, 1.0).unwrap();
    let (heights, prony) = (rough(&grid, 4), three());
    let body = |factor: f64| Body::half_space(material(0.3)).in_units(1.0 / factor, 1.0);
    for boundary in [Boundary::Periodic, Boundary::Free] {
        let of = |factor: f64, relaxes: bool| {
            let body = body(factor);
            let relaxation = relaxes.then_some((&prony, Relaxes::Both));
            let law = Some(law().into_shared());
            let parts = Parts { boundary, law, all_components: true, relaxation, ..Parts::new(&body, &grid, &heights) };
            QuasistaticContact::new(&parts).unwrap()
        };
        let states = follow(&of(1.0, true), &[drive(0.01, 0.006, 0.0), drive(0.01, 0.006, 1e10)]);
        assert!(states[0].mean_shear[0] > 0.0);
        let factors = [prony.instantaneous(), 1.0];
        for ((state, factor), what) in states.iter().zip(factors).zip(["at once", "long after"]) {
            same(state, &follow(&of(factor, false), &[drive(0.01, 0.006, 0.0)])[0], what);
        }
        assert!(states[1].losses.relaxation > 0.0);
    }
}

/// The work of pressure and shear is stored or lost, up to the square of the increments.
#[test]
fn the_energy_balance_of_shear_and_relaxation_closes() {
    let grid = Grid::new([12, 10], [1.0, 0.8]).unwrap();
    let (heights, prony, body) = (rough(&grid, 7), three(), Body::slab(material(0.4), 0.5).unwrap());
    let relaxation = Some((&prony, Relaxes::Both));
    let parts = Parts {
        law: Some(law().into_shared()),
        all_components: true,
        relaxation,
        ..Parts::new(&body, &grid, &heights)
    };
    let contact = QuasistaticContact::new(&parts).unwrap();
    let imbalance = |steps: usize| {
        let part = |k: usize| k as f64 / steps as f64;
        let mut path = vec![drive(0.01, 0.0, 0.0), drive(0.01, 0.0, 50.0)];
        path.extend((1..=steps).map(|k| drive(0.01, 0.004 * part(k), 50.0 + 2.0 * part(k))));
        let states = follow(&contact, &path);
        let lost: f64 = states[2..].iter().map(|state| state.losses.relaxation).sum();
        states[2..].iter().map(|state| state.work_imbalance.abs()).sum::<f64>() / lost
    };
    let [coarse, fine] = [8, 16].map(imbalance);
    assert!(fine < 0.35 * coarse && coarse < 0.1, "{coarse} {fine}");
}

/// A base that moves as a whole is a motion of the rigid surface to the other side. Any other motion is part of the
/// separation that the law sees.
#[test]
fn a_base_that_moves_sideways_shears_the_law() {
    let grid = Grid::square(12, 1.0).unwrap();
    let (heights, body) = (rough(&grid, 2), Body::slab(material(0.3), 0.4).unwrap());
    let over = |sideways: &[Array2<f64>]| {
        let law = Some(law().into_shared());
        QuasistaticContact::new(&Parts { law, all_components: true, sideways, ..Parts::new(&body, &grid, &heights) })
            .unwrap()
    };
    let whole = [0.002, -0.001].map(|u| Array2::from_elem((12, 12), u));
    let moved = follow(&over(&whole), &[Drive { lateral: [0.005, 0.001], ..Drive::from(Load::MeanPressure(0.01)) }]);
    let other = Drive { lateral: [0.003, 0.002], ..Drive::from(Load::MeanPressure(0.01)) };
    same(&moved[0], &follow(&over(&[]), &[other])[0], "as a whole");
    let waves =
        [3.0, 5.0].map(|k: f64| Array2::from_shape_fn((12, 12), |(i, j)| 0.004 * (k * (i + 2 * j) as f64).sin()));
    let state = &follow(&over(&waves), &[drive(0.01, 0.004, 0.0)])[0];
    let normal = state.law().unwrap();
    let most = normal.traction.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
    for ((i, j), gap) in state.gap().indexed_iter() {
        let slid = [0, 1].map(|c| [0.004, 0.0016][c] - normal.displacement[[c, i, j]] - waves[c][[i, j]]);
        let expected = law().traction(*gap, slid);
        for (c, expected) in expected.into_iter().enumerate() {
            assert!((normal.traction[[c, i, j]] - expected).abs() < 1e-8 * most, "{c} at {i}, {j}");
        }
    }
    let wrong = [Array2::zeros((12, 11))];
    let parts = Parts { law: Some(law().into_shared()), all_components: true, ..Parts::new(&body, &grid, &heights) };
    assert!(QuasistaticContact::new(&Parts { sideways: &wrong, ..parts }).is_err());
}
