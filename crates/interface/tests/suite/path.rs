//! Energy lost along paths: only in jumps, and independent of the division of the path.

use std::f64::consts::TAU;

use std::ops::ControlFlow;
use std::sync::Arc;

use gfmd_contact::{Boundary, Budget, Drive, Equilibrium, Load, Progress, SolveError};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, Path, Refinement, State, Step};
use gfmd_law::{CoupledExponential, Exponential, HarmonicCosine, Law, Limit, Morse, Separation, XuNeedleman};
use gfmd_response::{FullResponse, NormalResponse};
use ndarray::Array2;

const FINE: Refinement = Refinement { tolerance: 1e-3, solves_per_step: 20 };

fn material() -> Material {
    Material::from_contact_modulus(1.0, 0.0).unwrap()
}

fn half_space(n: usize) -> NormalResponse {
    NormalResponse::new(Grid::line(n, 1.0).unwrap(), &Body::half_space(material()))
}

/// Returns asperities of different height, which jump one by one.
fn asperities(n: usize) -> Array2<f64> {
    let phase = |i: usize| TAU * i as f64 / n as f64;
    Array2::from_shape_fn((n, 1), |(i, _)| {
        0.01 * phase(i).cos() + 0.006 * (3.0 * phase(i) + 1.0).cos() + 0.002 * (7.0 * phase(i) + 2.0).cos()
    })
}

/// Returns values from each waypoint to the next, in `steps` steps per leg.
fn legs(waypoints: &[f64], steps: usize) -> Vec<f64> {
    let inside = waypoints
        .windows(2)
        .flat_map(|leg| (0..steps).map(move |i| leg[0] + (leg[1] - leg[0]) * i as f64 / steps as f64));
    inside.chain(waypoints.last().copied()).collect()
}

fn approaches(waypoints: &[f64], steps: usize) -> Vec<Drive> {
    legs(waypoints, steps).into_iter().map(|approach| Load::Approach(approach).into()).collect()
}

fn pressures(waypoints: &[f64], steps: usize) -> Vec<Drive> {
    legs(waypoints, steps).into_iter().map(|pressure| Load::MeanPressure(pressure).into()).collect()
}

fn follow(interface: &Interface, drives: &[Drive], refinement: Refinement) -> Vec<Step> {
    let mut path = Path::new(interface, Budget::default(), refinement);
    drives.iter().map(|drive| path.step(*drive, &mut ()).unwrap()).collect()
}

/// Returns the loss along a path and its error.
fn lost(steps: &[Step]) -> [f64; 2] {
    [|step: &Step| step.dissipated, |step: &Step| step.dissipated_error]
        .map(|of| steps.iter().map(|step| of(step).unwrap()).sum())
}

/// Returns the trapezoidal work minus the energy gained, from the states at the drives alone.
fn by_trapezoids(interface: &Interface, drives: &[Drive]) -> f64 {
    let energy = |state: &State| state.elastic_energy + state.interface_energy;
    let (mut last, mut lost): (Option<State>, f64) = (None, 0.0);
    for drive in drives {
        let next = interface.press(*drive).starting_from(last.as_ref()).solve().unwrap();
        if let Some(last) = &last {
            let work = 0.5 * (last.mean_pressure + next.mean_pressure) * (next.approach - last.approach);
            lost += work + energy(last) - energy(&next);
        }
        last = Some(next);
    }
    lost
}

#[test]
fn a_closed_loop_loses_what_a_fine_path_loses() {
    let response = half_space(128);
    let law = Exponential::new(1e-4, 1.5e-3).unwrap();
    let interface = Interface::with_response(response, &asperities(128), law).unwrap();
    let turns = [-0.01, 0.004, -0.012];
    // With ten steps per leg the trapezoidal rule creates energy.
    assert!(by_trapezoids(&interface, &approaches(&turns, 10)) < 0.0);
    let fine = by_trapezoids(&interface, &approaches(&turns, 4000));
    for steps in [5, 10, 20] {
        let steps = follow(&interface, &approaches(&turns, steps), FINE);
        let [lost, error] = lost(&steps);
        assert!((lost - fine).abs() < 2e-3 * fine + error && error < 0.01 * lost, "{lost:e} ± {error:e}, {fine:e}");
        for step in &steps {
            let [lost, error] = [step.dissipated, step.dissipated_error].map(Option::unwrap);
            assert!(lost >= -error, "{step:?}");
        }
        // It jumps once during loading and once during unloading.
        assert_eq!(steps.iter().filter(|step| step.dissipated > Some(1e-8)).count(), 2);
    }
}

