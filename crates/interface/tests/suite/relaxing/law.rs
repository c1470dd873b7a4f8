//! Laws across the gap of a viscoelastic body.

use std::f64::consts::TAU;

use gfmd_contact::{Boundary, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, Parts, QuasistaticContact, QuasistaticState};
use gfmd_law::{Exponential, HardWall, Law, Tabulated};
use gfmd_medium::{Prony, Relaxes};
use ndarray::Array2;

use super::{one, three};
use crate::{legs, material, rough};

fn follow(contact: &QuasistaticContact, path: &[(Load, f64)]) -> Vec<QuasistaticState> {
    super::follow(contact, path, 1e-11)
}

/// Returns the contact with `law` on a half-space, slab or patch that relaxes.
fn with_law(
    law: impl Law + 'static,
    (body, relaxes, boundary): (&Body, Relaxes, Boundary),
    grid: &Grid,
    heights: &Array2<f64>,
    prony: &Prony,
) -> QuasistaticContact {
    let (law, relaxation) = (Some(law.into_shared()), Some((prony, relaxes)));
    QuasistaticContact::new(&Parts { boundary, law, relaxation, ..Parts::new(body, grid, heights) }).unwrap()
}

/// Returns bodies with the same relaxation for all waves, and one (the last) with wave-dependent relaxation.
fn bodies() -> [(Body, Relaxes, Boundary); 4] {
    let half_space = Body::half_space(material(0.3));
    let slab = Body::slab(material(0.4), 0.3).unwrap();
    [
        (half_space.clone(), Relaxes::Both, Boundary::Periodic),
        (half_space, Relaxes::Shear, Boundary::Free),
        (slab.clone(), Relaxes::Both, Boundary::Periodic),
        (slab, Relaxes::Shear, Boundary::Periodic),
    ]
}

#[test]
fn a_law_that_is_a_wall_is_the_hard_wall() {
    let grid = Grid::square(12, 1.0).unwrap();
    let heights = rough(&grid, 5);
    let path = legs(&[0.02, 0.004, 0.01], &[0.0, 2.0, 5.0], 3, Load::MeanPressure);
    for (body, relaxes, boundary) in bodies() {
        let wall = follow(&super::on(boundary, &body, &grid, &heights, &three(), relaxes), &path);
        let law = follow(&with_law(HardWall, (&body, relaxes, boundary), &grid, &heights, &three()), &path);
        for (wall, law) in wall.iter().zip(&law) {
            let close = |a: f64, b: f64, size: f64| assert!((a - b).abs() <= 1e-7 * size, "{a} {b} {relaxes:?}");
            let most = wall.pressure().iter().copied().fold(0.0, f64::max);
            wall.pressure().iter().zip(&law.pressure()).for_each(|(a, b)| close(*a, *b, most));
            wall.displacement_z().iter().zip(law.displacement_z()).for_each(|(a, b)| close(*a, *b, 0.02));
            close(wall.approach(), law.approach(), 0.02);
            close(wall.elastic_energy(), law.elastic_energy(), wall.elastic_energy());
            close(wall.losses.total(), law.losses.total(), wall.elastic_energy());
            close(wall.work_imbalance, law.work_imbalance, wall.elastic_energy());
        }
    }
}

/// Returns the body with moduli larger by `factor`.
fn stiffer(body: &Body, factor: f64) -> Body {
    let material = body.material();
    let stiff = Material::from_young(factor * 2.0, material.poisson()).unwrap();
    match body.height() {
        gfmd_green::Height::Infinite => Body::half_space(stiff),
        gfmd_green::Height::Finite(height) => Body::slab(stiff, height).unwrap(),
    }
}

#[test]
fn a_step_begins_with_the_instantaneous_moduli_and_ends_with_those_of_the_long_term() {
    let grid = Grid::square(16, 1.0).unwrap();
    let heights = rough(&grid, 8);
    let law = Exponential::new(2e-4, 0.01).unwrap();
    for (body, relaxes, boundary) in bodies().into_iter().filter(|(_, relaxes, _)| *relaxes == Relaxes::Both) {
        let of = |body: &Body| Interface::with_boundary(boundary, body, &grid, &heights, law).unwrap();
        let contact = with_law(law, (&body, relaxes, boundary), &grid, &heights, &three());
        let load = Load::Approach(0.006);
        let states = follow(&contact, &[(load, 0.0), (load, 1.0), (load, 20.0), (load, 1e4), (load, 1e6)]);
        for (state, factor) in [(&states[0], 4.0), (&states[4], 1.0)] {
            let elastic = of(&stiffer(&body, factor)).press(load).tolerance(1e-11).solve().unwrap();
            let [expected, found] = [elastic.pressure(), state.pressure()];
            let most = expected.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
            assert!(expected.iter().zip(&found).all(|(a, b)| (a - b).abs() <= 1e-5 * most), "{factor}");
            let energy = state.elastic_energy() / elastic.elastic_energy - 1.0;
            assert!(factor != 1.0 || energy.abs() < 1e-4, "{energy}");
        }
    }
}

