use gfmd_vector::{Serialise, Share, for_each, reduce};

use crate::{Budget, Divergence, Ending, Progress, RelaxError, Upper, Visit, Watch, Why, worst};

/// Convex quadratic function of non-negative variables, `½⟨x, A x⟩ + ⟨b, x⟩` with `x ≥ 0`, for the constrained
/// conjugate-gradient methods. A is symmetric and positive (semi-)definite; only its action is needed.
pub trait Quadratic {
    /// Returns the number of variables of this process.
    fn variables(&self) -> usize;
    /// Writes `A x + b` into `out`.
    fn gradient(&mut self, x: &[f64], out: &mut [f64]);
    /// Returns `⟨d, A d⟩`, summed over all variables. Often cheaper than [`gradient`](Self::gradient).
    fn curvature(&mut self, direction: &[f64]) -> f64;
    /// Returns the partition of the variables among processes; by default this process has all. Vectors are local to
    /// this process, and every process makes the same calls.
    fn share(&self) -> Share {
        Share::whole(self.variables(), 1)
    }
    /// Visits the variables that the problem itself changes during a search, for example an effort counter.
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let _ = visitor;
    }
}

/// Constraint and accuracy of a minimisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Prescribed mean of x over all variables, if any. The gradient is then determined up to a constant, the
    /// multiplier of this constraint.
    pub mean: Option<f64>,
    /// Scale of gradients in the residuals.
    pub gradient_scale: f64,
    /// Budget; both parts of [`Optimality`] must be at most its tolerance.
    pub budget: Budget,
}

/// Distance from the minimum, given by the optimality conditions `x ≥ 0`, `g ≥ 0`, `x g = 0` (at an
/// [upper](crate::Preconditioned::upper) bound: `g ≤ 0`), with `g = A x + b − λ` and λ the multiplier of the prescribed
/// mean (0 without one). `x ≥ 0` and the mean are exact in every iterate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Optimality {
    /// `Σ x g / (Σ x · gradient_scale)`.
    pub complementarity: f64,
    /// `max(0, −min g) / gradient_scale`; at an upper bound `max g` in place of `−min g`.
    pub violation: f64,
}

impl Optimality {
    /// Returns the larger of the two parts in magnitude; NaN if either is NaN.
    pub fn worst(&self) -> f64 {
        worst([self.complementarity.abs(), self.violation])
    }
}

/// Status of a constrained minimisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Iterate {
    /// Number of iterations.
    pub iteration: u64,
    /// Distance from the minimum.
    pub optimality: Optimality,
    /// Multiplier λ of the prescribed mean; 0 without one.
    pub multiplier: f64,
    /// Number of variables above zero and below the upper bound.
    pub positive: usize,
}

/// Result of a constrained minimisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minimum {
    /// Status of the last iterate.
    pub reached: Iterate,
    /// Ending of the search.
    pub ending: Ending,
}

impl Target {
    /// Checks the start and the target of a problem without upper bounds.
    pub(crate) fn check(&self, x: &[f64], problem: &dyn Quadratic) -> Result<(), RelaxError> {
        self.check_between(x, &problem.share(), &Upper::All(f64::INFINITY))
    }

    /// Checks the start and the target of a distributed problem with upper bounds.
    pub(crate) fn check_between(&self, x: &[f64], share: &Share, upper: &Upper) -> Result<(), RelaxError> {
        let (own, variables) = (share.own(), share.own().len());
        RelaxError::check_length("variables", x.len(), variables)?;
        if let Upper::Each(bounds) = upper {
            RelaxError::check_length("upper bounds", bounds.len(), variables)?;
        }
        let ceiling = upper.ceiling();
        let inside = |i: usize| x[i].is_finite() && x[i] >= 0.0 && x[i] <= ceiling.at(i);
        let first = reduce(variables, &|mut range| range.find(|i| !inside(*i)), &Option::or);
        // All processes return the same error.
        let firsts = share.each(first.map_or((usize::MAX, 0.0), |index| (own.start + index, x[index])));
        if let Some((index, found)) = firsts.into_iter().find(|(index, _)| *index != usize::MAX) {
            return Err(RelaxError::Start { index, found });
        }
        let positive = |name, found: f64| {
            RelaxError::check_parameter(name, found, found > 0.0 && found.is_finite(), "positive and finite")
        };
        positive("the gradient scale", self.gradient_scale)?;
        let Some(mean) = self.mean else { return Ok(()) };
        positive("the prescribed mean", mean)?;
        RelaxError::check_parameter(
            "the prescribed mean",
            mean,
            mean < upper.mean_over(share),
            "less than the upper bound",
        )?;
        if !share.any(x.iter().any(|x| *x != 0.0)) { Err(RelaxError::AllZero) } else { Ok(()) }
    }