/// If the attraction is too steep for the grid, each point jumps on its own.
#[test]
fn small_jumps_within_long_steps_are_all_counted() {
    let enough = Refinement { solves_per_step: 100, ..FINE };
    for number in 0..6 {
        let n = 48 + 4 * number;
        let law = HarmonicCosine::new(1e-4, 30.0 + 8.0 * number as f64).unwrap();
        let interface = Interface::with_response(half_space(n), &asperities(n), law).unwrap();
        let turns = [0.002, -0.008];
        let fine = by_trapezoids(&interface, &approaches(&turns, 8000));
        for steps in [2, 3, 5] {
            let [lost, error] = lost(&follow(&interface, &approaches(&turns, steps), enough));
            assert!((lost - fine).abs() < 1e-3 * fine + error, "{lost:e} ± {error:e}, {fine:e}");
        }
    }
}

/// Near first touch the energy changes by less than its rounding errors.
#[test]
fn first_touch_takes_few_iterations() {
    let law = HarmonicCosine::new(1e-4, 8.0).unwrap();
    let interface = Interface::with_response(half_space(256), &asperities(256), law).unwrap();
    let refinement = Refinement { solves_per_step: 0, ..FINE };
    let steps = follow(&interface, &approaches(&[-0.01, -0.0072], 200), refinement);
    for (index, step) in steps.iter().enumerate() {
        assert!(step.effort.iterations < 60, "step {index}: {}", step.effort.iterations);
    }
}

#[test]
fn a_loop_under_load_loses_what_a_fine_path_loses() {
    let response = half_space(128);
    let law = Exponential::new(1e-4, 1.5e-3).unwrap();
    let interface = Interface::with_response(response, &asperities(128), law).unwrap();
    // The surface is pulled, but stays in contact.
    let turns = [1e-4, 2e-3, -2e-4, 1e-4];
    let fine = by_trapezoids(&interface, &pressures(&turns, 1500));
    for steps in [5, 15] {
        let [lost, error] = lost(&follow(&interface, &pressures(&turns, steps), FINE));
        assert!(
            (lost - fine).abs() < 2e-3 * fine.abs() + error && error < 0.02 * lost,
            "{lost:e} ± {error:e}, {fine:e}"
        );
    }
}

