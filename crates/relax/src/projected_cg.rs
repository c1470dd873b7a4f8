use gfmd_vector::{Serialise, Share, add, for_each};

use crate::quadratic::{
    Iterate, LEAST_DESCENT, Minimum, OptimalitySums, Quadratic, Target, rescale, step_length, sum_over_positive, turn,
};
use crate::{Ending, RelaxError, Visit, Watch, Why};

/// Projected conjugate gradients without restarts when the set of positive variables changes (Vollebregt 2014,
/// Bugnicourt et al. 2018).
///
/// The free set contains `{x > 0}` and the variables at zero with `g < 0`. On this set, the direction is the
/// Polak–Ribière combination of the last direction and the gradient. With a prescribed mean, the mean of the gradient
/// is removed. The step length is exact, and the result is projected to `x ≥ 0`. Variables that enter or leave disturb
/// the conjugacy only in their neighbourhood, so the directions remain useful; otherwise Polak–Ribière with β ≥ 0
/// becomes steepest descent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProjectedCg;

impl ProjectedCg {
    /// Minimises from the start `x`, in place; `watch` sees every iterate.
    ///
    /// # Errors
    /// Returns an error if the start or the target is invalid. An unsuccessful search is an [`Ending`], not an error.
    pub fn minimise(
        &self,
        problem: &mut dyn Quadratic,
        x: &mut [f64],
        target: &Target,
        watch: &mut dyn Watch,
    ) -> Result<Minimum, RelaxError> {
        target.check(x, problem)?;
        let n = x.len();
        let constrained = target.mean.is_some();
        let share = &problem.share();
        rescale(share, x, share.total_of(x), target.mean);
        let mut residual = vec![0.0; n];
        let mut residual_before = vec![0.0; n];
        let mut direction = vec![0.0; n];
        let mut product_before = 0.0;
        let mut iteration = 0;
        macro_rules! visit_all {
            ($visitor:expr) => {{
                let visitor: &mut dyn Visit = $visitor;
                visitor.rows(share, x);
                visitor.rows(share, &mut residual);
                visitor.rows(share, &mut direction);
                visitor.number(&mut product_before);
                visitor.count(&mut iteration);
                problem.visit(visitor);
            }};
        }
        if let Some(kept) = watch.recall() {
            visit_all!(kept);
        }
        loop {
            watch.checkpoint(&mut |visitor| visit_all!(visitor));
            std::mem::swap(&mut residual, &mut residual_before);
            problem.gradient(x, &mut residual);
            let (sum, positive) = sum_over_positive(share, x, &residual);
            let multiplier = if constrained { sum / positive as f64 } else { 0.0 };
            let sweep = restrict(share, &mut residual, x, multiplier);
            let now =
                Iterate { iteration, optimality: sweep.judged.optimality(target.gradient_scale), multiplier, positive };
            if let Some(ending) = target.judge(&now, watch, share) {
                return Ok(Minimum { reached: now, ending });
            }
            let mean = |sum: f64| if constrained && sweep.free > 0.0 { sum / sweep.free } else { 0.0 };

            if constrained {
                remove_mean(&mut residual, x, mean(sweep.residual));
            }
            let [sum, square, before, before_sum, direction_sum] =
                products(share, x, &residual, &residual_before, &direction);
            let residual_mean = mean(sum);
            let product = square - residual_mean * sum;
            let change = product - (before - residual_mean * before_sum);
            let beta = if product_before > 0.0 { (change / product_before).max(0.0) } else { 0.0 };
            product_before = product;

            let shift = residual_mean + beta * mean(direction_sum);
            let mut slope = turn(share, &mut direction, x, &residual, beta, shift, &is_free);
            if slope < LEAST_DESCENT * product {
                // The projected old direction leads uphill: restart with steepest descent.
                slope = turn(share, &mut direction, x, &residual, 0.0, residual_mean, &is_free);
            }
            let Some(step) = step_length(slope, problem.curvature(&direction)) else {
                return Ok(Minimum { reached: now, ending: Ending::GaveUp(Why::Direction) });
            };
            let sum = advance(share, x, &direction, step);
            rescale(share, x, sum, target.mean);
            iteration += 1;
        }
    }
}

/// Returns true if a variable is free; `residual` is zero for the others.
fn is_free(x: f64, residual: f64) -> bool {
    x > 0.0 || residual < 0.0
}

/// Sums over one iterate.
struct Sweep {
    judged: OptimalitySums,
    /// Σ r over the free set.
    residual: f64,
    /// Number of free variables.
    free: f64,
}

impl Serialise for Sweep {
    const WORDS: usize = OptimalitySums::WORDS + 2;

    fn put(&self, words: &mut [u64]) {
        self.judged.put(&mut words[..OptimalitySums::WORDS]);
        [self.residual, self.free].put(&mut words[OptimalitySums::WORDS..]);
    }

    fn get(words: &[u64]) -> Self {
        let [residual, free] = Serialise::get(&words[OptimalitySums::WORDS..]);
        Self { judged: OptimalitySums::get(&words[..OptimalitySums::WORDS]), residual, free }
    }
}

/// Sets g ← g − λ on the free set and zero elsewhere, and sums over the iterate.
fn restrict(share: &Share, gradient: &mut [f64], x: &[f64], multiplier: f64) -> Sweep {
    share.pass(
        [gradient],
        &|start, [g]| {
            let mut sums = Sweep { judged: OptimalitySums::EMPTY, residual: 0.0, free: 0.0 };
            for (g, x) in g.iter_mut().zip(&x[start..]) {
                let value = *g - multiplier;
                sums.judged.see(*x, value);
                let free = is_free(*x, value);
                *g = if free { value } else { 0.0 };
                sums.residual += *g;
                sums.free += f64::from(free);
            }
            sums
        },
        &|a, b| Sweep {
            judged: OptimalitySums::merge(a.judged, b.judged),
            residual: a.residual + b.residual,
            free: a.free + b.free,
        },
    )
}

/// Subtracts the mean from r where x > 0. The few entering variables keep their residual, and thus its sign.
fn remove_mean(residual: &mut [f64], x: &[f64], mean: f64) {
    for_each([residual], &|start, [r]| {
        for (r, x) in r.iter_mut().zip(&x[start..]) {
            if *x > 0.0 {
                *r -= mean;
            }
        }
    });
}

/// Returns Σ r, Σ r², Σ r r_before, Σ r_before, Σ d over the free set.
fn products(share: &Share, x: &[f64], residual: &[f64], before: &[f64], direction: &[f64]) -> [f64; 5] {
    share.reduce(
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

/// Sets x ← max(0, x − step d) and returns Σ x.
fn advance(share: &Share, x: &mut [f64], direction: &[f64], step: f64) -> f64 {
    share.pass(
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
