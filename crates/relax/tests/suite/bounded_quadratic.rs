//! Tests of the conjugate-gradient methods on small dense problems with a known minimum. The problem is constructed
//! from the minimum, or solved by trying every set of positive variables.

use std::ops::ControlFlow;

use gfmd_relax::{
    Budget, Divergence, Ending, Iterate, Minimum, PolonskyKeer, Preconditioned, PreconditionedCg, Progress,
    ProjectedCg, Quadratic, RelaxError, Target, Why,
};
use gfmd_vector::Split;
use proptest::prelude::*;

use crate::stretches;

#[derive(Clone, Copy, Debug)]
enum Method {
    PolonskyKeer,
    ProjectedCg,
    Preconditioned(Preconditioner),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Preconditioner {
    /// Inverse of A on the free variables.
    Inverse,
    /// Multiple of the identity.
    Scale(f64),
    /// Preconditioner that keeps variables at zero.
    Closed,
    /// Preconditioner with directions that lead uphill.
    Uphill,
}

/// All methods except [`Method::PolonskyKeer`], which has no safeguard and cycles in one of 10⁴ random problems below.
const METHODS: [Method; 7] = [
    Method::ProjectedCg,
    Method::Preconditioned(Preconditioner::Inverse),
    Method::Preconditioned(Preconditioner::Scale(1.0)),
    Method::Preconditioned(Preconditioner::Scale(1e-3)),
    Method::Preconditioned(Preconditioner::Scale(1e3)),
    Method::Preconditioned(Preconditioner::Closed),
    Method::Preconditioned(Preconditioner::Uphill),
];

#[derive(Clone, Debug)]
struct Dense {
    a: Vec<Vec<f64>>,
    b: Vec<f64>,
    preconditioner: Preconditioner,
    image: Vec<f32>,
}

impl Quadratic for Dense {
    fn variables(&self) -> usize {
        self.b.len()
    }

    fn gradient(&mut self, x: &[f64], out: &mut [f64]) {
        for (out, (row, b)) in out.iter_mut().zip(self.a.iter().zip(&self.b)) {
            *out = dot(row, x) + b;
        }
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        self.a.iter().zip(direction).map(|(row, d)| d * dot(row, direction)).sum()
    }
}

impl Preconditioned for Dense {
    fn length(&self) -> usize {
        self.b.len()
    }

    /// Returns half of the number of variables if it is even.
    fn stretch(&self) -> usize {
        let n = self.b.len();
        if n.is_multiple_of(2) { n / 2 } else { n }
    }

    fn unit(&self) -> f64 {
        2.0
    }

    fn gradient<O: Split, R: Send>(
        &mut self,
        x: &[f64],
        output: O,
        sink: impl Fn(&[f64], O) -> R + Sync,
        sums: &mut [R],
    ) {
        stretches::hand_on(self.stretch(), &Dense::gradient(self, x), output, sink, sums);
    }

    fn image<I: Split>(&mut self, input: I, source: impl Fn(I, &mut [f32]) + Sync) {
        let vector = stretches::made(self.stretch(), self.b.len(), input, source);
        self.image = self.a.iter().map(|row| (dot(row, &vector) / self.unit()) as f32).collect();
    }

    fn collect<O: Split, R: Send>(&mut self, output: O, sink: impl Fn(&[f32], O) -> R + Sync, sums: &mut [R]) {
        stretches::hand_on(self.stretch(), &self.image, output, sink, sums);
    }

    fn curvature(&mut self, direction: &[f32]) -> f64 {
        let direction: Vec<f64> = direction.iter().map(|d| f64::from(*d)).collect();
        Quadratic::curvature(self, &direction) / self.unit()
    }

