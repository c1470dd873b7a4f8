//! Time step, damping and damping of every mode of the dynamics, and the information given to a watcher.

use std::ops::ControlFlow;

use gfmd_contact::{
    Contact, Dynamics, Equilibrium, Factors, Fields, Load, Progress, Solution, SolveError, Solver, Watch,
};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use ndarray::Array2;

/// Returns the sum of a few waves.
fn heights(grid: &Grid, size: f64) -> Array2<f64> {
    let [nx, ny] = grid.points();
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [i as f64 / nx as f64, j as f64 / ny as f64].map(|turns| std::f64::consts::TAU * turns);
        size * ((x + 0.3).cos() + 0.4 * (2.0 * x - y + 1.0).cos() + 0.2 * (5.0 * x + 3.0 * y).cos())
    })
}

fn body(height: Height) -> Body {
    Body::new(Material::from_contact_modulus(1.0, 0.3).unwrap(), height).unwrap()
}

fn worst(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Damping of a mode, unlike its inertia, does not move the state at rest, not even at the wall (theory.md, section
/// 6.3).
#[test]
fn no_damping_and_no_time_step_changes_the_state_at_rest() {
    let grids = [Grid::line(81, 1.0).unwrap(), Grid::new([27, 24], [1.0, 0.8]).unwrap()];
    let one = |time_step, factor| Dynamics { time_step, damping: Factors::Softest(factor) };
    for grid in grids {
        for (height, load) in [
            (Height::Infinite, Load::MeanPressure(0.01)),
            (Height::Infinite, Load::Approach(0.004)),
            (Height::Finite(0.2), Load::MeanPressure(0.01)),
            (Height::Finite(0.2), Load::Approach(0.004)),
        ] {
            let contact = Contact::new(&body(height), &grid, &heights(&grid, 0.01)).unwrap();
            let expected = contact.press(load).tolerance(1e-11).solve().unwrap();
            let peak = expected.pressure.iter().copied().fold(0.0, f64::max);
            let mut cases = vec![
                (Solver::VerletModes, Dynamics::default()),
                (Solver::VerletModes, one(Some(0.6), 1.0)),
                (Solver::VerletCritical, one(Some(0.5), 1.5)),
                (Solver::VerletCritical, one(None, 0.5)),
            ];
            if let Height::Finite(_) = height {
                let damping = Factors::Components([1.0, 1.0, 0.7]);
                cases.push((Solver::VerletCritical, Dynamics { time_step: Some(0.5), damping }));
            }
            for (solver, dynamics) in cases {
                let contact = contact.clone().with_dynamics(dynamics);
                let press = contact.press(load).solver(solver).tolerance(1e-10).max_iterations(200_000);
                let found = press.solve().unwrap_or_else(|error| panic!("{solver} {dynamics:?} {load:?}: {error}"));
                assert!(worst(&found.pressure, &expected.pressure) < 1e-7 * peak, "{solver} {dynamics:?} {load:?}");
                let step = if solver == Solver::VerletModes { 2.0 } else { 1.0 };
                let Solution { effort, .. } = found;
                assert!(effort.transform_pairs >= step * effort.iterations as f64, "{effort:?}");
            }
        }
    }
}

#[derive(Default)]
struct Seen {
    steps: usize,
    energy: f64,
    last: Vec<f64>,
}

impl Watch for Seen {
    fn see(&mut self, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn layer(&mut self, energy: f64, u: &[f64]) {
        self.steps += 1;
        self.energy = energy;
        self.last = u.to_vec();
    }
}

/// Under a mean pressure the rigid surface stays at first touch, and the watcher sees u_z plus the approach.
#[test]
fn a_watcher_sees_displacement_and_energy_in_the_units_of_the_input() {
    let grid = Grid::square(16, 1.0).unwrap();
    for (modulus, lateral, normal) in [(1.0, 1.0, 1.0), (1e120, 1e-100, 1e-90)] {
        let grid = Grid::new([16, 16], [lateral, lateral]).unwrap_or(grid);
        let material = Material::from_contact_modulus(modulus, 0.3).unwrap();
        let body = Body::slab(material, 0.3 * lateral).unwrap();
        let heights = heights(&grid, 0.01 * normal);
        let mean = 0.01 * modulus * normal / lateral;
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        for solver in [Solver::Verlet, Solver::VerletModes, Solver::Fire2] {
            let mut seen = Seen::default();
            let press = contact.press(Load::MeanPressure(mean)).solver(solver).tolerance(1e-9);
            let found = press.watch(&mut seen).solve().unwrap();
            assert!(seen.steps as u64 > found.effort.iterations, "{solver}");
            let differences = found.displacement.iter().zip(&seen.last).map(|(u, seen)| seen - (u + found.approach));
            assert!(differences.fold(0.0, |m, d| f64::max(m, d.abs())) < 1e-7 * normal, "{solver}");
            // Elastic energy minus the work of the push; the uniform displacement stores nothing here.
            let uniform = 0.5 * mean * mean * body.level_compliance()[1];
            let work = mean * (found.displacement.mean().unwrap() + found.approach);
            let energy = found.summary().elastic_energy - uniform - work;
            assert!((seen.energy / 256.0 - energy).abs() < 1e-6 * energy.abs(), "{solver}");
        }
        // Neither the coordinates of the augmented Lagrangian nor the pressure are a displacement.
        for solver in [Solver::AugmentedLagrangian, Solver::Auto] {
            let mut seen = Seen::default();
            contact.press(Load::MeanPressure(mean)).solver(solver).watch(&mut seen).solve().unwrap();
            assert_eq!(seen.steps, 0, "{solver}");
        }
    }
}

#[test]
fn all_components_have_time_step_and_damping_too() {
    let grid = Grid::square(15, 1.0).unwrap();
    let contact = Contact::in_all_components(&body(Height::Finite(0.3)), &grid, &heights(&grid, 0.01)).unwrap();
    let press = |solver, dynamics| {
        let contact = contact.clone().with_dynamics(dynamics);
        contact.press(Load::MeanPressure(0.01)).solver(solver).tolerance(1e-10).solve()
    };
    let expected = press(Solver::Auto, Dynamics::default()).unwrap();
    let peak = expected.pressure.iter().copied().fold(0.0, f64::max);
    for (solver, time_step, damping) in [
        (Solver::VerletModes, None, Factors::Softest(1.0)),
        (Solver::VerletModes, Some(0.5), Factors::Softest(1.0)),
        (Solver::VerletCritical, Some(0.6), Factors::Softest(1.5)),
        (Solver::VerletCritical, Some(0.6), Factors::Components([1.0, 1.2, 0.8])),
    ] {
        let found = press(solver, Dynamics { time_step, damping }).unwrap();
        assert!(worst(&found.pressure, &expected.pressure) < 1e-7 * peak, "{solver} {damping:?}");
        let pairs = found.effort().transform_pairs / found.effort().iterations as f64;
        assert!(pairs >= if solver == Solver::VerletModes { 6.0 } else { 3.0 }, "{solver}: {pairs} pairs a step");
    }
}

#[test]
fn time_steps_and_dampings_out_of_their_range_are_refused() {
    let grid = Grid::square(9, 1.0).unwrap();
    let contact = |height| Contact::new(&body(height), &grid, &heights(&grid, 0.01)).unwrap();
    let full = Contact::in_all_components(&body(Height::Infinite), &grid, &heights(&grid, 0.01)).unwrap();
    for (solver, time_step, damping, word) in [
        (Solver::VerletCritical, Some(1.0), Factors::Softest(1.0), "below 1"),
        (Solver::VerletModes, Some(0.0), Factors::Softest(1.0), "above 0"),
        (Solver::VerletModes, Some(f64::NAN), Factors::Softest(1.0), "NaN"),
        (Solver::VerletCritical, None, Factors::Softest(1e3), "stability"),
        (Solver::VerletCritical, None, Factors::Softest(0.0), "positive"),
        (Solver::VerletCritical, None, Factors::Components([1.0; 3]), "compressible slab"),
    ] {
        let dynamics = Dynamics { time_step, damping };
        let contact = contact(Height::Infinite).with_dynamics(dynamics);
        let refused = contact.press(Load::MeanPressure(0.01)).solver(solver).solve().unwrap_err();
        assert!(matches!(refused, SolveError::Refused(_)) && refused.to_string().contains(word), "{refused}");
        let full = full.clone().with_dynamics(dynamics);
        let refused = full.press(Load::MeanPressure(0.01)).solver(solver).solve().unwrap_err();
        assert!(matches!(refused, SolveError::Refused(_)) && refused.to_string().contains(word), "{refused}");
    }
    let rubber = Body::slab(Material::from_young(1.0, 0.5).unwrap(), 0.3).unwrap();
    let dynamics = Dynamics { time_step: None, damping: Factors::Components([1.0; 3]) };
    let contact = Contact::new(&rubber, &grid, &heights(&grid, 0.01)).unwrap().with_dynamics(dynamics);
    assert!(contact.press(Load::MeanPressure(0.01)).solver(Solver::VerletCritical).solve().is_err());
}
