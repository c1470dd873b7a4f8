//! Tests of how runs end: converged, interrupted, out of steps, diverged.

use std::{cell::Cell, io, ops::ControlFlow};

use gfmd_relax::{
    Bounds, Budget, Damping, Divergence, Ending, Every, Fire, Landscape, Method, Observer, OnRise, Outcome, Progress,
    RelaxError, State, Status, Stop, Trail, Verlet, VerletState, Why, relax, relax_until,
};

use crate::support::{Chain, distance, scattered};

const STOP: Stop = Stop { residual: 1e-12, settled: 20, max_steps: 10_000 };

fn optimal(problem: &Chain) -> Verlet {
    let (k_min, k_max) = problem.band();
    Verlet::optimal(k_min, k_max).unwrap()
}

#[test]
fn a_quadratic_with_a_known_answer() {
    // K = [[2, −1], [−1, 3]], load = (1, 1): u = (4, 3) / 5, U = −7/10.
    let mut problem = Chain {
        diagonal: vec![2.0, 3.0],
        coupling: vec![-1.0],
        load: vec![1.0; 2],
        lower: None,
        upper: None,
        calls: 0,
    };
    let (k_min, k_max) = problem.band();
    assert!((k_min - (2.5 - 1.25f64.sqrt())).abs() < 1e-12 && (k_max - (2.5 + 1.25f64.sqrt())).abs() < 1e-12);
    let method = optimal(&problem);
    let mut state = method.start(&mut problem, vec![10.0, -7.0]).unwrap();
    let Outcome::Converged(reached) = relax(&mut problem, &method, &mut state, &STOP, &mut ()).unwrap() else {
        panic!("interrupted")
    };
    assert!(distance(&state.u, &[0.8, 0.6]) < 1e-12);
    assert!((reached.energy + 0.7).abs() < 1e-12);
    assert_eq!(reached, state.status(&problem));
}

#[test]
fn not_converged_is_an_error_that_carries_the_numbers() {
    let mut problem = Chain::springs(50, 0.01, |_| 1.0);
    let method = optimal(&problem);
    let mut state = method.start(&mut problem, vec![0.0; 50]).unwrap();
    let stop = Stop { max_steps: 17, ..STOP };
    match relax(&mut problem, &method, &mut state, &stop, &mut ()) {
        Err(error @ RelaxError::NotConverged { reached, asked }) => {
            assert_eq!(asked, stop);
            assert_eq!(reached, state.status(&problem));
            assert_eq!((reached.step, reached.evaluations), (17, 18));
            assert!(reached.residual > 1e-3);
            let message = error.to_string();
            assert!(
                message.starts_with("not converged after 17 steps") && message.contains("asked 1e-12"),
                "{message}"
            );
        }
        other => panic!("{other:?}"),
    }
    // The run continues from the state.
    assert!(matches!(relax(&mut problem, &method, &mut state, &STOP, &mut ()), Ok(Outcome::Converged(_))));
}

/// The run continues if the residual is small but the active set still changes.
#[test]
fn converged_needs_a_settled_active_set() {
    let mut problem = Chain::springs(30, 0.05, |_| 0.3).below(vec![1.5; 30]);
    let method = optimal(&problem);
    let steps = |settled, problem: &mut Chain| {
        let mut state = method.start(problem, vec![0.0; 30]).unwrap();
        let stop = Stop { residual: 1e3, settled, ..STOP };
        relax(problem, &method, &mut state, &stop, &mut ()).unwrap();
        (state.step, state.settled)
    };
    assert_eq!(steps(0, &mut problem), (0, 0));
    let (step, settled) = steps(20, &mut problem);
    assert!(step > 20 && settled == 20, "entries reach the bound on the way: {step}");
    problem.upper = None;
    assert_eq!(steps(20, &mut problem), (0, 0), "without bounds there is nothing to settle");
}

/// `settled` counts exactly the steps in which no entry reached or left its bound.
#[test]
fn settled_counts_the_quiet_steps() {
    fn on_bound(problem: &Chain, u: &[f64]) -> Vec<bool> {
        let at = |bound: &Option<Vec<f64>>, i: usize| bound.as_ref().is_some_and(|bound| bound[i] == u[i]);
        (0..u.len()).map(|i| at(&problem.lower, i) || at(&problem.upper, i)).collect()
    }
    fn check<M: Method>(method: &M, problem: &mut Chain) {
        let mut state = method.start(problem, scattered(40)).unwrap();
        let mut changes = 0;
        for _ in 0..400 {
            let (before, settled, evaluations) = (on_bound(problem, &state.u), state.settled, state.evaluations);
            method.step(problem, &mut state).unwrap();
            if before != on_bound(problem, &state.u) {
                assert_eq!(state.settled, 0);
                changes += 1;
            } else if state.evaluations == evaluations + 1 {
                assert_eq!(state.settled, settled + 1);
            } else {
                // A step back and forth: an entry may have left its bound and returned.
                assert!(state.settled == 0 || state.settled == settled + 1);
            }
        }
        assert!(changes > 5 && state.settled > 5, "{changes} {}", state.settled);
    }
    let below = Chain::springs(40, 0.02, |i| 0.2 * (0.3 * i as f64).sin()).below(vec![0.4; 40]);
    let between = below.clone().above(vec![-0.3; 40]);
    for mut problem in [below, between] {
        let dt = Fire::largest_dt(problem.band().1);
        check(&optimal(&problem), &mut problem);
        check(&Fire::bitzek(dt), &mut problem);
        check(&Fire::v2(dt), &mut problem);
    }
}

