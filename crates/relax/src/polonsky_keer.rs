use gfmd_vector::pass;

use crate::quadratic::{
    Iterate, MinimiseError, Optimality, Quadratic, Target, Verdict, Watch, add_linear, rescale, step_length, total,
};

/// The constrained conjugate gradients of Polonsky and Keer (1999), theory.md, section 7: conjugate directions on the
/// variables that are positive, restarted whenever a variable at zero has to leave it.
///
/// With a prescribed mean the directions are kept free of a mean, so that a step keeps it too and the exact step length
/// needs only the [`curvature`](Quadratic::curvature) of the direction, not the image of it.
///
/// It converges on contact problems, but there is no proof, and on small dense ones it may cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PolonskyKeer;

/// The positive variables count as at rest when their rms gradient is this part of the lowest gradient outside.
const AT_REST: f64 = 1e-3;

/// Part of the steepest descent that a direction must keep to be used. Exact conjugacy would keep all of it.
const LEAST_DESCENT: f64 = 0.1;

impl PolonskyKeer {
    /// Minimises from `x` on, in place; `watch` sees every iterate. The last image of the iteration, the gradient, is
    /// not kept: judge the result afresh.
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
        rescale(x, total(x), target.mean);
        let mut gradient = vec![0.0; n];
        let mut direction = vec![0.0; n];
        let mut residual_before = 1.0;
        let mut conjugate = false;
        let mut iteration = 0;
        loop {
            problem.apply(x, &mut gradient);
            let (sum, positive) = add_linear(problem.linear(), x, &mut gradient);
            let multiplier = if target.mean.is_some() { sum / positive as f64 } else { 0.0 };
            let sweep = shift(&mut gradient, x, &direction, multiplier);
            let optimality = sweep.optimality(target.gradient_scale);
            let now = Iterate { iteration, optimality, multiplier, positive };
            if let Verdict::Converged = target.judge(now, watch)? {
                return Ok(now);
            }

            // Where the positive variables are at rest among themselves, those that want to enter have to move them.
            let at_rest = sweep.squares <= positive as f64 * (AT_REST * sweep.lowest).powi(2);
            let ratio = if conjugate && !at_rest { sweep.squares / residual_before } else { 0.0 };
            let mean = match target.mean {
                None => 0.0,
                Some(_) if at_rest => sweep.entering / (positive as f64 + sweep.entrants),
                Some(_) => ratio * sweep.direction / positive as f64,
            };
            residual_before = sweep.squares;
            let free = |x: f64, g: f64| x > 0.0 || (at_rest && g < 0.0);
            let mut slope = turn(&mut direction, x, &gradient, ratio, mean, &free);
            if slope < LEAST_DESCENT * sweep.squares {
                // What is left of the old direction, on fewer variables, leads uphill: start over.
                slope = turn(&mut direction, x, &gradient, 0.0, 0.0, &free);
            }
            let step = step_length(slope, problem.curvature(&direction), now)?;
            let (entered, sum) = advance(x, &direction, &gradient, step);
            conjugate = entered == 0 && !at_rest;
            rescale(x, sum, target.mean);
            iteration += 1;
        }
    }
}

/// Sums over one iterate.
struct Sweep {
    x: f64,
    x_gradient: f64,
    /// Σ g² over x > 0.
    squares: f64,
    /// Σ d over x > 0.
    direction: f64,
    lowest: f64,
    /// Σ g over the entrants: x = 0 and g < 0.
    entering: f64,
    entrants: f64,
}

impl Sweep {
    const EMPTY: Self = Self {
        x: 0.0,
        x_gradient: 0.0,
        squares: 0.0,
        direction: 0.0,
        lowest: f64::INFINITY,
        entering: 0.0,
        entrants: 0.0,
    };

    fn optimality(&self, scale: f64) -> Optimality {
        let complementarity = if self.x > 0.0 { self.x_gradient / (self.x * scale) } else { 0.0 };
        Optimality { complementarity, violation: (-self.lowest).max(0.0) / scale }
    }
}

/// g ← g − λ.
fn shift(gradient: &mut [f64], x: &[f64], direction: &[f64], multiplier: f64) -> Sweep {
    pass(
        [gradient],
        &|start, [g]| {
            let mut sums = Sweep::EMPTY;
            for ((g, x), d) in g.iter_mut().zip(&x[start..]).zip(&direction[start..]) {
                *g -= multiplier;
                sums.lowest = sums.lowest.min(*g);
                if *x > 0.0 {
                    sums.x += x;
                    sums.x_gradient += x * *g;
                    sums.squares += *g * *g;
                    sums.direction += d;
                } else if *g < 0.0 {
                    sums.entering += *g;
                    sums.entrants += 1.0;
                }
            }
            sums
        },
        &|a, b| Sweep {
            x: a.x + b.x,
            x_gradient: a.x_gradient + b.x_gradient,
            squares: a.squares + b.squares,
            direction: a.direction + b.direction,
            lowest: a.lowest.min(b.lowest),
            entering: a.entering + b.entering,
            entrants: a.entrants + b.entrants,
        },
    )
}

/// d ← g + ratio d − mean on the free variables, zero elsewhere; returns ⟨g, d⟩.
fn turn(
    direction: &mut [f64],
    x: &[f64],
    gradient: &[f64],
    ratio: f64,
    mean: f64,
    free: &(impl Fn(f64, f64) -> bool + Sync),
) -> f64 {
    pass(
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

/// x ← max(0, x − step d) where x > 0; variables at zero with a negative gradient enter with −step g. Returns how many
/// entered, and Σ x.
fn advance(x: &mut [f64], direction: &[f64], gradient: &[f64], step: f64) -> (usize, f64) {
    pass(
        [x],
        &|start, [x]| {
            let (mut entered, mut sum) = (0, 0.0);
            for ((x, d), g) in x.iter_mut().zip(&direction[start..]).zip(&gradient[start..]) {
                *x = (*x - step * d).max(0.0);
                if *x == 0.0 && *g < 0.0 {
                    *x = -step * g;
                    entered += 1;
                }
                sum += *x;
            }
            (entered, sum)
        },
        &|a, b| (a.0 + b.0, a.1 + b.1),
    )
}