/// The law is linear in the gap over the whole wave, so that d of the wave relaxes exponentially.
#[test]
fn a_wave_on_springs_relaxes_by_its_closed_form_with_order_two() {
    let (n, spring, amplitude) = (16, 5.0, 1e-3);
    let grid = Grid::line(n, 1.0).unwrap();
    let material = Material::from_contact_modulus(2.0, 0.3).unwrap();
    let body = Body::half_space(material);
    let heights = Array2::from_shape_fn((n, 1), |(i, _)| amplitude * (TAU * i as f64 / n as f64).cos());
    // The attraction falls linearly from 0.1 at gap 0, where the table begins.
    let rows: Vec<[f64; 2]> = (0..=40).map(|k| 0.0005 * f64::from(k)).map(|gap| [gap, 0.1 - spring * gap]).collect();
    let law = Tabulated::new(&rows).unwrap();
    let contact = with_law(law, (&body, Relaxes::Both, Boundary::Periodic), &grid, &heights, &one());
    // Attraction that falls with the gap acts as springs of negative stiffness: (S - k) d = k h for each wave.
    let (stiffness, c) = (0.5 * 2.0 * TAU, 0.6 / 0.4);
    let at = |s: f64| spring * amplitude / (s - spring);
    let rate = (stiffness - spring) / (1.3 * (stiffness * (1.0 + c) - spring));
    let exact = |time: f64| at(stiffness) + (at(stiffness * (1.0 + c)) - at(stiffness)) * (-rate * time).exp();
    let found = |steps: usize| {
        let path = legs(&[-0.008, -0.008], &[0.0, 2.0], steps, Load::Approach);
        let states = follow(&contact, &path);
        let wave = |state: &QuasistaticState| {
            let u = state.displacement_z();
            let sum: f64 = u.indexed_iter().map(|((i, _), u)| u * (TAU * i as f64 / n as f64).cos()).sum();
            (2.0 / n as f64 * sum).abs()
        };
        [wave(&states[0]) - exact(0.0).abs(), wave(states.last().unwrap()) - exact(2.0).abs()]
    };
    let errors = [4, 8, 16].map(found);
    assert!(errors.iter().all(|[at_once, _]| at_once.abs() < 1e-9 * amplitude), "{errors:?} {}", exact(0.0));
    for pair in errors.windows(2) {
        let ratio = pair[0][1] / pair[1][1];
        assert!((3.5..4.5).contains(&ratio), "{errors:?}");
    }
    assert!(errors[2][1].abs() < 1e-2 * amplitude, "{errors:?}");
}

#[test]
fn work_is_energy_gained_and_lost_and_nothing_is_won_in_a_loop() {
    let grid = Grid::line(64, 1.0).unwrap();
    let heights = Array2::from_shape_fn((64, 1), |(i, _)| 0.01 * (TAU * i as f64 / 64.0).cos());
    let body = Body::half_space(material(0.3));
    let law = Exponential::new(2e-4, 2e-3).unwrap();
    let elastic = Prony::from_fractions(&[(1.0, 1e-9)]).unwrap();
    let loops = |prony: &Prony, time: f64, steps: usize| {
        let contact = with_law(law, (&body, Relaxes::Both, Boundary::Periodic), &grid, &heights, prony);
        let path = legs(&[-0.012, 0.002, -0.012], &[0.0, time, time], steps, Load::Approach);
        let states = follow(&contact, &path);
        let mut work = 0.0;
        for pair in states.windows(2) {
            let [a, b] = [&pair[0], &pair[1]];
            work += 0.5 * (a.mean_pressure() + b.mean_pressure()) * (b.approach() - a.approach());
            assert!(b.losses.total() >= -b.work_imbalance - 1e-12, "{} {}", b.losses.total(), b.work_imbalance);
        }
        let energy = |state: &QuasistaticState| state.elastic_energy() + state.interface_energy();
        let gained = energy(states.last().unwrap()) - energy(&states[0]);
        let lost: f64 = states[1..].iter().map(|state| state.losses.total()).sum();
        let error: f64 = states[1..].iter().map(|state| state.work_imbalance).sum();
        assert!((work - gained - lost).abs() <= error + 1e-12, "{work} {gained} {lost} {error}");
        (lost, error)
    };
    let (jumps, error) = loops(&elastic, 1.0, 300);
    assert!(jumps > 10.0 * error, "{jumps} {error}");
    // A slow loop passes through the same states; its work is the loss, whatever the share of the dashpots.
    let (slow, slow_error) = loops(&one(), 1e5, 300);
    assert!((slow - jumps).abs() < error + slow_error + 0.02 * jumps, "{slow} {jumps} {error} {slow_error}");
    loops(&one(), 1.0, 300);
}

#[test]
fn a_path_in_time_starts_with_the_state_that_the_law_makes_without_a_load() {
    let grid = Grid::square(12, 1.0).unwrap();
    let heights = rough(&grid, 3);
    let body = Body::half_space(material(0.3));
    let law = Exponential::new(1e-4, 0.01).unwrap();
    let contact = with_law(law, (&body, Relaxes::Both, Boundary::Periodic), &grid, &heights, &one());
    let load = Load::MeanPressure;
    let explicit = follow(&contact, &[(load(0.0), 0.0), (load(0.01), 1.0)]);
    let implied = follow(&contact, &[(load(0.01), 1.0)]);
    assert_eq!(explicit[1].displacement_z(), implied[0].displacement_z());
    assert_eq!(explicit[1].losses.total().to_bits(), implied[0].losses.total().to_bits());
    let pairs = |state: &QuasistaticState| state.effort().transform_pairs;
    assert_eq!(pairs(&implied[0]), pairs(&explicit[0]) + pairs(&explicit[1]));
}

#[test]
fn all_components_with_branches_of_their_own_are_refused() {
    let grid = Grid::square(8, 1.0).unwrap();
    let body = Body::half_space(material(0.3));
    let (heights, prony, law) = (rough(&grid, 1), one(), Exponential::new(1e-4, 0.01).unwrap().into_shared());
    let parts = Parts { law: Some(law), all_components: true, ..Parts::new(&body, &grid, &heights) };
    let error = QuasistaticContact::new(&Parts { relaxation: Some((&prony, Relaxes::Shear)), ..parts });
    assert!(error.unwrap_err().to_string().contains("with shear at the surface"));
}
