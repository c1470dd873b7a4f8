//! Tests of two fields, coupled by a matrix and by their means, against every active set.

use gfmd_relax::{Budget, Ending, MemoryCheckpoint, Paired, PreconditionedCg, RelaxError, Target, Upper, Visit, Watch};

/// Dense matrix, with its diagonal as the preconditioner.
struct Dense {
    matrix: Vec<f64>,
    linear: Vec<f64>,
    upper: Upper,
}

impl Dense {
    /// Creates a matrix B Bᵀ + 0.1 with pseudo-random numbers from `seed`.
    fn new(n: usize, seed: u64) -> Self {
        let mut state = seed;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let b: Vec<f64> = (0..n * n).map(|_| number()).collect();
        let entry = |i: usize, j: usize| {
            (0..n).map(|k| b[i * n + k] * b[j * n + k]).sum::<f64>() + if i == j { 0.1 } else { 0.0 }
        };
        let matrix = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        Self { matrix, linear: (0..n).map(|_| number()).collect(), upper: Upper::All(f64::INFINITY) }
    }

    fn gradient(&self, x: &[f64]) -> Vec<f64> {
        let n = x.len();
        (0..n).map(|i| self.linear[i] + (0..n).map(|j| self.matrix[i * n + j] * x[j]).sum::<f64>()).collect()
    }
}

impl Paired for Dense {
    fn linear(&self) -> &[f64] {
        &self.linear
    }

    fn upper(&self) -> Upper {
        self.upper.clone()
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        let full = self.gradient(x);
        out.iter_mut().zip(full.iter().zip(&self.linear)).for_each(|(out, (g, b))| *out = g - b);
    }

    fn precondition(&mut self, x: &[f64], gradient: &[f64], out: &mut [f64]) {
        let n = x.len();
        for i in 0..n {
            let full = x[i] >= self.upper.ceiling().at(i);
            let free = if full { gradient[i] > 0.0 } else { x[i] > 0.0 || gradient[i] < 0.0 };
            out[i] = if free { gradient[i] / self.matrix[i * n + i] } else { 0.0 };
        }
    }
}

fn target(mean: Option<f64>) -> Target {
    Target { mean, gradient_scale: 1.0, budget: Budget { tolerance: 1e-11, max_iterations: 20_000 } }
}

/// Returns the largest violation of the optimality conditions, with multipliers from the positive variables.
fn violation(problem: &Dense, x: &[f64], mean: Option<f64>) -> f64 {
    let middle = x.len() / 2;
    let mut gradient = problem.gradient(x);
    let full = |k: usize| x[k] >= problem.upper.ceiling().at(k);
    let of = |range: std::ops::Range<usize>, gradient: &[f64]| {
        let inside = range.filter(|k| x[*k] > 0.0 && !full(*k));
        inside.fold((0.0, 0.0), |(sum, count), k| (sum + gradient[k], count + 1.0))
    };
    let ((a, na), (b, nb)) = (of(0..middle, &gradient), of(middle..x.len(), &gradient));
    let multipliers = match mean {
        Some(_) => [a / na, b / nb],
        None => [(a - b) / (na + nb), (b - a) / (na + nb)],
    };
    (0..x.len()).for_each(|k| gradient[k] -= multipliers[usize::from(k >= middle)]);
    let wrong = |k: usize| match x[k] {
        _ if full(k) => gradient[k],
        x if x > 0.0 => gradient[k].abs(),
        _ => -gradient[k],
    };
    (0..x.len()).map(wrong).fold(0.0, f64::max)
}

#[test]
fn the_conditions_of_the_minimum_hold_and_the_means_are_kept() {
    for seed in 1..30 {
        for mean in [Some(0.3), None] {
            let mut problem = Dense::new(12, seed);
            problem.linear.iter_mut().for_each(|b| *b -= 0.2);
            let mut x = vec![0.3; 12];
            let minimum = PreconditionedCg.minimise_pair(&mut problem, &mut x, &target(mean), &mut ()).unwrap();
            assert_eq!(minimum.ending, Ending::Converged, "{seed} {mean:?}: {minimum:?}");
            let [first, second]: [f64; 2] = [0, 6].map(|start| x[start..start + 6].iter().sum::<f64>() / 6.0);
            let asked = mean.unwrap_or(first);
            assert!((first - asked).abs() < 1e-14 && (second - asked).abs() < 1e-13, "{seed}: {first} {second}");
            assert!(x.iter().all(|x| *x >= 0.0));
            let wrong = violation(&problem, &x, mean);
            assert!(wrong < 1e-9 || first < 1e-9, "{seed} {mean:?}: {wrong} {x:?}");
        }
    }
}

