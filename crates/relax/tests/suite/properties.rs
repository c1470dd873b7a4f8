//! Property tests with random chains and random bounds.

use gfmd_relax::{Damping, Fire, Landscape, Method, Outcome, Stop, Verlet, relax};
use proptest::prelude::*;

use crate::support::{Chain, distance};

/// Generates strictly diagonally dominant, hence positive definite, chains with couplings of both signs and optional
/// bounds.
fn chains() -> impl Strategy<Value = Chain> {
    (2..40usize).prop_flat_map(|n| {
        let coupling = prop::collection::vec(-1.0..1.0, n - 1);
        let extra = prop::collection::vec(0.05..2.0, n);
        let load = prop::collection::vec(-1.0..1.0, n);
        let upper = prop::option::of(prop::collection::vec(-0.5..1.5, n));
        let depth = prop::option::of(prop::collection::vec(0.0..1.0, n));
        (coupling, extra, load, upper, depth).prop_map(|(coupling, extra, load, upper, depth)| {
            let pull = |i: Option<usize>| i.and_then(|i| coupling.get(i)).map_or(0.0, |c: &f64| c.abs());
            let diagonal = (0..load.len()).map(|i| extra[i] + pull(i.checked_sub(1)) + pull(Some(i))).collect();
            let lower =
                upper.as_ref().zip(depth).map(|(upper, depth)| upper.iter().zip(depth).map(|(z, d)| z - d).collect());
            Chain { diagonal, coupling, load, lower, upper, calls: 0 }
        })
    })
}

/// Solves by projected Gauss–Seidel, which is slow but converges on all these problems.
fn by_sweeps(problem: &Chain) -> Vec<f64> {
    let n = problem.len();
    let mut u = vec![0.0; n];
    for _ in 0..100_000 {
        let before = u.clone();
        for i in 0..n {
            let left = if i > 0 { problem.coupling[i - 1] * u[i - 1] } else { 0.0 };
            let right = if i + 1 < n { problem.coupling[i] * u[i + 1] } else { 0.0 };
            let value: f64 = (problem.load[i] - left - right) / problem.diagonal[i];
            let value = problem.upper.as_ref().map_or(value, |upper| value.min(upper[i]));
            u[i] = problem.lower.as_ref().map_or(value, |lower| value.max(lower[i]));
        }
        if distance(&u, &before) < 1e-16 {
            break;
        }
    }
    u
}

const STOP: Stop = Stop { residual: 1e-12, settled: 20, max_steps: 20_000 };

fn settle(method: &impl Method, mut problem: Chain) -> Result<Vec<f64>, TestCaseError> {
    let n = problem.len();
    let mut state = method.start(&mut problem, vec![0.0; n]).map_err(|error| TestCaseError::fail(error.to_string()))?;
    match relax(&mut problem, method, &mut state, &STOP, &mut ()) {
        Ok(Outcome::Converged(_)) => Ok(state.u),
        other => Err(TestCaseError::fail(format!("{other:?}"))),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn every_method_finds_the_minimum_of_every_chain(problem in chains(), share in 0.2..1.0) {
        let (k_min, k_max) = problem.band();
        let exact = by_sweeps(&problem);
        let optimal = Verlet::optimal(k_min, k_max).unwrap();
        let critical = Verlet::critical(k_min, k_max, share * optimal.damping.tau.sqrt()).unwrap();
        let dt = Fire::largest_dt(k_max);
        for u in [
            settle(&optimal, problem.clone())?,
            settle(&critical, problem.clone())?,
            settle(&Fire::bitzek(dt), problem.clone())?,
            settle(&Fire::v2(dt), problem.clone())?,
        ] {
            prop_assert!(distance(&u, &exact) < 1e-10, "{}", distance(&u, &exact));
        }
    }

    /// All stable parameters lead to the solution.
    #[test]
    fn stable_damping_converges(problem in chains(), beta in -0.6..0.95, share in 0.1..0.95) {
        let (_, k_max) = problem.band();
        let damping = Damping { beta, tau: share * 2.0 * (1.0 + beta) / k_max };
        let verlet = Verlet::new(damping, k_max).unwrap();
        let u = settle(&verlet, problem.clone())?;
        prop_assert!(distance(&u, &by_sweeps(&problem)) < 1e-10);
    }

    /// All iterates satisfy the bounds, and entries off their bounds are not held.
    #[test]
    fn points_stay_allowed(problem in chains(), start in prop::collection::vec(-5.0..5.0, 40)) {
        let mut problem = problem;
        let n = problem.len();
        let fire = Fire::v2(Fire::largest_dt(problem.band().1));
        let mut state = fire.start(&mut problem, start[..n].to_vec()).unwrap();
        for _ in 0..100 {
            for i in 0..n {
                prop_assert!(problem.upper.as_ref().is_none_or(|upper| state.u[i] <= upper[i]));
                prop_assert!(problem.lower.as_ref().is_none_or(|lower| state.u[i] >= lower[i]));
            }
            fire.step(&mut problem, &mut state).unwrap();
        }
    }
}
