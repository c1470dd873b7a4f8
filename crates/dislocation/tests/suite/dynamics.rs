//! Glide: energy balance, convergence with the time step, a pair in closed form, sources, obstacles, the surface.

use std::f64::consts::PI;

use gfmd_dislocation::{Crystal, Dislocation, DislocationError, Domain, Obstacle, SlipSystem, Source};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};

/// Lengths in µm, stresses in GPa, times in ns: aluminium.
const B: f64 = 2.5e-4;
const DRAG: f64 = 1e-4;

fn material() -> Material {
    Material::from_young(70.0, 0.33).unwrap()
}

fn domain(body: Body, length: f64, points: usize, held: std::ops::Range<usize>) -> Domain {
    let grid = Grid::line(points, length).unwrap();
    let held: Vec<bool> = (0..points).map(|i| held.contains(&i)).collect();
    Domain::new(&body, &grid, &held).unwrap()
}

fn slip(planes: &[f64]) -> SlipSystem {
    SlipSystem { angle: PI / 3.0, burgers: B, planes: planes.to_vec(), drag: DRAG, capture: 6.0 * B }
}

fn free(plane: usize, place: f64, sign: f64) -> Dislocation {
    Dislocation { plane, place, sign, obstacle: None }
}

/// Moves eight dislocations on three planes while the punch goes down for 1 ns.
fn pressed(steps: usize) -> Crystal {
    let domain = domain(Body::slab(material(), 1.0).unwrap(), 2.0, 135, 60..75);
    let all = [
        free(0, -0.3, 1.0),
        free(0, -0.6, -1.0),
        free(1, -0.2, -1.0),
        free(1, -0.4, 1.0),
        free(1, -0.7, 1.0),
        free(2, -0.35, 1.0),
        free(2, -0.5, 1.0),
        free(2, -0.9, -1.0),
    ];
    let mut crystal = Crystal::new(domain, slip(&[0.9, 1.05, 1.4]), &all, &[], &[]).unwrap();
    for _ in 0..steps {
        crystal.advance(1.0 / steps as f64, 0.0005 / steps as f64).unwrap();
    }
    assert_eq!(crystal.dislocations().len(), 8);
    assert_eq!(crystal.events().shortened, 0);
    crystal
}

#[test]
fn places_and_balance_converge_with_the_square_of_the_time_step() {
    let runs = [10, 20, 40, 80].map(pressed);
    let travelled = (runs[3].dislocations()[1].place - -0.6).abs();
    assert!(travelled > 0.005, "{travelled}");
    let distance = |a: &Crystal, b: &Crystal| {
        let pairs = a.dislocations().iter().zip(b.dislocations());
        pairs.map(|(a, b)| (a.place - b.place).abs()).fold(0.0, f64::max)
    };
    let errors = [0, 1, 2].map(|k| distance(&runs[k], &runs[k + 1]));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.7..2.6).contains(&order), "{errors:?}");
    }
    let errors = [0, 1, 2, 3].map(|k| runs[k].balance().error().abs());
    let scale = runs[3].balance().dissipated;
    assert!(scale > 0.0 && errors[3] < 1e-3 * scale, "{errors:?} {scale}");
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1]).log2() > 1.7, "{errors:?}");
    }
}

#[test]
fn a_pair_far_from_everything_falls_together_as_the_square_root_of_time() {
    // dr/dt = −2 μ b²/(2π (1 − ν) r B), so r² falls linearly.
    let far = domain(Body::half_space(material()), 400.0, 255, 0..0);
    let slip = slip(&[200.0]);
    let all = [free(0, -100.0, 1.0), free(0, -100.5, -1.0)];
    let mut crystal = Crystal::new(far, slip, &all, &[], &[]).unwrap();
    let m = material();
    let rate = 2.0 * m.shear_modulus() * B * B / (PI * (1.0 - m.poisson()) * DRAG);
    let time = 0.75 * 0.25 / rate;
    for _ in 0..100 {
        crystal.advance(time / 100.0, 0.0).unwrap();
    }
    let [one, other] = crystal.dislocations() else { panic!("a pair") };
    let distance = one.place - other.place;
    assert!((distance - 0.25).abs() < 2e-4, "{distance}");
    // Then they meet and annihilate.
    for _ in 0..80 {
        crystal.advance(time / 100.0, 0.0).unwrap();
    }
    assert_eq!((crystal.dislocations().len(), crystal.events().annihilated), (0, 1));
    assert!(crystal.state().energy().abs() < 1e-18);
}

