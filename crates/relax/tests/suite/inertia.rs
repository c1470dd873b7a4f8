//! Tests of inertia close to the stiffness, without bounds.

use gfmd_relax::{Bounds, Inertial, Landscape, Method, Nesterov, Outcome, Smooth, Stop, Verlet, relax};

use crate::support::{Chain, distance, scattered, solve};

/// Chain with M = K + k₀.
struct Weighted {
    chain: Chain,
    extra: f64,
}

impl Smooth for Weighted {
    fn len(&self) -> usize {
        self.chain.len()
    }

    fn accelerate(&mut self, u: &[f64], acceleration: &mut [f64]) -> f64 {
        let energy = self.chain.force(u, acceleration);
        let mut mass = self.chain.matrix();
        mass.iter_mut().enumerate().for_each(|(i, row)| row[i] += self.extra);
        acceleration.copy_from_slice(&solve(mass, acceleration.to_vec()));
        energy
    }

    fn residual(&self, _: &[f64], acceleration: &[f64]) -> f64 {
        acceleration.iter().fold(0.0, |largest, a| f64::max(largest, a.abs()))
    }
}

const STOP: Stop = Stop { residual: 1e-12, settled: 20, max_steps: 10_000 };

fn steps(problem: &mut dyn Landscape, method: &impl Method) -> (u64, Vec<f64>) {
    let start = scattered(problem.len());
    let mut state = method.start(problem, start).unwrap();
    match relax(problem, method, &mut state, &STOP, &mut ()) {
        Ok(Outcome::Converged(reached)) => (reached.step, state.u),
        other => panic!("{other:?}"),
    }
}

/// M⁻¹ K has the eigenvalues k/(k + k₀): the number of steps is small and equal for 10 and 80 springs, while it grows
/// with a scalar mass.
#[test]
fn steps_do_not_grow_with_the_number_of_modes() {
    let mut counts = Vec::new();
    for n in [10, 80] {
        let chain = Chain::springs(n, 0.0, |_| 0.1);
        let exact = chain.solution();
        let (k_min, k_max) = chain.band();
        let extra = k_min;
        let mut weighted = Inertial(Weighted { chain: chain.clone(), extra });
        assert!(matches!(weighted.bounds(), Bounds::Free));
        let band = |k: f64| k / (k + extra);
        let [heavy, scalar] = [(band(k_min), band(k_max)), (k_min, k_max)].map(|(a, b)| Verlet::optimal(a, b).unwrap());
        let (heavy, u) = steps(&mut weighted, &heavy);
        assert!(distance(&u, &exact) < 1e-10 * exact[n / 2], "{:e}", distance(&u, &exact));
        let (accelerated, u) = steps(&mut weighted, &Nesterov::new(1.0).unwrap());
        assert!(distance(&u, &exact) < 1e-10 * exact[n / 2], "{:e}", distance(&u, &exact));
        let (scalar, _) = steps(&mut chain.clone(), &scalar);
        counts.push([heavy, accelerated, scalar]);
    }
    let [few, many] = counts[..] else { panic!("two sizes") };
    assert!(many[0] <= few[0] + 5 && many[0] < 30, "{few:?} {many:?}");
    assert!(many[1] <= few[1] + 10 && many[1] < 60, "{few:?} {many:?}");
    assert!(many[2] > 4 * few[2], "{few:?} {many:?}");
}
