//! theory.md, section 6.3: inertia that follows the stiffness finds a wrong point as soon as clipping is involved.
//! This crate cannot express it; here it is written out.

use std::f64::consts::TAU;

use gfmd_relax::{Bounds, Landscape, Method, Stop, Verlet, relax};

use crate::support::{active_set, distance};

/// A periodic line of n nodes under a parabolic punch; stiffness k(q) = √(q² + q₀²) of its modes.
struct Line {
    stiffness: Vec<Vec<f64>>,
    punch: Vec<f64>,
}

const N: usize = 64;

fn k(m: usize) -> f64 {
    let q = m.min(N - m) as f64;
    (q * q + 0.25).sqrt()
}

/// Σ over modes of g(k(q)) cos q(x − x') / n: a function of the stiffness matrix.
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

    // u₊ = Π(u + β (u − u₋) + τ M⁻¹ f) with M = √(K² + k₀²), so that all modes without bounds converge together …
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

    // … and with them the iteration settles just as well, but elsewhere.
    let (wrong, last_move) = run(Some(&problem.punch), vec![0.0; N]);
    assert!(last_move < 1e-15, "settled: {last_move}");
    assert!(distance(&wrong, &exact) > 0.05 * DEPTH, "{}", distance(&wrong, &exact) / DEPTH);
    let force: Vec<f64> = times(&problem.stiffness, &wrong).iter().map(|t| -t).collect();
    assert!(problem.residual(&wrong, &force) > 0.1, "free entries carry a force: {}", problem.residual(&wrong, &force));
    // Even started from the solution it walks away from it.
    let (walked, _) = run(Some(&problem.punch), exact.clone());
    assert!(distance(&walked, &wrong) < 1e-12);
}