    fn precondition(&mut self, x: &[f64], gradient: &[f32], level: f32, out: &mut [f32]) {
        let closed = self.preconditioner == Preconditioner::Closed;
        let free: Vec<usize> = (0..x.len()).filter(|&i| x[i] > 0.0 || (!closed && gradient[i] < level)).collect();
        let residual: Vec<f64> = free.iter().map(|&i| f64::from(gradient[i] - level) * self.unit()).collect();
        let step = match self.preconditioner {
            Preconditioner::Inverse => {
                solve(free.iter().map(|&i| free.iter().map(|&j| self.a[i][j]).collect()).collect(), residual)
            }
            Preconditioner::Scale(scale) => residual.iter().map(|r| scale * r).collect(),
            Preconditioner::Closed => residual,
            Preconditioner::Uphill => residual.iter().map(|r| -r).collect(),
        };
        out.fill(0.0);
        for (i, step) in free.into_iter().zip(step) {
            out[i] = step as f32;
        }
    }
}

impl Dense {
    fn minimise(&self, method: Method, start: &[f64], target: &Target) -> Result<(Vec<f64>, Minimum), RelaxError> {
        let mut x = start.to_vec();
        let mut problem = self.clone();
        let reached = match method {
            Method::PolonskyKeer => PolonskyKeer.minimise(&mut problem, &mut x, target, &mut ())?,
            Method::ProjectedCg => ProjectedCg.minimise(&mut problem, &mut x, target, &mut ())?,
            Method::Preconditioned(preconditioner) => {
                problem.preconditioner = preconditioner;
                PreconditionedCg.minimise(&mut problem, &mut x, target, &mut ())?
            }
        };
        Ok((x, reached))
    }

    /// Returns the minimum found by `method`. Panics if the search fails.
    fn minimum(&self, method: Method, start: &[f64], target: &Target) -> (Vec<f64>, Iterate) {
        match self.minimise(method, start, target) {
            Ok((x, Minimum { reached, ending: Ending::Converged })) => (x, reached),
            other => panic!("{method:?}: {other:?}"),
        }
    }

    fn gradient(&self, x: &[f64]) -> Vec<f64> {
        self.a.iter().zip(&self.b).map(|(row, b)| dot(row, x) + b).collect()
    }

    fn value(&self, x: &[f64]) -> f64 {
        self.gradient(x).iter().zip(&self.b).zip(x).map(|((g, b), x)| 0.5 * (g + b) * x).sum()
    }

    /// Finds the minimum by trying every set of positive variables.
    fn exact(&self, mean: Option<f64>) -> Vec<f64> {
        let n = self.b.len();
        let candidates = (0..1_u32 << n).filter_map(|set| {
            let free: Vec<usize> = (0..n).filter(|i| set >> i & 1 == 1).collect();
            let mut matrix: Vec<Vec<f64>> =
                free.iter().map(|&i| free.iter().map(|&j| self.a[i][j]).collect()).collect();
            let mut right: Vec<f64> = free.iter().map(|&i| -self.b[i]).collect();
            if let Some(mean) = mean {
                matrix.iter_mut().for_each(|row| row.push(-1.0));
                matrix.push(vec![1.0; free.len()]);
                matrix[free.len()].push(0.0);
                right.push(mean * n as f64);
            }
            if mean.is_some() && free.is_empty() {
                return None;
            }
            let solution = solve(matrix, right);
            let mut x = vec![0.0; n];
            free.iter().zip(&solution).for_each(|(&i, value)| x[i] = *value);
            let multiplier = if mean.is_some() { solution[free.len()] } else { 0.0 };
            let optimal = self.gradient(&x).iter().zip(&x).all(|(g, x)| *x >= -1e-12 && *g >= multiplier - 1e-12);
            optimal.then_some(x)
        });
        candidates.min_by(|a, b| self.value(a).total_cmp(&self.value(b))).expect("some set is optimal")
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Solves a x = b by Gaussian elimination with pivoting.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).expect("not empty");
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            let row = a[k].clone();
            a[i].iter_mut().zip(row).for_each(|(a, above)| *a -= factor * above);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let rest: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - rest) / a[k][k];
    }
    b
}

/// Returns the matrix BᵀB/n + shift.
fn matrix(entries: &[f64], n: usize, shift: f64) -> Vec<Vec<f64>> {
    let column = |i: usize| entries.iter().skip(i).step_by(n).copied();
    let product = |i: usize, j: usize| column(i).zip(column(j)).map(|(a, b)| a * b).sum::<f64>() / n as f64;
    (0..n).map(|i| (0..n).map(|j| product(i, j) + if i == j { shift } else { 0.0 }).collect()).collect()
}

