//! Permanent plastic depth: identities of paths at a hard wall with a hardness.

use gfmd_contact::{Boundary, Budget, Contact, Drive, Equilibrium, Fields, Load, MemoryCheckpoint, Resumable};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Parts, Path, QuasistaticContact, QuasistaticState, Refinement, Step};
use ndarray::Array2;

const BUDGET: Budget = Budget { tolerance: 1e-11, max_iterations: 1000 };

fn surface() -> (Body, Grid, Array2<f64>) {
    let grid = Grid::square(32, 1.0).unwrap();
    let waves = [(1, 0, 0.0, 1.0), (0, 2, 0.3, 0.6), (3, -2, 1.1, 0.4), (4, 5, 2.0, 0.2), (-6, 3, 0.7, 0.1)];
    let heights = Array2::from_shape_fn((32, 32), |(i, j)| {
        let height = |(m, n, phase, size): (i32, i32, f64, f64)| {
            size * (std::f64::consts::TAU * (f64::from(m) * i as f64 + f64::from(n) * j as f64) / 32.0 + phase).cos()
        };
        0.006 * waves.map(height).iter().sum::<f64>()
    });
    (Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap()), grid, heights)
}

fn plastic(boundary: Boundary, hardness: f64) -> QuasistaticContact {
    let (body, grid, heights) = surface();
    let hardness = Some(hardness.into());
    QuasistaticContact::new(&Parts { boundary, hardness, ..Parts::new(&body, &grid, &heights) }).unwrap()
}

fn volume(state: &QuasistaticState) -> f64 {
    state.plastic_volume().unwrap()
}

fn depth(state: &QuasistaticState) -> &Array2<f64> {
    state.plastic_depth().unwrap()
}

fn follow(contact: &QuasistaticContact, loads: &[f64]) -> Vec<(QuasistaticState, Step)> {
    let mut path = Path::new(contact, BUDGET, Refinement::default());
    let step = |load: &f64| {
        let step = path.step(Load::MeanPressure(*load).into(), &mut ()).unwrap();
        (path.state().unwrap().clone(), step)
    };
    loads.iter().map(step).collect()
}