#[test]
fn a_flat_punch_on_a_soft_slab_loses_the_area_between_its_folds() {
    // One degree of freedom: a spring k, pulled by a law with a maximum. d(g) = -g - T(g)/k turns twice.
    let body = Body::slab(material(), 20.0).unwrap();
    let response = Arc::new(NormalResponse::new(Grid::line(8, 1.0).unwrap(), &body));
    let law = Morse::new(1e-3, 0.05).unwrap();
    let interface = Interface::with_response(Arc::clone(&response), &Array2::zeros((8, 1)), law).unwrap();
    let k = 1.0 / response.uniform_compliance();
    let tension = |g: f64| law.response(g, 0.0).traction[0];
    let approach = |g: f64| -g - tension(g) / k;
    let energy = |g: f64| 0.5 * tension(g).powi(2) / k + law.opening_energy(g);
    let bisect = |f: &dyn Fn(f64) -> f64, mut a: f64, mut b: f64| {
        assert!(f(a) * f(b) < 0.0);
        for _ in 0..80 {
            let middle = 0.5 * (a + b);
            if f(a) * f(middle) <= 0.0 { b = middle } else { a = middle }
        }
        0.5 * (a + b)
    };
    let turn = |g: f64| 1.0 + law.response(g, 0.0).jacobian[0][0] / k;
    // The steepest fall of the tension is at g = range ln 4, between the folds.
    let steepest = 0.05 * 4.0_f64.ln();
    let (near, far) = (bisect(&turn, 0.0, steepest), bisect(&turn, steepest, 1.0));
    let after_in = bisect(&|g| approach(g) - approach(far), -0.1, near);
    let after_out = bisect(&|g| approach(g) - approach(near), far, 5.0);
    let exact = energy(far) - energy(after_in) + energy(near) - energy(after_out);
    let turns = [approach(far) - 0.3, approach(far) + 0.1, approach(near) - 0.3];
    for steps in [3, 7] {
        let [lost, error] = lost(&follow(&interface, &approaches(&turns, steps), FINE));
        assert!((lost - exact).abs() <= error && error < 0.01 * exact, "{lost:e} ± {error:e}, {exact:e}");
    }
    // For any number of steps, the two steps across a fold are reported as jumps, and no others.
    let [closes, opens] = [approach(far), approach(near)];
    // No step ends at a fold.
    let turns = [closes - 0.3137, closes + 0.0971, opens - 0.2993];
    for steps in [10, 100, 1500] {
        let drives = approaches(&turns, steps);
        let made = follow(&interface, &drives, FINE);
        let reported: Vec<Option<bool>> = made.iter().map(|step| step.jumped).collect();
        let places: Vec<f64> = legs(&turns, steps);
        for (k, reported) in reported.iter().enumerate().skip(1) {
            let (from, to) = (places[k - 1], places[k]);
            let crosses = (from < closes && closes < to) || (to < opens && opens < from);
            let around = &made[k - 1..=(k + 1).min(made.len() - 1)];
            assert_eq!(*reported, Some(crosses), "{steps} steps: {from} to {to}, folds {closes} {opens}: {around:?}");
        }
        assert_eq!(reported.iter().filter(|reported| **reported == Some(true)).count(), 2, "{steps}");
    }
    // Without extra solves the steps with a jump remain undecided.
    let once = Refinement { solves_per_step: 0, ..FINE };
    let reported = follow(&interface, &approaches(&turns, 10), once);
    assert_eq!(reported.iter().filter(|step| step.jumped == Some(true)).count(), 0);
    assert!(reported.iter().any(|step| step.jumped.is_none()));
    // Under a tension below its maximum the contact holds and loses no energy.
    let strongest = law.response(0.05 * 2.0_f64.ln(), 0.0).traction[0];
    let turns = [0.5 * strongest, -0.9 * strongest, 0.5 * strongest];
    let [lost, error] = lost(&follow(&interface, &pressures(&turns, 4), FINE));
    assert!(lost.abs() <= error && error < 1e-3 * exact, "{lost:e} ± {error:e}");
}

#[test]
fn without_a_jump_nothing_is_lost() {
    let response = half_space(128);
    let law = Exponential::new(1e-4, 1.5e-3).unwrap();
    let interface = Interface::with_response(response, &asperities(128), law).unwrap();
    let [low, high] =
        [0.001, 0.004].map(|approach| interface.press(Load::Approach(approach)).solve().unwrap().mean_pressure);
    let closely = Refinement { tolerance: 1e-5, solves_per_step: 20 };
    for drives in [approaches(&[0.001, 0.004, 0.001], 6), pressures(&[low, high, low], 6)] {
        let half = by_trapezoids(&interface, &drives[..7]).abs();
        let [lost, error] = lost(&follow(&interface, &drives, closely));
        assert!(lost.abs() <= error && error < 0.2 * half, "{lost:e} ± {error:e}, {half:e}");
    }
}

#[test]
fn the_balance_of_a_smooth_step_closes_with_the_fourth_power_of_its_length() {
    let response = half_space(64);
    let law = Morse::new(1e-4, 1e-2).unwrap();
    let interface = Interface::with_response(response, &asperities(64), law).unwrap();
    // One state in the middle of each step, no more.
    let once = Refinement { tolerance: 1e-3, solves_per_step: 1 };
    let error = |steps: usize| lost(&follow(&interface, &approaches(&[-0.02, -0.005], steps), once))[1];
    let order = (error(4) / error(16)).log2() / 2.0;
    assert!((order - 4.0).abs() < 0.4, "observed order {order}");
}

