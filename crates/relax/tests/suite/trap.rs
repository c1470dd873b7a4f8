//! Tests of theory.md, section 6.3: with inertia close to the stiffness, clipping leads to a wrong point. The types of
//! this crate exclude this method; it is implemented here, together with the augmented Lagrangian that replaces it.

use std::f64::consts::TAU;

use gfmd_relax::{AugmentedLagrangian, Bounds, Landscape, Method, Nesterov, Proximal, RelaxError, Stop, Verlet, relax};

use crate::support::{active_set, bits, distance};

/// Periodic line of n nodes under a parabolic punch, with mode stiffness k(q) = √(q² + q₀²).
struct Line {
    stiffness: Vec<Vec<f64>>,
    punch: Vec<f64>,
}

const N: usize = 64;

fn k(m: usize) -> f64 {
    let q = m.min(N - m) as f64;
    (q * q + 0.25).sqrt()
}

/// Returns Σ over modes of g(k(q)) cos q(x − x') / n, a function of the stiffness matrix.
fn function_of_stiffness(g: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
    let entry = |distance: usize| {
        (0..N).map(|m| g(k(m)) * (TAU * (m * distance) as f64 / N as f64).cos()).sum::<f64>() / N as f64
    };
    (0..N).map(|i| (0..N).map(|j| entry(i.abs_diff(j))).collect()).collect()
}

fn times(matrix: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    matrix.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
}

const DEPTH: f64 = 0.3;

fn line() -> Line {
    let x = |i: usize| (i as f64 - 31.7) / N as f64;
    let punch = (0..N).map(|i| 8.0 * x(i) * x(i) - DEPTH).collect();
    Line { stiffness: function_of_stiffness(|k| k), punch }
}

impl Landscape for Line {
    fn len(&self) -> usize {
        N
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        let traction = times(&self.stiffness, u);
        force.iter_mut().zip(&traction).for_each(|(f, t)| *f = -t);
        0.5 * u.iter().zip(&traction).map(|(u, t)| u * t).sum::<f64>()
    }

    fn bounds(&self) -> Bounds<'_> {
        Bounds::Upper(&self.punch)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        let largest = force.iter().copied().fold(0.0, f64::max);
        self.bounds().natural_residual(u, force, largest, DEPTH)
    }
}

#[test]
fn scalar_mass_finds_the_solution_and_mass_like_stiffness_does_not() {
    let mut problem = line();
    let exact = active_set(&problem.stiffness, &[0.0; N], Some(&problem.punch));
    let touching = exact.iter().zip(&problem.punch).filter(|(u, z)| u >= z).count();
    assert!((10..50).contains(&touching), "{touching}");

    let verlet = Verlet::optimal(k(0), k(N / 2)).unwrap();
    let mut state = verlet.start(&mut problem, vec![0.0; N]).unwrap();
    let stop = Stop { residual: 1e-13, settled: 20, max_steps: 5000 };
    relax(&mut problem, &verlet, &mut state, &stop, &mut ()).unwrap();
    assert!(distance(&state.u, &exact) < 1e-12 * DEPTH, "{}", distance(&state.u, &exact) / DEPTH);

    // u₊ = Π(u + β (u − u₋) + τ M⁻¹ f) with M = √(K² + k₀²), so that all modes without bounds converge together.
    let inverse_mass = function_of_stiffness(|k| 1.0 / (k * k + 0.25f64.powi(2)).sqrt());
    let (beta, tau) = (0.3, 0.8);
    let run = |upper: Option<&[f64]>, mut u: Vec<f64>| {
        let mut previous = u.clone();
        let mut last_move = f64::INFINITY;
        for _ in 0..2000 {
            let force: Vec<f64> = times(&problem.stiffness, &u).iter().map(|t| -t).collect();
            let push = times(&inverse_mass, &force);
            let next: Vec<f64> = (0..N)
                .map(|i| u[i] + beta * (u[i] - previous[i]) + tau * push[i])
                .enumerate()
                .map(|(i, next)| upper.map_or(next, |upper| next.min(upper[i])))
                .collect();
            last_move = distance(&next, &u);
            previous = std::mem::replace(&mut u, next);
        }
        (u, last_move)
    };
    let (free, _) = run(None, exact.clone());
    assert!(distance(&free, &[0.0; N]) < 1e-14, "right without bounds");

    // With bounds, the iteration also settles, but at another point.
    let (wrong, last_move) = run(Some(&problem.punch), vec![0.0; N]);
    assert!(last_move < 1e-15, "settled: {last_move}");
    assert!(distance(&wrong, &exact) > 0.3 * DEPTH, "{}", distance(&wrong, &exact) / DEPTH);
    let force: Vec<f64> = times(&problem.stiffness, &wrong).iter().map(|t| -t).collect();
    assert!(problem.residual(&wrong, &force) > 0.1, "free entries carry a force: {}", problem.residual(&wrong, &force));
    // The iteration leaves the solution even if it starts there.
    let (walked, _) = run(Some(&problem.punch), exact.clone());
    assert!(distance(&walked, &wrong) < 1e-12);
}