fn most(a: &Array2<f64>) -> f64 {
    a.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

#[test]
fn unloading_is_elastic_and_loading_again_gives_the_state_before() {
    for boundary in Boundary::ALL {
        let contact = plastic(boundary, 0.05);
        let steps = follow(&contact, &[0.005, 0.01, 0.02, 0.01, 0.001, 0.01, 0.02, 0.025]);
        let [loaded, again] = [2, 6].map(|i| &steps[i].0);
        assert!(volume(loaded) > 0.0 && loaded.plastic_fraction > 0.1);
        assert!(most(&(&loaded.pressure() - &again.pressure())) < 1e-8, "{boundary}");
        let height = contact.surface().rms_height();
        assert!((loaded.approach() - again.approach()).abs() < 1e-9 * height);
        for (state, step) in &steps[3..7] {
            assert!(most(&(depth(state) - depth(loaded))) < 1e-9 * height, "{boundary}");
            assert!(step.dissipated.unwrap() < 1e-9 * steps[2].1.dissipated.unwrap(), "{boundary}");
        }
        // At the same load the contact is larger during unloading: the summits have become flat.
        let area = |i: usize| steps[i].0.summary().area_fraction;
        assert!(area(3) > area(1) && area(5) == area(3), "{boundary}: {} {}", area(1), area(3));
        assert!(volume(&steps[7].0) > volume(loaded));
    }
}

#[test]
fn loading_again_to_the_largest_load_brings_back_the_points_at_the_hardness() {
    // The state under a load borne before is unique: the same points carry the hardness, and no others.
    for (boundary, tolerance) in [(Boundary::Periodic, 1e-8), (Boundary::Periodic, 1e-11), (Boundary::Free, 1e-8)] {
        let contact = plastic(boundary, 0.05);
        let budget = Budget { tolerance, max_iterations: 1000 };
        let mut path = Path::new(&contact, budget, Refinement::default());
        let mut fractions = Vec::new();
        for load in [0.03, 0.001, 0.02, 0.03, 0.015, 0.03, 0.025, 0.03] {
            path.step(Load::MeanPressure(load).into(), &mut ()).unwrap();
            fractions.push(path.state().unwrap().plastic_fraction);
        }
        // As in the first loading, where the solver holds these points at the hardness exactly.
        let (body, grid, heights) = surface();
        let first = Contact::with_boundary(boundary, &body, &grid, &heights).unwrap().with_hardness(0.05).unwrap();
        let first = first.press(Load::MeanPressure(0.03)).budget(budget).solve().unwrap();
        let at_hardness = first.pressure.iter().filter(|p| **p == 0.05).count() as f64 / 1024.0;
        assert!(at_hardness > 0.3, "{at_hardness}");
        for again in [0, 3, 5, 7] {
            assert_eq!(fractions[again], at_hardness, "{boundary} {tolerance:e}: {fractions:?}");
        }
        // At a lower load, the same points carry less; the flattened summits have no sharp pressure peaks.
        for less in [1, 2, 4, 6] {
            assert!(fractions[less] < 0.05 * at_hardness, "{boundary} {tolerance:e}: {fractions:?}");
        }
    }
}

#[test]
fn a_surface_that_is_plastic_everywhere_is_certified_from_its_fields() {
    // A uniform pressure causes displacements only by rounding errors; gaps must not be measured relative to them.
    for points in [[6, 5], [7, 3], [9, 10], [15, 13]] {
        let grid = Grid::new(points, [1.50569, 1.25474]).unwrap();
        let heights = Array2::from_shape_fn(points, |(i, j)| 0.007 * (1.7 * i as f64 + 2.3 * (j * j) as f64).sin());
        let body = Body::half_space(Material::from_contact_modulus(1.22173, 0.0).unwrap());
        let hardness = Some(0.120071.into());
        let contact = QuasistaticContact::new(&Parts { hardness, ..Parts::new(&body, &grid, &heights) }).unwrap();
        let mut path = Path::new(&contact, BUDGET, Refinement::default());
        let load = Load::Approach(0.05);
        path.step(load.into(), &mut ()).unwrap();
        let state = path.state().unwrap();
        assert_eq!(state.plastic_fraction, 1.0);
        let again = contact.certify(&[&state.pressure(), depth(state)], load.into()).unwrap();
        assert!(state.worst() < 1e-12 && again.worst() < 1e-12, "{points:?}: {:?}", again.residuals());
    }
}

#[test]
fn the_work_of_the_path_is_stored_or_lost() {
    // ∫ p dδ minus the elastic energy is the plastic work; the trapezoidal rule is of second order, the implicit steps
    // are of first order.
    let errors = [8, 16, 32].map(|n| {
        let contact = plastic(Boundary::Periodic, 0.05);
        let up = (1..=n).map(|i| 0.03 * f64::from(i) / f64::from(n));
        let down = (1..n).rev().map(|i| 0.03 * f64::from(i) / f64::from(n));
        let steps = follow(&contact, &up.chain(down).collect::<Vec<_>>());
        let (mut work, mut last) = (0.0, (0.0, 0.0));
        for (state, _) in &steps {
            let now = (state.mean_pressure(), state.approach());
            work += 0.5 * (last.0 + now.0) * (now.1 - last.1);
            last = now;
        }
        let lost: f64 = steps.iter().map(|(_, step)| step.dissipated.unwrap()).sum();
        let stored = steps.last().unwrap().0.elastic_energy();
        ((work - stored - lost) / lost).abs()
    });
    assert!(errors[2] < 0.02, "{errors:?}");
    assert!(errors[1] < 0.7 * errors[0], "{errors:?}");
    assert!(errors[2] < 0.7 * errors[1], "{errors:?}");
}

#[test]
fn without_a_hardness_nothing_is_lost_and_the_way_does_not_matter() {
    let (body, grid, heights) = surface();
    let free = Contact::with_boundary(Boundary::Free, &body, &grid, &heights).unwrap();
    let direct = free.press(Load::MeanPressure(0.01)).budget(BUDGET).solve().unwrap();
    let parts = Parts { boundary: Boundary::Free, ..Parts::new(&body, &grid, &heights) };
    let steps = follow(&QuasistaticContact::new(&parts).unwrap(), &[0.02, 0.001, 0.01]);
    let (state, step) = steps.last().unwrap();
    assert_eq!((step.dissipated, step.dissipated_error, state.plastic_volume()), (Some(0.0), Some(0.0), None));
    assert!(most(&(&state.pressure() - &direct.pressure)) < 1e-9);
}

#[test]
fn a_state_is_certified_from_its_pressure_and_depth() {
    let contact = plastic(Boundary::Free, 0.05);
    let steps = follow(&contact, &[0.01, 0.02, 0.005]);
    for (state, _) in &steps {
        let drive = Load::MeanPressure(state.mean_pressure()).into();
        let found = contact.certify(&[&state.pressure(), depth(state)], drive).unwrap();
        assert!(found.worst() <= 1e-11 && found.losses.total().abs() < 1e-15);
        assert!(most(&(&found.gap() - &state.gap())) < 1e-12);
        // A state with another depth is not in equilibrium.
        let wrong = depth(state) + 1e-4 * &state.pressure();
        let wrong = contact.certify(&[&state.pressure(), &wrong], drive);
        assert!(wrong.unwrap().worst() > 1e-6);
    }
    let (state, _) = &steps[0];
    let refused = contact.certify(&[&state.pressure(), &Array2::zeros((2, 2))], Load::MeanPressure(0.01).into());
    assert!(refused.is_err());
}

#[test]
fn a_path_continues_bit_for_bit() {
    let contact = plastic(Boundary::Periodic, 0.05);
    let drives: Vec<Drive> = [0.01, 0.02, 0.005, 0.02].map(|load| Load::MeanPressure(load).into()).into();
    let whole = follow(&contact, &[0.01, 0.02, 0.005, 0.02]);
    for after in 0..3 {
        let mut path = Path::new(&contact, BUDGET, Refinement::default());
        let mut checkpoint = MemoryCheckpoint::default();
        for drive in &drives[..=after] {
            path.step(*drive, &mut ()).unwrap();
        }
        path.keep(&mut checkpoint);
        checkpoint.rewind();
        let mut path = Path::new(&contact, BUDGET, Refinement::default());
        path.resume(drives[after], &mut checkpoint).unwrap();
        for (drive, (state, step)) in drives.iter().zip(&whole).skip(after + 1) {
            let found = path.step(*drive, &mut ()).unwrap();
            let reached = path.state().unwrap();
            assert_eq!((found, depth(reached)), (*step, depth(state)));
            assert_eq!(reached.wall(), state.wall());
        }
    }
}

#[test]
fn a_state_is_kept_whole() {
    let contact = plastic(Boundary::Free, 0.05);
    let (mut state, _) = follow(&contact, &[0.01, 0.02]).pop().unwrap();
    let mut checkpoint = MemoryCheckpoint::default();
    contact.keep(&mut state, &mut checkpoint);
    checkpoint.rewind();
    let again = contact.restore(Load::MeanPressure(0.02).into(), &mut checkpoint).unwrap();
    assert_eq!((depth(&again), volume(&again), again.losses), (depth(&state), volume(&state), state.losses));
    let [again, state] = [&again, &state].map(|state| state.wall().unwrap());
    assert_eq!((&again.pressure, &again.displacement, &again.gap), (&state.pressure, &state.displacement, &state.gap));
    assert_eq!((again.mean_pressure, again.approach), (state.mean_pressure, state.approach));
    assert_eq!((again.residual, again.effort, &again.plastic), (state.residual, state.effort, &state.plastic));
    assert_eq!((again.scales(), again.summary()), (state.scales(), state.summary()));
}

#[test]
fn small_steps_take_few_iterations() {
    // Each step begins so close to its end that rounding errors of a single-precision gradient matter.
    let budget = Budget { max_iterations: 100, ..Budget::default() };
    for (hardness, load, fall) in [(0.02, 0.003, 2e-4), (0.03, 0.006, 1e-4), (0.015, 0.003, 4e-4), (0.02, 0.01, 4e-4)] {
        let contact = plastic(Boundary::Periodic, hardness);
        let mut path = Path::new(&contact, budget, Refinement::default());
        for k in 0..300 {
            let load = Load::MeanPressure(load * (1.0 - fall * f64::from(k)));
            if let Err(error) = path.step(load.into(), &mut ()) {
                panic!("hardness {hardness}, step {k}: {error}");
            }
        }
    }
}