#[test]
fn upper_bounds_are_kept() {
    for seed in 1..30 {
        for mean in [Some(0.2), None] {
            for upper in [Upper::All(0.35), Upper::Each((0..12).map(|k| 0.3 + 0.02 * f64::from(k)).collect())] {
                let mut problem = Dense::new(12, seed);
                problem.linear.iter_mut().for_each(|b| *b -= 0.3);
                problem.upper = upper;
                let mut x = vec![0.2; 12];
                let minimum = PreconditionedCg.minimise_pair(&mut problem, &mut x, &target(mean), &mut ()).unwrap();
                assert_eq!(minimum.ending, Ending::Converged, "{seed} {mean:?}: {minimum:?}");
                let [first, second]: [f64; 2] = [0, 6].map(|start| x[start..start + 6].iter().sum::<f64>() / 6.0);
                let asked = mean.unwrap_or(first);
                assert!((first - asked).abs() < 1e-12 && (second - asked).abs() < 1e-12, "{seed}: {first} {second}");
                let ceiling = problem.upper.ceiling();
                assert!((0..12).all(|k| x[k] >= 0.0 && x[k] <= ceiling.at(k)));
                let between = |half: usize| (6 * half..6 * half + 6).any(|k| x[k] > 0.0 && x[k] < ceiling.at(k));
                if mean.is_none() && (between(0) || between(1)) || between(0) && between(1) {
                    let wrong = violation(&problem, &x, mean);
                    assert!(wrong < 1e-9 || first < 1e-9, "{seed} {mean:?}: {wrong} {x:?}");
                }
            }
        }
    }
}

#[test]
fn unusable_starts_are_refused() {
    let minimise = |x: &mut [f64], mean| {
        let mut problem = Dense::new(x.len(), 3);
        PreconditionedCg.minimise_pair(&mut problem, x, &target(mean), &mut ())
    };
    assert!(matches!(minimise(&mut [1.0; 5], None), Err(RelaxError::Parameter { .. })));
    assert!(matches!(minimise(&mut [0.0; 4], Some(1.0)), Err(RelaxError::AllZero)));
    assert!(matches!(minimise(&mut [1.0, f64::NAN, 1.0, 1.0], None), Err(RelaxError::Start { .. })));
    assert!(matches!(minimise(&mut [1.0; 4], Some(-1.0)), Err(RelaxError::Parameter { .. })));
    let mut problem = Dense::new(4, 3);
    let refused = PreconditionedCg.minimise_pair(&mut problem, &mut [1.0; 6], &target(None), &mut ());
    assert!(refused.is_err());
}

/// Watcher that keeps the checkpoint of one call, or resumes from it.
#[derive(Default)]
struct Keeper {
    at: usize,
    calls: usize,
    kept: MemoryCheckpoint,
    resumes: bool,
}

impl Watch for Keeper {
    fn see(&mut self, _: &gfmd_relax::Progress) -> std::ops::ControlFlow<()> {
        std::ops::ControlFlow::Continue(())
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        if self.at == self.calls && !self.resumes {
            variables(&mut self.kept);
        }
        self.calls += 1;
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        (self.resumes && !self.kept.is_at_end()).then_some(&mut self.kept)
    }
}

#[test]
fn a_search_continues_bit_for_bit() {
    let solve = |keeper: &mut Keeper| {
        let mut x = vec![0.3; 16];
        PreconditionedCg.minimise_pair(&mut Dense::new(16, 8), &mut x, &target(Some(0.3)), keeper).unwrap();
        x
    };
    let mut whole = Keeper::default();
    let expected = solve(&mut whole);
    for at in [0, 1, whole.calls / 2, whole.calls - 1] {
        let mut first = Keeper { at, ..Keeper::default() };
        solve(&mut first);
        first.kept.rewind();
        let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
        assert_eq!(solve(&mut second), expected, "checkpoint {at} of {}", whole.calls);
        assert_eq!(second.calls, whole.calls - at);
    }
}