#[test]
fn sideways_work_is_accounted_for() {
    let equal = Separation { normal_work: 5e-4, tangential_work: 5e-4, normal_length: 0.02, tangential_length: 0.02 };
    let law = XuNeedleman::new(equal, 0.5).unwrap();
    let heights = asperities(16);
    let sideways = |turns: &[f64], steps: usize| -> Vec<Drive> {
        let drive = |x| Drive { load: Load::Approach(0.002), lateral: [x, 0.0], time: 0.0, distance: 0.0 };
        legs(turns, steps).into_iter().map(drive).collect()
    };
    // A half-space is too stiff to jump; a thick slab jumps in both directions.
    for (body, jumps) in [(Body::half_space(material()), false), (Body::slab(material(), 3.0).unwrap(), true)] {
        let response = Arc::new(FullResponse::new(Grid::line(16, 1.0).unwrap(), &body));
        let interface = Interface::with_response(Arc::clone(&response), &heights, law).unwrap();
        let turns = if jumps { [0.0, 0.2, -0.2] } else { [0.0, 0.02, -0.02] };
        let [few, error_of_few] = lost(&follow(&interface, &sideways(&turns, 6), FINE));
        let [many, error_of_many] = lost(&follow(&interface, &sideways(&turns, 15), FINE));
        assert!((few - many).abs() <= error_of_few + error_of_many, "{few:e} ± {error_of_few:e}, {many:e}");
        assert_eq!(few > 10.0 * error_of_few, jumps, "{few:e} ± {error_of_few:e}");
    }
}

#[test]
fn a_law_without_an_energy_has_no_loss_and_friction_knows_its_own() {
    let response = Arc::new(FullResponse::new(Grid::line(16, 1.0).unwrap(), &Body::half_space(material())));
    let different =
        Separation { normal_work: 1e-4, tangential_work: 5e-5, normal_length: 0.01, tangential_length: 0.01 };
    let law = CoupledExponential::new(different).unwrap();
    let heights = asperities(16);
    let drive = |x| Drive { load: Load::Approach(0.002), lateral: [x, 0.0], time: 0.0, distance: 0.0 };
    let interface = Interface::with_response(Arc::clone(&response), &heights, law).unwrap();
    for step in follow(&interface, &[drive(0.0), drive(0.002)], Refinement::default()) {
        assert_eq!((step.dissipated, step.dissipated_error, step.extra_solves), (None, None, 0));
    }
    // If pressure and shear are uncoupled, a step is one increment.
    let incompressible = Body::half_space(Material::from_contact_modulus(1.0, 0.5).unwrap());
    let grid = Grid::line(16, 1.0).unwrap();
    let contact = crate::rubbing(Boundary::Periodic, &incompressible, &grid, &heights, Limit::Coulomb(0.2));
    let mut path = Path::new(&contact, Budget::default(), Refinement::default());
    for x in [0.0, 0.002] {
        let step = path.step(drive(x), &mut ()).unwrap();
        let known = path.state().unwrap().losses.total();
        assert_eq!((step.dissipated, step.dissipated_error, step.extra_solves), (Some(known), None, 0));
    }
    assert!(path.state().unwrap().losses.total() > 0.0);
}

#[test]
fn an_interrupted_path_stands_where_it_was_and_goes_on() {
    let response = half_space(64);
    let law = Exponential::new(1e-4, 3e-3).unwrap();
    let interface = Interface::with_response(response, &asperities(64), law).unwrap();
    let mut path = Path::new(&interface, Budget::default(), FINE);
    path.step(Load::Approach(-0.01).into(), &mut ()).unwrap();
    let mut calls = 0;
    let stopped = path.step(Load::Approach(0.002).into(), &mut |_: &Progress| {
        calls += 1;
        if calls < 40 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    assert!(matches!(stopped, Err(SolveError::Interrupted { .. })));
    let stands = path.state().unwrap().approach;
    assert!((-0.01..0.002).contains(&stands), "{stands}");
    path.step(Load::Approach(0.002).into(), &mut ()).unwrap();
    assert_eq!(path.state().unwrap().approach, 0.002);
}
