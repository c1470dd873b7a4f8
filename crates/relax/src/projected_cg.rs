use gfmd_vector::{add, for_each, pass};

use crate::quadratic::{
    Iterate, MinimiseError, Optimality, Quadratic, Target, Verdict, Watch, add_linear, rescale, step_length, total,
};

/// Projected conjugate gradients that are never restarted when the set of positive variables changes (Vollebregt 2014,
/// Bugnicourt et al. 2018).
///
/// The free set is `{x > 0}` and the variables at zero that want to leave it (`g < 0`). On it the direction is the
/// Polak–Ribière combination of the gradient, without mean where one is prescribed, with the last direction, the step
/// is exact, and the result is projected back to `x ≥ 0`. Variables that enter or leave disturb the conjugacy of their
/// neighbourhood only, so the directions stay useful; Polak–Ribière with β ≥ 0 turns into steepest descent by itself
/// where they do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProjectedCg;

/// Part of the steepest descent that a direction must keep to be used. Exact conjugacy would keep all of it.
const LEAST_DESCENT: f64 = 0.1;

impl ProjectedCg {
    /// Minimises from `x` on, in place; `watch` sees every iterate.
    ///
    /// # Errors
    /// [`MinimiseError`]; `x` is then the last iterate.
    pub fn minimise(
        &self,
        problem: &mut dyn Quadratic,
        x: &mut [f64],
        target: &Target,
        watch: Watch,
    ) -> Result<Iterate, MinimiseError> {
        target.check(x, problem.linear())?;
        let n = x.len();
        let constrained = target.mean.is_some();
        rescale(x, total(x), target.mean);
        let mut residual = vec![0.0; n];
        let mut residual_before = vec![0.0; n];
        let mut direction = vec![0.0; n];
        let mut product_before = 0.0;
        let mut iteration = 0;
        loop {
            std::mem::swap(&mut residual, &mut residual_before);
            problem.apply(x, &mut residual);
            let (sum, positive) = add_linear(problem.linear(), x, &mut residual);
            let multiplier = if constrained { sum / positive as f64 } else { 0.0 };
            let judged = restrict(&mut residual, x, multiplier);
            let now = Iterate { iteration, optimality: judged.optimality(target.gradient_scale), multiplier, positive };
            if let Verdict::Converged = target.judge(now, watch)? {
                return Ok(now);
            }
            let mean = |sum: f64| if constrained && judged.free > 0.0 { sum / judged.free } else { 0.0 };

            if constrained {
                remove_mean(&mut residual, x, mean(judged.residual));
            }
            let [sum, square, before, before_sum, direction_sum] = products(x, &residual, &residual_before, &direction);
            let residual_mean = mean(sum);
            let product = square - residual_mean * sum;
            let change = product - (before - residual_mean * before_sum);
            let beta = if product_before > 0.0 { (change / product_before).max(0.0) } else { 0.0 };
            product_before = product;

            let shift = residual_mean + beta * mean(direction_sum);
            let mut slope = turn(&mut direction, x, &residual, beta, shift);
            if slope < LEAST_DESCENT * product {
                // What the projection left of the old direction leads uphill: start over from steepest descent.
                slope = turn(&mut direction, x, &residual, 0.0, residual_mean);
            }
            let step = step_length(slope, problem.curvature(&direction), now)?;
            let sum = advance(x, &direction, step);
            rescale(x, sum, target.mean);
            iteration += 1;
        }
    }
}

/// Whether a variable may move: `residual` is zero at the others.
fn is_free(x: f64, residual: f64) -> bool {
    x > 0.0 || residual < 0.0
}

/// Sums over one iterate.
struct Judged {
    x: f64,
    x_gradient: f64,
    lowest: f64,
    residual: f64,
    free: f64,
}

impl Judged {
    fn optimality(&self, scale: f64) -> Optimality {
        let complementarity = if self.x > 0.0 { self.x_gradient / (self.x * scale) } else { 0.0 };
        Optimality { complementarity, violation: (-self.lowest).max(0.0) / scale }
    }
}

/// g ← g − λ on the free set, zero elsewhere.
fn restrict(gradient: &mut [f64], x: &[f64], multiplier: f64) -> Judged {
    pass(
        [gradient],
        &|start, [g]| {
            let mut sums = Judged { x: 0.0, x_gradient: 0.0, lowest: f64::INFINITY, residual: 0.0, free: 0.0 };
            for (g, x) in g.iter_mut().zip(&x[start..]) {
                let value = *g - multiplier;
                sums.lowest = sums.lowest.min(value);
                sums.x += x;
                sums.x_gradient += x * value;
                let free = is_free(*x, value);
                *g = if free { value } else { 0.0 };
                sums.residual += *g;
                sums.free += f64::from(free);
            }
            sums
        },
        &|a, b| Judged {
            x: a.x + b.x,
            x_gradient: a.x_gradient + b.x_gradient,
            lowest: a.lowest.min(b.lowest),
            residual: a.residual + b.residual,
            free: a.free + b.free,
        },
    )
}

/// r ← r − mean where x > 0. The few variables that are about to enter keep theirs, and with it their sign.
fn remove_mean(residual: &mut [f64], x: &[f64], mean: f64) {
    for_each([residual], &|start, [r]| {
        for (r, x) in r.iter_mut().zip(&x[start..]) {
            if *x > 0.0 {
                *r -= mean;
            }
        }
    });
}

/// Over the free set: Σ r, Σ r², Σ r r_before, Σ r_before, Σ d.
fn products(x: &[f64], residual: &[f64], before: &[f64], direction: &[f64]) -> [f64; 5] {
    gfmd_vector::reduce(
        x.len(),
        &|range| {
            let mut sums = [0.0; 5];
            let parts = (&x[range.clone()], &residual[range.clone()], &before[range.clone()]);
            for (((x, r), b), d) in parts.0.iter().zip(parts.1).zip(parts.2).zip(&direction[range]) {
                if is_free(*x, *r) {
                    sums = add(sums, [*r, r * r, r * b, *b, *d]);
                }
            }
            sums
        },
        &add,
    )
}

/// d ← r + β d − shift on the free set, zero elsewhere; returns ⟨r, d⟩.
fn turn(direction: &mut [f64], x: &[f64], residual: &[f64], beta: f64, shift: f64) -> f64 {
    pass(
        [direction],
        &|start, [d]| {
            let mut slope = 0.0;
            for ((d, x), r) in d.iter_mut().zip(&x[start..]).zip(&residual[start..]) {
                *d = if is_free(*x, *r) { r + beta * *d - shift } else { 0.0 };
                slope += *d * r;
            }
            slope
        },
        &|a, b| a + b,
    )
}

/// x ← max(0, x − step d); returns Σ x.
fn advance(x: &mut [f64], direction: &[f64], step: f64) -> f64 {
    pass(
        [x],
        &|start, [x]| {
            let mut sum = 0.0;
            for (x, d) in x.iter_mut().zip(&direction[start..]) {
                *x = (*x - step * d).max(0.0);
                sum += *x;
            }
            sum
        },
        &|a, b| a + b,
    )
}
