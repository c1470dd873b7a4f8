//! Tests of damping that depends on the mode.

use approx::assert_relative_eq;
use gfmd_relax::{Damping, Method, ModeDamped, Outcome, Stop, Verlet, relax};

use crate::support::{Chain, distance, scattered};

const MODES: [f64; 6] = [0.01, 0.03, 0.2, 0.7, 1.9, 3.9];

/// Returns the critical damping of each entry, for a problem in which entries are modes.
fn critical_for_all(tau: f64) -> impl Fn(&mut [f64]) {
    move |motion| {
        for (d, k) in motion.iter_mut().zip(MODES) {
            *d *= Damping::critical(k, tau.sqrt()).beta;
        }
    }
}

#[test]
fn no_mode_oscillates_and_the_softest_is_as_slow_as_with_one_damping() {
    let tau: f64 = 0.25;
    let method = ModeDamped::critical(tau, critical_for_all(tau));
    let mut problem = Chain::modes(&MODES);
    let mut state = method.start(&mut problem, vec![1.0; 6]).unwrap();
    for step in 1..=600 {
        let before = state.u.clone();
        method.step(&mut problem, &mut state).unwrap();
        for ((u, before), k) in state.u.iter().zip(before).zip(MODES) {
            assert!((0.0..=before).contains(u), "mode {k}, step {step}: {before:e} to {u:e}");
            let predicted = Damping::critical(k, tau.sqrt()).amplitude(k, step);
            assert_relative_eq!(*u, predicted, max_relative = 1e-9, epsilon = 1e-14);
        }
    }
    let one = Verlet::critical(MODES[0], MODES[5], tau.sqrt()).unwrap();
    assert_relative_eq!(one.damping.amplitude(MODES[0], 600), state.u[0], max_relative = 1e-9);
    // With a uniform damping, the stiff modes oscillate.
    assert!((1..600).any(|step| one.damping.amplitude(MODES[3], step) < 0.0));
}

/// Damping acts on motion only: the final point does not depend on the coefficients, with or without bounds.
#[test]
fn any_damping_ends_at_the_solution() {
    let n = 60;
    let table = (0..n).map(|i| 0.4 + 0.25 * (0.55 * f64::from(i)).sin()).collect();
    let mut problem = Chain::springs(60, 0.01, |_| 0.02).below(table);
    let exact = problem.solution();
    let betas: Vec<f64> = scattered(60).iter().map(|s| 0.8 + 0.15 * s).collect();
    let (_, k_max) = problem.band();
    let method = ModeDamped {
        tau: 1.0 / k_max,
        stiffness_limit: k_max,
        retain: |motion: &mut [f64]| motion.iter_mut().zip(&betas).for_each(|(d, beta)| *d *= beta),
    };
    let stop = Stop { residual: 1e-13, settled: 20, max_steps: 20_000 };
    let mut state = method.start(&mut problem, vec![0.0; 60]).unwrap();
    assert!(matches!(relax(&mut problem, &method, &mut state, &stop, &mut ()), Ok(Outcome::Converged(_))));
    assert!(distance(&state.u, &exact) < 1e-10, "{:e}", distance(&state.u, &exact));
}