/// Line with springs of stiffness ϱ at every node.
struct Sprung {
    line: Line,
    mobility: Vec<Vec<f64>>,
}

const PENALTY: f64 = 4.0;

impl Proximal for Sprung {
    fn len(&self) -> usize {
        N
    }

    fn bounds(&self) -> Bounds<'_> {
        self.line.bounds()
    }

    fn penalty(&self) -> f64 {
        PENALTY
    }

    fn settle(&mut self, anchor: &[f64], u: &mut [f64]) {
        u.copy_from_slice(&times(&self.mobility, anchor));
        u.iter_mut().for_each(|u| *u *= PENALTY);
    }

    fn residual(&self, mismatch: &[f64]) -> f64 {
        mismatch.iter().fold(0.0, |largest, x| f64::max(largest, x.abs())) / DEPTH
    }
}

#[test]
fn the_augmented_lagrangian_finds_the_solution_with_mass_like_stiffness() {
    let line = line();
    let exact = active_set(&line.stiffness, &[0.0; N], Some(&line.punch));
    let pressure: Vec<f64> = times(&line.stiffness, &exact).iter().map(|t| -t).collect();
    let peak = pressure.iter().copied().fold(0.0, f64::max);
    let mobility = function_of_stiffness(|k| 1.0 / (k + PENALTY));
    let mut problem = AugmentedLagrangian::new(Sprung { line, mobility });
    let stop = Stop { residual: 1e-13, settled: 0, max_steps: 2000 };
    for tau in [1.0, 1.2] {
        let method = Nesterov { tau };
        let mut state = method.start(&mut problem, vec![0.0; N]).unwrap();
        relax(&mut problem, &method, &mut state, &stop, &mut ()).unwrap();
        assert!(state.step < 200, "{} steps", state.step);
        let reaction = problem.reaction(&state.u);
        assert!(distance(&reaction, &pressure) < 1e-11 * peak, "{:e}", distance(&reaction, &pressure) / peak);
        let mut u = state.u.clone();
        problem.problem().bounds().project(&mut u);
        assert!(distance(&u, &exact) < 1e-12 * DEPTH, "{:e}", distance(&u, &exact) / DEPTH);
    }
}

/// A checkpoint consists of the state only; with a new problem, the run continues bit for bit.
#[test]
fn the_augmented_lagrangian_resumes_with_the_same_bits() {
    let mobility = function_of_stiffness(|k| 1.0 / (k + PENALTY));
    let problem = || AugmentedLagrangian::new(Sprung { line: line(), mobility: mobility.clone() });
    let method = Nesterov { tau: 1.2 };
    let run = |state: &mut _, max_steps| {
        let stop = Stop { residual: 0.0, settled: 0, max_steps };
        assert!(matches!(relax(&mut problem(), &method, state, &stop, &mut ()), Err(RelaxError::NotConverged { .. })));
    };
    let start = method.start(&mut problem(), vec![0.0; N]).unwrap();
    let (mut straight, mut resumed) = (start.clone(), start);
    run(&mut straight, 41);
    run(&mut resumed, 17);
    run(&mut resumed, 41);
    assert_eq!(bits(&straight.u), bits(&resumed.u));
    assert_eq!(straight, resumed);
}

/// Without momentum, the mismatch never grows for any penalty, and 0 < τ < 2 converges.
#[test]
fn plain_steps_of_the_augmented_lagrangian_only_get_shorter() {
    for penalty in [0.3, PENALTY, 50.0] {
        // Scaling the stiffness is equivalent to another penalty, up to a change of units.
        let scale = PENALTY / penalty;
        let mut line = line();
        line.stiffness = function_of_stiffness(|k| k * scale);
        let mobility = function_of_stiffness(|k| 1.0 / (k * scale + PENALTY));
        let mut problem = AugmentedLagrangian::new(Sprung { line, mobility });
        for tau in [0.5, 1.0, 1.9] {
            let mut v = vec![0.0; N];
            let mut force = vec![0.0; N];
            let mut before = f64::INFINITY;
            for _ in 0..300 {
                let merit = problem.force(&v, &mut force);
                assert!(merit <= before * (1.0 + 1e-12) + 1e-28, "{merit:e} after {before:e}");
                before = merit;
                v.iter_mut().zip(&force).for_each(|(v, f)| *v += tau * f);
            }
            assert!(before < 1e-3, "{before:e}");
        }
    }
}