fn target(mean: Option<f64>) -> Target {
    Target { mean, gradient_scale: 1.0, budget: Budget { tolerance: 1e-12, max_iterations: 20_000 } }
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Asserts a bound on the error of x at the tolerance: the two residuals bound ⟨x − x*, A (x − x*)⟩ = ⟨x − x*, g − g*⟩,
/// and A ≥ 0.1 in these tests. The solution thus has half the digits of the tolerance.
fn error(x: &[f64], exact: &[f64]) -> f64 {
    (target(None).budget.tolerance * (x.iter().sum::<f64>() + exact.iter().sum::<f64>()) / 0.1).sqrt()
}

/// Generates a variable and its gradient at the minimum; at least one of them is zero.
fn pair() -> impl Strategy<Value = (f64, f64)> {
    prop_oneof![3 => (0.1..3.0).prop_map(|x| (x, 0.0)), 2 => (0.1..3.0).prop_map(|g| (0.0, g)), 1 => Just((0.0, 0.0))]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn every_method_finds_the_best_of_all_sets(
        n in 1_usize..6,
        entries in prop::collection::vec(-1.0..1.0, 36),
        b in prop::collection::vec(-1.0..1.0, 6),
        start in prop::collection::vec(0.0..1.0, 6),
        mean in prop::option::of(0.01..2.0),
    ) {
        let dense = Dense {
            a: matrix(&entries[..n * n], n, 0.1),
            b: b[..n].to_vec(),
            preconditioner: Preconditioner::Scale(1.0),
            image: Vec::new(),
        };
        let exact = dense.exact(mean);
        for method in METHODS {
            let (x, _) = dense.minimum(method, &start[..n], &target(mean));
            prop_assert!(difference(&x, &exact) <= error(&x, &exact), "{method:?}: {x:?}, exact {exact:?}");
        }
    }

    #[test]
    fn a_minimum_with_idle_bounds_is_found(
        pairs in prop::collection::vec(pair(), 2..25),
        entries in prop::collection::vec(-1.0..1.0, 625),
        start in prop::collection::vec(prop_oneof![Just(0.0), 0.0..1.0], 25),
        multiplier in -1.0..1.0,
    ) {
        let n = pairs.len();
        prop_assume!(pairs.iter().any(|pair| pair.0 > 0.0) && start[..n].iter().any(|x| *x > 0.0));
        let (exact, slack): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        let a = matrix(&entries[..n * n], n, 0.1);
        for (mean, multiplier) in [(None, 0.0), (Some(exact.iter().sum::<f64>() / n as f64), multiplier)] {
            let b = a.iter().zip(&slack).map(|(row, slack)| slack + multiplier - dot(row, &exact)).collect();
            let dense = Dense { a: a.clone(), b, preconditioner: Preconditioner::Scale(1.0), image: Vec::new() };
            for method in METHODS {
                let (x, reached) = dense.minimum(method, &start[..n], &target(mean));
                let error = error(&x, &exact);
                prop_assert!(difference(&x, &exact) <= error, "{method:?}: {x:?}, exact {exact:?}");
                let stiffest = a.iter().map(|row| dot(row, row).sqrt()).fold(0.0, f64::max);
                prop_assert!((reached.multiplier - multiplier).abs() <= 1e-9 + stiffest * error, "{method:?}");
                prop_assert!(x.iter().all(|x| *x >= 0.0));
            }
        }
    }

    #[test]
    fn a_matrix_of_low_rank_is_enough_where_the_mean_is_given(
        n in 3_usize..12,
        entries in prop::collection::vec(-1.0..1.0, 144),
        b in prop::collection::vec(-1.0..1.0, 12),
        mean in 0.1..2.0,
    ) {
        let mut half = entries[..n * n].to_vec();
        half[n * n / 2..].fill(0.0);
        let dense = Dense {
            a: matrix(&half, n, 0.0),
            b: b[..n].to_vec(),
            preconditioner: Preconditioner::Scale(1.0),
            image: Vec::new(),
        };
        let target = Target { budget: Budget { tolerance: 1e-7, ..Budget::default() }, ..target(Some(mean)) };
        let methods = [1.0, 1e-3, 1e3].map(|scale| Method::Preconditioned(Preconditioner::Scale(scale)));
        for method in methods {
            let (x, reached) = dense.minimum(method, &vec![1.0; n], &target);
            let gradient = dense.gradient(&x);
            prop_assert!(gradient.iter().all(|g| *g >= reached.multiplier - 1e-6));
            let work: f64 = gradient.iter().zip(&x).map(|(g, x)| (g - reached.multiplier) * x).sum();
            prop_assert!(work.abs() <= 1e-6 * x.iter().sum::<f64>());
            prop_assert!((x.iter().sum::<f64>() / n as f64 - mean).abs() < 1e-12 * mean);
        }
    }
}

/// Returns a ring of springs, also connected to the ground, with loads of both signs.
fn ring(n: usize) -> Dense {
    let a = (0..n)
        .map(|i| {
            let spring = |j: usize| if j == (i + 1) % n || i == (j + 1) % n { -1.0 } else { 0.0 };
            (0..n).map(|j| if i == j { 2.01 } else { spring(j) }).collect()
        })
        .collect();
    let b = (0..n).map(|i| (7.3 * i as f64).sin()).collect();
    Dense { a, b, preconditioner: Preconditioner::Inverse, image: Vec::new() }
}

#[test]
fn newton_steps_need_few_iterations() {
    let dense = ring(200);
    let run = |method| dense.minimum(method, &[1.0; 200], &target(None));
    let (x, newton) = run(Method::Preconditioned(Preconditioner::Inverse));
    let (same, without) = run(Method::PolonskyKeer);
    assert!(newton.iteration <= 10, "{newton:?}");
    assert!(without.iteration > 3 * newton.iteration, "{without:?}");
    assert!(newton.positive == without.positive && difference(&x, &same) < 1e-9);
}

#[test]
fn a_preconditioner_of_the_wrong_size_costs_little() {
    let dense = ring(200);
    let iterations = |scale| {
        let method = Method::Preconditioned(Preconditioner::Scale(scale));
        dense.minimum(method, &[1.0; 200], &target(None)).1.iteration
    };
    let right = iterations(1.0);
    for scale in [1e-2, 1e2] {
        assert!(iterations(scale) < 3 * right + 50, "{scale}: {} to {right}", iterations(scale));
    }
}

#[test]
fn what_cannot_be_started_is_refused() {
    let dense = ring(4);
    let refused =
        |start: &[f64], target: &Target| METHODS.iter().all(|method| dense.minimise(*method, start, target).is_err());
    let good = target(Some(1.0));
    assert!(refused(&[1.0; 3], &good));
    assert!(refused(&[1.0, -1.0, 1.0, 1.0], &good));
    assert!(refused(&[1.0, f64::NAN, 1.0, 1.0], &good));
    assert!(refused(&[0.0; 4], &good));
    for mean in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(refused(&[1.0; 4], &target(Some(mean))));
    }
    for gradient_scale in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(refused(&[1.0; 4], &Target { gradient_scale, ..good }));
    }
}