#[test]
fn a_dislocation_near_a_free_surface_leaves_and_a_step_stays() {
    let domain = domain(Body::slab(material(), 1.0).unwrap(), 2.0, 255, 0..0);
    let mut crystal =
        Crystal::new(domain, slip(&[0.804]), &[free(0, -0.05, 1.0), free(0, -0.6, -1.0)], &[], &[]).unwrap();
    for _ in 0..200 {
        crystal.advance(0.05, 0.0).unwrap();
        if crystal.events().departed > 0 {
            break;
        }
    }
    assert_eq!(crystal.events().departed, 1);
    // The positive dislocation slipped the left side forward, that is upwards.
    let u = crystal.state().displacement();
    let spacing = 2.0 / 255.0;
    let (left, right) = ((0.8 / spacing) as usize, (0.8 / spacing) as usize + 1);
    let jump = u[left] - u[right];
    assert!((jump / (B * (PI / 3.0).sin()) - 1.0).abs() < 0.1, "{jump}");
}

#[test]
fn surface_and_pressure_do_not_jump_when_a_dislocation_leaves() {
    for (held, x, sign) in [(60..75, 1.003, 1.0), (60..75, 0.7, 1.0), (0..0, 0.9, -1.0)] {
        let world = domain(Body::slab(material(), 1.0).unwrap(), 2.0, 135, held);
        let partner = free(0, -0.6, -sign);
        let state =
            |all: &[Dislocation]| Crystal::new(world.clone(), slip(&[x]), all, &[], &[]).unwrap().state().clone();
        let (near, gone) = (state(&[free(0, -1e-7, sign), partner]), state(&[partner]));
        // Both contain only the waves of the grid, with the full Gibbs phenomenon near the step itself.
        let scale = B * (PI / 3.0).sin();
        for (i, (near, gone)) in near.displacement().iter().zip(gone.displacement()).enumerate() {
            let distance = (i as f64 * 2.0 / 135.0 - x).abs();
            if distance > 0.2 {
                assert!((near - gone).abs() < 0.05 * scale, "{i}: {near} {gone}");
            }
        }
        let force = (near.mean_pressure() - gone.mean_pressure()).abs();
        assert!(force <= 0.05 * gone.mean_pressure().abs() + 1e-15, "{force} {}", gone.mean_pressure());
    }
}

#[test]
fn obstacles_hold_up_to_their_strength_and_sources_wait() {
    let world = || domain(Body::slab(material(), 1.0).unwrap(), 2.0, 135, 60..75);
    let run = |strength: f64, sources: &[Source]| {
        let obstacle = [Obstacle { plane: 0, place: -0.45, strength }, Obstacle { plane: 0, place: -0.12, strength }];
        let all = if sources.is_empty() { vec![free(0, -0.3, 1.0)] } else { Vec::new() };
        let mut crystal = Crystal::new(world(), slip(&[1.1]), &all, sources, &obstacle).unwrap();
        for _ in 0..400 {
            crystal.advance(0.02, 0.006 / 400.0).unwrap();
        }
        crystal
    };
    let held = run(100.0, &[]);
    assert!(held.dislocations()[0].obstacle.is_some());
    assert!([-0.45, -0.12].contains(&held.dislocations()[0].place));
    let passed = run(1e-3, &[]);
    assert!(passed.dislocations().first().is_none_or(|d| d.obstacle.is_none()));
    let source = Source { plane: 0, place: -0.3, strength: 0.05, delay: 2.0 };
    let fed = run(100.0, &[source]);
    assert!(fed.events().nucleated > 0);
    let never = run(100.0, &[Source { strength: 50.0, ..source }]);
    assert_eq!(never.events().nucleated, 0);
    // The emitted dislocations lower the pressure at the same depth, and the balance closes over the jumps.
    assert!(fed.state().mean_pressure() < never.state().mean_pressure());
    let balance = fed.balance();
    assert!(balance.error().abs() < 0.02 * balance.dissipated, "{balance:?}");
}

#[test]
fn what_is_out_of_range_is_refused() {
    let world = || domain(Body::slab(material(), 1.0).unwrap(), 2.0, 31, 0..0);
    let make = |slip: SlipSystem, d: Dislocation| Crystal::new(world(), slip, &[d], &[], &[]);
    assert!(matches!(make(slip(&[0.5]), free(1, -0.1, 1.0)), Err(DislocationError::Plane { found: 1, planes: 1 })));
    for place in [0.0, 0.1, -1.2, f64::NAN] {
        assert!(matches!(make(slip(&[0.5]), free(0, place, 1.0)), Err(DislocationError::Place { .. })), "{place}");
    }
    assert!(make(slip(&[0.5]), free(0, -0.1, 0.5)).is_err());
    for angle in [0.0, PI, -1.0, f64::NAN] {
        assert!(make(SlipSystem { angle, ..slip(&[0.5]) }, free(0, -0.1, 1.0)).is_err());
    }
    for drag in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(make(SlipSystem { drag, ..slip(&[0.5]) }, free(0, -0.1, 1.0)).is_err());
    }
    let mut crystal = make(slip(&[0.5]), free(0, -0.1, 1.0)).unwrap();
    assert!(crystal.advance(0.0, 0.0).is_err() && crystal.advance(f64::NAN, 0.0).is_err());
    assert!(crystal.advance(0.1, f64::NAN).is_err());
}
