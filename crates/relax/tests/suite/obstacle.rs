//! Tests that all methods find the exact solution for chains pressed against bounds.

use gfmd_relax::{Fire, Landscape, Method, Nesterov, Outcome, Stop, Verlet, relax};

use crate::support::{Chain, distance, scattered};

const STOP: Stop = Stop { residual: 1e-13, settled: 20, max_steps: 20_000 };

fn settle(method: &impl Method, problem: &mut Chain, u: Vec<f64>) -> Vec<f64> {
    let mut state = method.start(problem, u).unwrap();
    match relax(problem, method, &mut state, &STOP, &mut ()) {
        Ok(Outcome::Converged(reached)) => {
            assert!(reached.residual <= STOP.residual && reached.settled >= STOP.settled)
        }
        other => panic!("{other:?}"),
    }
    state.u
}

/// Returns the solution by every method, from two starts.
fn by_all_methods(problem: &Chain) -> Vec<(&'static str, Vec<f64>)> {
    let (k_min, k_max) = problem.band();
    let dt = Fire::largest_dt(k_max);
    let critical = Verlet::critical(k_min, k_max, 0.7 * dt).unwrap();
    let optimal = Verlet::optimal(k_min, k_max).unwrap();
    let guarded = Verlet::critical(k_min, k_max, 0.6 * dt).unwrap().guarded(k_max).unwrap();
    let accelerated = Nesterov::new(k_max).unwrap();
    [vec![0.0; problem.len()], scattered(problem.len())]
        .into_iter()
        .flat_map(|start| {
            [
                ("critical", settle(&critical, &mut problem.clone(), start.clone())),
                ("optimal", settle(&optimal, &mut problem.clone(), start.clone())),
                ("critical, guarded", settle(&guarded, &mut problem.clone(), start.clone())),
                ("accelerated", settle(&accelerated, &mut problem.clone(), start.clone())),
                ("FIRE 2006", settle(&Fire::bitzek(dt), &mut problem.clone(), start.clone())),
                ("FIRE 2.0", settle(&Fire::v2(dt), &mut problem.clone(), start)),
            ]
        })
        .collect()
}

fn count_touching(u: &[f64], upper: &[f64]) -> usize {
    u.iter().zip(upper).filter(|(u, z)| u >= z).count()
}

#[test]
fn a_chain_pressed_against_a_table() {
    let n = 60;
    // A wavy table, low in the middle, gives several separate contacts.
    let table = (0..n).map(|i| 0.4 + 0.25 * (0.55 * i as f64).sin() + 1e-3 * (i as f64 - 31.3).powi(2)).collect();
    let problem = Chain::springs(n, 0.01, |_| 0.02).below(table);
    let exact = problem.solution();
    let touching = count_touching(&exact, problem.upper.as_ref().unwrap());
    assert!((5..n / 2).contains(&touching), "{touching} entries touch");
    for (method, u) in by_all_methods(&problem) {
        assert!(distance(&u, &exact) < 1e-10, "{method}: {}", distance(&u, &exact));
        assert_eq!(count_touching(&u, problem.upper.as_ref().unwrap()), touching, "{method}");
    }
}

#[test]
fn a_lifted_chain_pulls_off_where_it_should() {
    // Without a load, a bound below zero presses the chain down like a punch; elsewhere the chain is free.
    let n = 41;
    let punch: Vec<f64> = (0..n).map(|i| 0.005 * (i as f64 - 17.2).powi(2) - 0.3).collect();
    let problem = Chain::springs(n, 0.2, |_| 0.0).below(punch);
    let exact = problem.solution();
    let touching = count_touching(&exact, problem.upper.as_ref().unwrap());
    assert!((3..15).contains(&touching), "{touching}");
    for (method, u) in by_all_methods(&problem) {
        assert!(distance(&u, &exact) < 1e-10, "{method}");
    }
}