#[test]
fn what_ends_early_says_why_and_where() {
    let dense = ring(50);
    for method in METHODS {
        let target = Target { budget: Budget { tolerance: 1e-12, max_iterations: 2 }, ..target(None) };
        let (_, minimum) = dense.minimise(method, &[1.0; 50], &target).unwrap();
        assert_eq!((minimum.ending, minimum.reached.iteration), (Ending::GaveUp(Why::Iterations), 2));
    }
    let mut x = vec![1.0; 50];
    let mut stop = |now: &Progress| if now.iteration == 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let minimum = PreconditionedCg.minimise(&mut dense.clone(), &mut x, &target(None), &mut stop).unwrap();
    assert_eq!((minimum.ending, minimum.reached.iteration), (Ending::Interrupted, 1));
}

#[test]
fn what_has_no_minimum_breaks_down() {
    // The second variable has a load but no stiffness.
    let dense = Dense {
        a: vec![vec![1.0, 0.0], vec![0.0, 0.0]],
        b: vec![1.0, -1.0],
        preconditioner: Preconditioner::Scale(1.0),
        image: Vec::new(),
    };
    let target = Target { budget: Budget { tolerance: 1e-12, max_iterations: 200 }, ..target(None) };
    for method in METHODS {
        let (_, minimum) = dense.minimise(method, &[1.0; 2], &target).unwrap();
        assert!(matches!(minimum.ending, Ending::GaveUp(_)), "{minimum:?}");
    }
    let mut broken = ring(8);
    broken.b[3] = f64::NAN;
    for method in METHODS {
        let (_, minimum) = broken.minimise(method, &[1.0; 8], &target).unwrap();
        let not_finite = Ending::GaveUp(Why::Diverged(Divergence::NotFinite));
        assert_eq!(minimum.ending, not_finite, "{method:?}");
    }
}
