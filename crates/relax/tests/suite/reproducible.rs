//! Tests that results are bitwise equal after a restart and for any number of threads.

use gfmd_relax::{
    Fire, Landscape, Method, ModeDamped, Momentum, Nesterov, Outcome, RelaxError, State, Status, Stop, Verlet, relax,
};

use crate::support::{Chain, bits, scattered};

fn pressed(n: usize) -> Chain {
    Chain::springs(n, 0.02, |i| 0.1 + 0.05 * (1.3 * i as f64).sin())
        .below(scattered(n).iter().map(|s| 1.0 + s).collect())
}

fn boxed(n: usize) -> Chain {
    let problem = pressed(n);
    problem.above(scattered(n).iter().map(|s| s - 0.5).collect())
}

/// Runs a function with every method.
macro_rules! with_all_methods {
    ($problem:expr, $method:ident => $body:expr) => {{
        let (k_min, k_max) = (0.02, 4.02);
        let dt = Fire::largest_dt(k_max);
        let critical = Verlet::critical(k_min, k_max, 0.6 * dt).unwrap();
        for $method in [critical, critical.guarded(k_max).unwrap(), Verlet::optimal(k_min, k_max).unwrap()] {
            $body
        }
        for $method in [Fire::bitzek(dt), Fire::v2(dt)] {
            $body
        }
        for $method in [Nesterov::new(k_max).unwrap()] {
            $body
        }
        let slow_down = |motion: &mut [f64]| motion.iter_mut().for_each(|d| *d *= 0.9);
        for $method in [ModeDamped { tau: 0.2, stiffness_limit: 19.0, retain: slow_down }] {
            $body
        }
    }};
}

/// Converts a vector to bytes and back, as a checkpoint file would.
fn through_bytes(x: &[f64]) -> Vec<f64> {
    x.iter().map(|x| f64::from_le_bytes(x.to_le_bytes())).collect()
}

trait Reload {
    fn reload(&self) -> Self;
    fn all_bits(&self) -> Vec<u64>;
}

impl Reload for gfmd_relax::Trail {
    fn reload(&self) -> Self {
        Self { previous: through_bytes(&self.previous), at_rest: self.at_rest }
    }
    fn all_bits(&self) -> Vec<u64> {
        [bits(&self.previous), vec![self.at_rest.into()]].concat()
    }
}

impl Reload for gfmd_relax::Flight {
    fn reload(&self) -> Self {
        let Self { velocity, dt, alpha, downhill, uphill } = self;
        Self { velocity: through_bytes(velocity), dt: *dt, alpha: *alpha, downhill: *downhill, uphill: *uphill }
    }
    fn all_bits(&self) -> Vec<u64> {
        let numbers = [self.dt.to_bits(), self.alpha.to_bits(), self.downhill.into(), self.uphill.into()];
        [bits(&self.velocity), numbers.to_vec()].concat()
    }
}

impl Reload for Momentum {
    fn reload(&self) -> Self {
        Self { previous: through_bytes(&self.previous), age: self.age, length: self.length }
    }
    fn all_bits(&self) -> Vec<u64> {
        [bits(&self.previous), vec![self.age.to_bits(), self.length.to_bits()]].concat()
    }
}

impl<M: Reload> Reload for State<M> {
    fn reload(&self) -> Self {
        let Self { u, force, energy, step, settled, evaluations, energy_scale, memory } = self;
        Self {
            u: through_bytes(u),
            force: through_bytes(force),
            energy: *energy,
            step: *step,
            settled: *settled,
            evaluations: *evaluations,
            energy_scale: *energy_scale,
            memory: memory.reload(),
        }
    }
    fn all_bits(&self) -> Vec<u64> {
        let numbers = [self.energy.to_bits(), self.step, self.settled, self.evaluations, self.energy_scale.to_bits()];
        [bits(&self.u), bits(&self.force), numbers.to_vec(), self.memory.all_bits()].concat()
    }
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    for problem in [Chain::springs(300, 0.02, |i| (i as f64).sin()), pressed(300), boxed(300)] {
        with_all_methods!(problem, method => {
            let to = |max_steps| Stop { residual: 0.0, settled: 0, max_steps };
            let run = |state: &mut _, steps| match relax(&mut problem.clone(), &method, state, &to(steps), &mut ()) {
                Err(RelaxError::NotConverged { reached, .. }) => assert_eq!(reached.step, steps),
                other => panic!("{other:?}"),
            };
            let start = method.start(&mut problem.clone(), vec![0.0; 300]).unwrap();

            let mut straight = start.reload();
            run(&mut straight, 137);
            let mut first = start.reload();
            run(&mut first, 59);
            let mut resumed = first.reload();
            drop(first);
            run(&mut resumed, 137);
            assert_eq!(straight.all_bits(), resumed.all_bits());
            assert_ne!(straight.all_bits(), start.all_bits());
        });
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let n = 9_000;
    for problem in [Chain::springs(n, 0.02, |i| (i as f64).sin()), pressed(n), boxed(n)] {
        with_all_methods!(problem, method => {
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let mut problem = problem.clone();
                    let mut state = method.start(&mut problem, scattered(n)).unwrap();
                    for _ in 0..60 {
                        method.step(&mut problem, &mut state).unwrap();
                    }
                    (state.all_bits(), problem.residual(&state.u, &state.force).to_bits())
                })
            };
            let one = on(1);
            assert_eq!(one, on(2));
            assert_eq!(one, on(4));
        });
    }
}

/// There is one evaluation at the start, per step, and per step back; the residual needs none.
#[test]
fn forces_are_evaluated_once_per_step() {
    with_all_methods!(problem, method => {
        let mut problem = pressed(120);
        let mut state = method.start(&mut problem, vec![0.0; 120]).unwrap();
        assert_eq!((problem.calls, state.evaluations), (1, 1));
        let mut back = 0;
        let mut last = 1;
        let mut watch = |now: &Status, _: &_| {
            back += (now.evaluations - last).saturating_sub(1);
            last = now.evaluations;
            Ok(std::ops::ControlFlow::Continue(()))
        };
        let stop = Stop { residual: 1e-10, settled: 20, max_steps: 10_000 };
        let Outcome::Converged(reached) = relax(&mut problem, &method, &mut state, &stop, &mut watch).unwrap() else {
            panic!("not converged")
        };
        assert_eq!(problem.calls, reached.evaluations);
        assert_eq!(reached.evaluations, reached.step + 1 + back);
        assert!(back < reached.step / 5);
        // The force of the state is the force at its point.
        let mut force = vec![0.0; 120];
        let energy = problem.force(&state.u, &mut force);
        assert_eq!((energy, force), (state.energy, state.force));
    });
}