#[test]
fn without_a_bound_the_answer_is_that_of_elimination() {
    let problem = Chain::springs(50, 0.03, |i| (i as f64).cos());
    let exact = problem.solution();
    for (method, u) in by_all_methods(&problem) {
        assert!(distance(&u, &exact) < 1e-10, "{method}");
    }
    // An infinite bound gives bitwise the result without bounds.
    let bounded = problem.clone().below(vec![f64::INFINITY; 50]);
    let optimal = Verlet::optimal(problem.band().0, problem.band().1).unwrap();
    let (mut a, mut b) = (problem, bounded);
    assert_eq!(settle(&optimal, &mut a, vec![0.0; 50]), settle(&optimal, &mut b, vec![0.0; 50]));
}

#[test]
fn equal_bounds_hold_entries_where_they_are_told() {
    // Three entries are fixed, as under a sticking punch; between them the solution is linear.
    let n = 21;
    let stuck = [(4, 0.7), (5, -0.2), (15, 0.5)];
    let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]);
    for (i, value) in stuck {
        (lower[i], upper[i]) = (value, value);
    }
    let problem = Chain::springs(n, 0.0, |_| 0.0).below(upper).above(lower);
    let exact = |i: usize| match i {
        0..=4 => 0.7 * (i + 1) as f64 / 5.0,
        5..=15 => -0.2 + 0.7 * (i - 5) as f64 / 10.0,
        _ => 0.5 * (n - i) as f64 / 6.0,
    };
    let exact: Vec<f64> = (0..n).map(exact).collect();
    for (method, u) in by_all_methods(&problem) {
        assert!(distance(&u, &exact) < 1e-10, "{method}");
        assert!(stuck.iter().all(|&(i, value)| u[i] == value), "{method}");
    }
}

#[test]
fn two_sided_bounds_agree_with_their_mirror_image() {
    let n = 45;
    let load = |i: usize| 0.1 * (0.4 * i as f64).sin();
    let (low, high): (Vec<_>, Vec<_>) = scattered(n).iter().map(|s| (-0.3 + 0.1 * s, 0.2 + 0.1 * s)).unzip();
    let problem = Chain::springs(n, 0.02, load).below(high.clone()).above(low.clone());
    let minus = |x: &[f64]| x.iter().map(|x| -x).collect::<Vec<_>>();
    let mirrored = Chain::springs(n, 0.02, |i| -load(i)).below(minus(&low)).above(minus(&high));
    let (k_min, k_max) = problem.band();
    let methods = by_all_methods(&problem);
    let reference = &methods[0].1;
    let held = |u: &[f64], z: &[f64]| u.iter().zip(z).filter(|(u, z)| u == z).count();
    assert!(held(reference, &low) > 3 && held(reference, &high) > 3, "both sides are active");
    for (method, u) in &methods {
        assert!(distance(u, reference) < 1e-10, "{method}");
    }
    let optimal = Verlet::optimal(k_min, k_max).unwrap();
    assert_eq!(
        minus(&settle(&optimal, &mut mirrored.clone(), vec![0.0; n])),
        settle(&optimal, &mut problem.clone(), vec![0.0; n])
    );
}

/// Fixing entries keeps the spectrum inside the band (theory.md, section 6.5), so that the error decreases at least as
/// fast as predicted once the active set has settled.
#[test]
fn the_final_rate_is_that_of_the_band_or_better() {
    let n = 60;
    let table = (0..n).map(|i| 0.4 + 0.25 * (0.55 * i as f64).sin() + 1e-3 * (i as f64 - 31.3).powi(2)).collect();
    let mut problem = Chain::springs(n, 0.01, |_| 0.02).below(table);
    let exact = problem.solution();
    let (k_min, k_max) = problem.band();
    let optimal = Verlet::optimal(k_min, k_max).unwrap();
    let mut state = optimal.start(&mut problem, vec![0.0; n]).unwrap();
    while state.settled < 20 || distance(&state.u, &exact) > 1e-5 {
        assert!(state.step < 5000);
        optimal.step(&mut problem, &mut state).unwrap();
    }
    let (from, error) = (state.step, distance(&state.u, &exact));
    while distance(&state.u, &exact) > 1e-6 * error {
        optimal.step(&mut problem, &mut state).unwrap();
    }
    let steps = (state.step - from) as f64;
    let predicted = 6.0 * optimal.damping.steps_per_decade(k_min, k_max);
    assert!(steps < predicted * 1.05, "{steps} steps, predicted {predicted}");
}