#[test]
fn observers_see_every_step_and_can_stop() {
    let mut problem = Chain::springs(20, 0.1, |_| 1.0);
    let method = optimal(&problem);
    let mut state = method.start(&mut problem, vec![0.0; 20]).unwrap();
    let (seen, rare) = (Cell::new(0), Cell::new(0));
    let look = |now: &Status, state: &VerletState| {
        assert_eq!(now.step, seen.get());
        assert_eq!(now.step, state.step);
        seen.set(now.step + 1);
        Ok(if now.step == 25 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    };
    let glance = |now: &Status, _: &VerletState| {
        assert_eq!(now.step % 10, 0);
        rare.set(rare.get() + 1);
        Ok(ControlFlow::Continue(()))
    };
    let mut watch = (look, Every { steps: 10, inner: glance });
    let outcome = relax(&mut problem, &method, &mut state, &STOP, &mut watch).unwrap();
    assert_eq!(outcome, Outcome::Interrupted(state.status(&problem)));
    assert_eq!((state.step, seen.get(), rare.get()), (25, 26, 3));

    // Each observer of a pair can stop the run.
    let now = state.status(&problem);
    let stop = |_: &Status, _: &VerletState| Ok(ControlFlow::Break(()));
    assert!(((), stop).observe(&now, &state).unwrap().is_break());
    assert!((stop, ()).observe(&now, &state).unwrap().is_break());
    assert!(Every { steps: 0, inner: stop }.observe(&now, &state).unwrap().is_continue());
}

#[test]
fn a_failing_observer_ends_the_run_with_its_error() {
    let mut problem = Chain::springs(20, 0.1, |_| 1.0);
    let method = optimal(&problem);
    let mut state = method.start(&mut problem, vec![0.0; 20]).unwrap();
    let mut full = |_: &Status, _: &VerletState| Err(io::Error::new(io::ErrorKind::StorageFull, "disk full"));
    match relax(&mut problem, &method, &mut state, &STOP, &mut full) {
        Err(RelaxError::Observer(error)) => assert_eq!(error.kind(), io::ErrorKind::StorageFull),
        other => panic!("{other:?}"),
    }
    assert_eq!(state.step, 0);
}

#[test]
fn a_time_step_beyond_the_limit_is_noticed_within_a_few_steps() {
    let mut problem = Chain::springs(50, 0.1, |_| 0.1).below(vec![0.6; 50]);
    let k_max = problem.band().1;
    let damping = Damping { beta: 0.8, tau: 5.0 / k_max };
    let method = Verlet { damping, on_rise: OnRise::Continue };
    assert!(matches!(Verlet::new(damping, k_max), Err(RelaxError::TimeStep { .. })));
    let mut state = method.start(&mut problem, scattered(50)).unwrap();
    match relax(&mut problem, &method, &mut state, &STOP, &mut ()) {
        Err(error @ RelaxError::Diverged { reached, reason, stable_up_to }) => {
            assert!(reached.step <= 20, "{}", reached.step);
            assert_eq!(reached.step, state.step);
            assert_eq!(reason, Divergence::Energy { found: state.energy, allowed: 1e8 * state.energy_scale });
            assert!((stable_up_to - 3.6 / damping.tau).abs() < 1e-12 && stable_up_to < k_max);
            assert!(state.u.iter().all(|u| u.is_finite()));
            let message = error.to_string();
            assert!(message.starts_with("diverged at step") && message.contains("stiffness of 2."), "{message}");
        }
        other => panic!("{other:?}"),
    }

    let dt = 50.0;
    let fire = Fire { dt_start: dt, dt_min: dt, ..Fire::bitzek(dt) };
    let mut state = fire.start(&mut problem, scattered(50)).unwrap();
    match relax(&mut problem, &fire, &mut state, &STOP, &mut ()) {
        Err(RelaxError::Diverged { reached, stable_up_to, .. }) => {
            assert!(reached.step <= 5, "{}", reached.step);
            assert_eq!(stable_up_to, 4.0 / (dt * dt));
        }
        other => panic!("{other:?}"),
    }
}

/// The strongest growth of a stable run (stiffest mode, optimal damping) does not count as divergence.
#[test]
fn a_transient_is_no_divergence() {
    let (k_min, k_max) = (1e-5, 1.0);
    let mut problem = Chain::modes(&[k_min, k_max]);
    let method = Verlet::optimal(k_min, k_max).unwrap();
    let mut state = method.start(&mut problem, vec![0.0, 1.0]).unwrap();
    let (start, mut highest) = (state.energy, 0.0);
    let mut watch = |now: &Status, _: &VerletState| {
        highest = f64::max(highest, now.energy / start);
        Ok(ControlFlow::Continue(()))
    };
    assert!(relax(&mut problem, &method, &mut state, &STOP, &mut watch).is_ok());
    assert!(highest > 0.9 / 7.4 * k_max / k_min, "{highest:e}");
}

/// Landscape that returns given values.
struct Given {
    energy: f64,
    force: f64,
    residual: f64,
}

impl Landscape for Given {
    fn len(&self) -> usize {
        3
    }
    fn force(&mut self, _: &[f64], force: &mut [f64]) -> f64 {
        force.fill(self.force);
        self.energy
    }
    fn residual(&self, _: &[f64], _: &[f64]) -> f64 {
        self.residual
    }
}

#[test]
fn numbers_that_are_none_end_the_run() {
    let method = Verlet { damping: Damping { beta: 0.5, tau: 0.1 }, on_rise: OnRise::Continue };
    let good = Given { energy: 1.0, force: 1.0, residual: 1.0 };
    for mut bad in [
        Given { energy: f64::NAN, ..good },
        Given { energy: f64::INFINITY, ..good },
        Given { residual: f64::NAN, ..good },
        Given { residual: f64::INFINITY, ..good },
    ] {
        let mut state = method.start(&mut bad, vec![0.0; 3]).unwrap();
        match relax(&mut bad, &method, &mut state, &STOP, &mut ()) {
            Err(RelaxError::Diverged { reason: Divergence::NotFinite, reached, .. }) => assert_eq!(reached.step, 0),
            other => panic!("{other:?}"),
        }
    }
    let mut good = good;
    let mut state = method.start(&mut good, vec![0.0; 3]).unwrap();
    assert!(matches!(
        relax(&mut good, &method, &mut state, &Stop { max_steps: 3, ..STOP }, &mut ()),
        Err(RelaxError::NotConverged { .. })
    ));
}

#[test]
fn a_bound_does_not_hide_what_is_not_a_number() {
    let upper = [1.0, 1.0];
    let bounds = Bounds::Upper(&upper);
    let mut u = [f64::NAN, 2.0];
    bounds.project(&mut u);
    assert!(u[0].is_nan() && u[1] == 1.0);
    assert!(bounds.natural_residual(&u, &[0.0; 2], 1.0, 1.0).is_nan());
    assert!(bounds.natural_residual(&[0.0; 2], &[f64::NAN, 0.0], 1.0, 1.0).is_nan());
}

#[test]
fn the_natural_residual_sees_all_three_kinds_of_error() {
    let (lower, upper) = ([-1.0; 4], [1.0; 4]);
    let residual = |u: [f64; 4], force: [f64; 4]| {
        Bounds::Between { lower: &lower, upper: &upper }.natural_residual(&u, &force, 8.0, 2.0)
    };
    assert_eq!(residual([0.0, 1.0, -1.0, 0.5], [0.0, 5.0, -7.0, 0.0]), 0.0);
    assert_eq!(residual([0.0; 4], [0.0, 0.0, -2.0, 1.0]), 0.25); // force on a free entry
    assert_eq!(residual([0.75, 0.0, 0.0, 0.0], [50.0, 0.0, 0.0, 0.0]), 0.125); // not yet at its bound
    assert_eq!(residual([0.0, 1.0, 0.0, 0.0], [0.0, -3.0, 0.0, 0.0]), 0.375); // held back by its bound
    assert_eq!(residual([0.0, 0.0, 1.5, 0.0], [0.0, 0.0, 4.0, 0.0]), 0.25); // beyond its bound
    let above = Bounds::Upper(&upper);
    assert_eq!(above.natural_residual(&[-9.0; 4], &[0.0, 0.0, -1.0, 0.0], 8.0, 2.0), 0.125);
    assert_eq!(Bounds::Free.natural_residual(&[9.0; 2], &[1.0, -3.0], 8.0, 2.0), 0.375);
    assert!(above.holds(1, 1.0, 0.2));
    assert!(!above.holds(1, 1.0, -0.2));
    assert!(!above.holds(1, 0.9, 0.2));
    assert!(Bounds::Between { lower: &lower, upper: &upper }.holds(2, -1.0, -0.1));
    assert!(!Bounds::Free.holds(0, 1.0, 1.0));
}

#[test]
fn vectors_and_bounds_that_do_not_fit_are_refused() {
    let mut problem = Chain::springs(8, 0.1, |_| 1.0);
    let method = optimal(&problem);
    assert!(matches!(
        method.start(&mut problem, vec![0.0; 7]),
        Err(RelaxError::Length { what: "displacements", found: 7, allowed: 8 })
    ));
    let good = method.start(&mut problem, vec![0.0; 8]).unwrap();
    let run = |problem: &mut Chain, mut state: VerletState| relax(problem, &method, &mut state, &STOP, &mut ());
    let mut state = good.clone();
    state.force.pop();
    assert!(matches!(run(&mut problem, state), Err(RelaxError::Length { what: "forces", .. })));
    let state = State { memory: Trail { previous: vec![], at_rest: true }, ..good.clone() };
    assert!(matches!(
        run(&mut problem, state),
        Err(RelaxError::Length { what: "previous displacements", found: 0, .. })
    ));

    problem.upper = Some(vec![1.0; 9]);
    assert!(matches!(run(&mut problem, good.clone()), Err(RelaxError::Length { what: "upper bounds", .. })));
    problem.upper = Some(vec![1.0, 1.0, 1.0, f64::NAN, 1.0, 1.0, 1.0, 1.0]);
    assert!(matches!(run(&mut problem, good.clone()), Err(RelaxError::Bounds { index: 3, .. })));
    problem.upper = Some(vec![1.0; 8]);
    problem.lower = Some(vec![0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    assert!(matches!(
        method.start(&mut problem, vec![0.0; 8]),
        Err(RelaxError::Bounds { index: 5, lower: 2.0, upper: 1.0 })
    ));
    problem.lower = Some(vec![0.0; 3]);
    assert!(matches!(run(&mut problem, good), Err(RelaxError::Length { what: "lower bounds", found: 3, allowed: 8 })));
}

#[test]
fn an_empty_problem_is_solved() {
    struct Nothing;
    impl Landscape for Nothing {
        fn len(&self) -> usize {
            0
        }
        fn force(&mut self, _: &[f64], _: &mut [f64]) -> f64 {
            0.0
        }
        fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
            self.bounds().natural_residual(u, force, 1.0, 1.0)
        }
    }
    assert!(Nothing.is_empty());
    let method = Fire::v2(1.0);
    let mut state = method.start(&mut Nothing, vec![]).unwrap();
    assert!(relax(&mut Nothing, &method, &mut state, &STOP, &mut ()).is_ok());
}

/// Landscape with zero residual everywhere, as after an underflow.
struct Blind;

impl Landscape for Blind {
    fn len(&self) -> usize {
        1
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        force[0] = -u[0];
        0.5 * u[0] * u[0]
    }

    fn residual(&self, _: &[f64], _: &[f64]) -> f64 {
        0.0
    }
}

#[test]
fn a_certificate_that_never_holds_ends_the_search() {
    let method = Verlet::optimal(0.5, 2.0).unwrap();
    for (worst, why) in [(1.0, Why::Rounding), (f64::NAN, Why::Diverged(Divergence::NotFinite))] {
        let mut state = method.start(&mut Blind, vec![1.0]).unwrap();
        let mut certify = |_: &mut Blind, _: &VerletState| worst;
        let ending = relax_until(&mut Blind, &method, &mut state, &Budget::default(), &mut certify, &mut ()).unwrap();
        assert_eq!(ending, Ending::GaveUp(why));
    }
}

#[test]
fn the_target_is_tightened_until_the_certificate_holds() {
    let mut problem = Chain::springs(20, 0.1, |_| 1.0);
    let (softest, stiffest) = problem.band();
    let method = Verlet::optimal(softest, stiffest).unwrap();
    let mut state = method.start(&mut problem, vec![0.0; 20]).unwrap();
    // This certificate is a thousand times stricter than the method.
    let mut certify = |problem: &mut Chain, state: &VerletState| 1e3 * state.status(problem).residual;
    let mut seen = 0;
    let mut watch = |now: &Progress| {
        seen = now.iteration;
        ControlFlow::Continue(())
    };
    let budget = Budget { tolerance: 1e-6, ..Budget::default() };
    let ending = relax_until(&mut problem, &method, &mut state, &budget, &mut certify, &mut watch).unwrap();
    assert_eq!(ending, Ending::Converged);
    assert!(state.status(&problem).residual <= 1e-9 && seen == state.step);
    let few = Budget { max_iterations: 3, ..budget };
    let mut state = method.start(&mut problem, vec![0.0; 20]).unwrap();
    let ending = relax_until(&mut problem, &method, &mut state, &few, &mut certify, &mut ()).unwrap();
    assert_eq!((ending, state.step), (Ending::GaveUp(Why::Iterations), 3));
}
