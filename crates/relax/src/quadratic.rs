use std::ops::ControlFlow;

use gfmd_vector::{for_each, pass, reduce};

use crate::worst;

/// A convex quadratic function of non-negative variables, `½⟨x, A x⟩ + ⟨b, x⟩` with `x ≥ 0`: what the constrained
/// conjugate-gradient methods minimise. A is symmetric and positive (semi-)definite, and only its action is needed.
pub trait Quadratic {
    /// b, one value for each variable.
    fn linear(&self) -> &[f64];
    /// `out ← A x`.
    fn apply(&mut self, x: &[f64], out: &mut [f64]);
    /// `⟨d, A d⟩`, the sum over all variables. Often cheaper than [`apply`](Self::apply).
    fn curvature(&mut self, direction: &[f64]) -> f64;
    /// `out ← M (gradient − multiplier)`, nearly the step to where the gradient of the free variables is the multiplier;
    /// zero for the others. Free are those with x > 0, and those at zero that are to leave it; their gradient is below
    /// the multiplier. M depends on which are free. It is symmetric, positive, and near the inverse of A on the free
    /// variables, rather above it than below.
    fn precondition(&mut self, x: &[f64], gradient: &[f64], multiplier: f64, out: &mut [f64]);
}

/// What is asked of the minimiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Mean of x over all variables, when it is prescribed. The gradient is then determined up to a constant, the
    /// multiplier of this constraint.
    pub mean: Option<f64>,
    /// The size of gradient that counts as one: gradients are judged relative to it.
    pub gradient_scale: f64,
    /// Both parts of [`Optimality`] must fall to this.
    pub tolerance: f64,
    /// Iterations after which the search is given up.
    pub max_iterations: usize,
}

/// Distance from the minimum, by the conditions that define it: `x ≥ 0`, `g ≥ 0`, `x g = 0`, with `g = A x + b − λ` and
/// λ the multiplier of the prescribed mean (0 without one). `x ≥ 0` and the mean hold exactly at every iterate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Optimality {
    /// `Σ x g / (Σ x · gradient_scale)`.
    pub complementarity: f64,
    /// `max(0, −min g) / gradient_scale`.
    pub violation: f64,
}

impl Optimality {
    /// The larger of the two parts, in magnitude; NaN if either is.
    pub fn worst(&self) -> f64 {
        worst([self.complementarity.abs(), self.violation])
    }
}

/// Where a constrained minimisation stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Iterate {
    /// Iterations done.
    pub iteration: usize,
    /// Distance from the minimum.
    pub optimality: Optimality,
    /// The multiplier λ of the prescribed mean; 0 without one.
    pub multiplier: f64,
    /// Number of variables greater than zero.
    pub positive: usize,
}

/// How a constrained minimisation ended before it met its target. `x` stays with the caller as it was at the last
/// iterate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MinimiseError {
    /// The iteration limit was reached.
    #[error(
        "not converged after {} iterations: complementarity {:e}, violation {:e}, asked {asked:e}",
        reached.iteration, reached.optimality.complementarity, reached.optimality.violation
    )]
    NotConverged {
        /// The last iterate.
        reached: Iterate,
        /// The tolerance asked for.
        asked: f64,
    },
    /// A number stopped being finite, or the function has no minimum along a direction.
    #[error("broke down after {} iterations: {reason}", reached.iteration)]
    Breakdown {
        /// The last iterate.
        reached: Iterate,
        /// What happened.
        reason: &'static str,
    },
    /// The observer asked to stop.
    #[error("interrupted after {} iterations", reached.iteration)]
    Interrupted {
        /// The last iterate.
        reached: Iterate,
    },
    /// The start or the target cannot be used.
    #[error("unusable start: {reason}")]
    Start {
        /// What was found, and what is allowed.
        reason: &'static str,
    },
}

/// Sees every iterate; may ask to stop.
pub type Watch<'a> = &'a mut dyn FnMut(&Iterate) -> ControlFlow<()>;

/// What follows from the judgement of an iterate.
pub(crate) enum Verdict {
    Converged,
    Continue,
}

impl Target {
    pub(crate) fn check(&self, x: &[f64], b: &[f64]) -> Result<(), MinimiseError> {
        let refuse = |reason| Err(MinimiseError::Start { reason });
        if x.len() != b.len() {
            return refuse("x and b differ in length");
        }
        if !x.iter().all(|x| x.is_finite() && *x >= 0.0) {
            return refuse("every variable must start finite and not negative");
        }
        if self.mean.is_some_and(|mean| !mean.is_finite() || mean <= 0.0) {
            return refuse("the prescribed mean must be positive and finite");
        }
        if self.mean.is_some() && !x.iter().any(|x| *x > 0.0) {
            return refuse("with a prescribed mean, some variable must start positive");
        }
        if !(self.gradient_scale > 0.0 && self.gradient_scale.is_finite()) {
            return refuse("the gradient scale must be positive and finite");
        }
        Ok(())
    }

    pub(crate) fn judge(&self, now: Iterate, watch: Watch) -> Result<Verdict, MinimiseError> {
        let stop = watch(&now).is_break();
        let worst = now.optimality.worst();
        if worst <= self.tolerance {
            return Ok(Verdict::Converged);
        }
        if !worst.is_finite() {
            return Err(MinimiseError::Breakdown { reached: now, reason: "the gradient is not finite" });
        }
        if stop {
            return Err(MinimiseError::Interrupted { reached: now });
        }
        if now.iteration >= self.max_iterations {
            return Err(MinimiseError::NotConverged { reached: now, asked: self.tolerance });
        }
        Ok(Verdict::Continue)
    }
}

/// Scales x to the prescribed mean, if there is one.
pub(crate) fn rescale(x: &mut [f64], sum: f64, mean: Option<f64>) {
    let Some(mean) = mean else { return };
    let factor = mean * x.len() as f64 / sum;
    if factor != 1.0 {
        for_each([x], &|_, [x]| x.iter_mut().for_each(|x| *x *= factor));
    }
}

pub(crate) fn total(x: &[f64]) -> f64 {
    reduce(x.len(), &|range| x[range].iter().sum::<f64>(), &|a, b| a + b)
}

/// g ← g + b; returns Σ g and the number of entries over x > 0.
pub(crate) fn add_linear(b: &[f64], x: &[f64], gradient: &mut [f64]) -> (f64, usize) {
    pass(
        [gradient],
        &|start, [g]| {
            let (mut sum, mut count) = (0.0, 0);
            for ((g, b), x) in g.iter_mut().zip(&b[start..]).zip(&x[start..]) {
                *g += b;
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

/// The exact step ⟨g, d⟩/⟨d, A d⟩ along −d.
pub(crate) fn step_length(slope: f64, curvature: f64, reached: Iterate) -> Result<f64, MinimiseError> {
    let step = slope / curvature;
    if step.is_finite() && step > 0.0 {
        return Ok(step);
    }
    Err(MinimiseError::Breakdown { reached, reason: "no descent, or no curvature, along the search direction" })
}