    /// Returns the ending if the search ends with this iterate. It also ends if the watcher of any process stops it.
    pub(crate) fn judge(&self, now: &Iterate, watch: &mut dyn Watch, share: &Share) -> Option<Ending> {
        let worst = now.optimality.worst();
        let stop = watch.see(&Progress { iteration: now.iteration, residual: worst }).is_break();
        let stop = share.any(stop);
        if worst <= self.budget.tolerance {
            Some(Ending::Converged)
        } else if !worst.is_finite() {
            Some(Ending::GaveUp(Why::Diverged(Divergence::NotFinite)))
        } else if stop {
            Some(Ending::Interrupted)
        } else {
            (now.iteration >= self.budget.max_iterations).then_some(Ending::GaveUp(Why::Iterations))
        }
    }
}

/// Scales x to the prescribed mean, if there is one.
pub(crate) fn rescale(share: &Share, x: &mut [f64], sum: f64, mean: Option<f64>) {
    let Some(mean) = mean else { return };
    let factor = mean * share.total() as f64 / sum;
    if factor != 1.0 {
        for_each([x], &|_, [x]| x.iter_mut().for_each(|x| *x *= factor));
    }
}

/// Returns Σ g over x > 0 and the number of these entries.
pub(crate) fn sum_over_positive(share: &Share, x: &[f64], gradient: &[f64]) -> (f64, usize) {
    share.reduce(
        &|range| {
            let (mut sum, mut count) = (0.0, 0);
            for (g, x) in gradient[range.clone()].iter().zip(&x[range]) {
                if *x > 0.0 {
                    sum += *g;
                    count += 1;
                }
            }
            (sum, count)
        },
        &|a, b| (a.0 + b.0, a.1 + b.1),
    )
}

/// Returns the exact step length ⟨g, d⟩/⟨d, A d⟩ along −d, if the function has a minimum in this direction.
pub(crate) fn step_length(slope: f64, curvature: f64) -> Option<f64> {
    let step = slope / curvature;
    (step.is_finite() && step > 0.0).then_some(step)
}

/// Smallest descent of an accepted direction, relative to steepest descent; 1 for exactly conjugate directions.
pub(crate) const LEAST_DESCENT: f64 = 0.1;

/// Sets d ← g + ratio d − mean on the free variables, zero elsewhere. Returns ⟨g, d⟩.
pub(crate) fn turn(
    share: &Share,
    direction: &mut [f64],
    x: &[f64],
    gradient: &[f64],
    ratio: f64,
    mean: f64,
    free: &(impl Fn(f64, f64) -> bool + Sync),
) -> f64 {
    share.pass(
        [direction],
        &|start, [d]| {
            let mut slope = 0.0;
            for ((d, x), g) in d.iter_mut().zip(&x[start..]).zip(&gradient[start..]) {
                *d = if free(*x, *g) { g + ratio * *d - mean } else { 0.0 };
                slope += *d * g;
            }
            slope
        },
        &|a, b| a + b,
    )
}

/// Sums over one iterate for its residuals, with gradients minus the multiplier.
#[derive(Clone, Copy)]
pub(crate) struct OptimalitySums {
    pub(crate) x: f64,
    pub(crate) x_gradient: f64,
    pub(crate) lowest: f64,
}

impl Serialise for OptimalitySums {
    const WORDS: usize = 3;

    fn put(&self, words: &mut [u64]) {
        [self.x, self.x_gradient, self.lowest].put(words);
    }

    fn get(words: &[u64]) -> Self {
        let [x, x_gradient, lowest] = Serialise::get(words);
        Self { x, x_gradient, lowest }
    }
}

impl OptimalitySums {
    pub(crate) const EMPTY: Self = Self { x: 0.0, x_gradient: 0.0, lowest: f64::INFINITY };

    pub(crate) fn see(&mut self, x: f64, gradient: f64) {
        self.lowest = self.lowest.min(gradient);
        self.x += x;
        self.x_gradient += x * gradient;
    }

    pub(crate) fn merge(a: Self, b: Self) -> Self {
        Self { x: a.x + b.x, x_gradient: a.x_gradient + b.x_gradient, lowest: a.lowest.min(b.lowest) }
    }

    pub(crate) fn optimality(&self, scale: f64) -> Optimality {
        let complementarity = if self.x > 0.0 { self.x_gradient / (self.x * scale) } else { 0.0 };
        Optimality { complementarity, violation: (-self.lowest).max(0.0) / scale }
    }
}
