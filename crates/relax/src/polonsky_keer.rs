use gfmd_vector::{Serialise, Share};

use crate::quadratic::{
    Iterate, LEAST_DESCENT, Minimum, OptimalitySums, Quadratic, Target, rescale, step_length, sum_over_positive, turn,
};
use crate::{Ending, RelaxError, Visit, Watch, Why};

/// Constrained conjugate gradients of Polonsky and Keer (1999), theory.md, section 7: conjugate directions on the
/// positive variables, restarted whenever a variable leaves zero.
///
/// With a prescribed mean, the directions have zero mean, so that steps preserve the mean. The exact step length needs
/// only the [`curvature`](Quadratic::curvature) of the direction, not its image.
///
/// The method converges on contact problems, but without a proof; on small dense problems it may cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PolonskyKeer;

/// Ratio of rms gradient to lowest gradient below which the positive variables count as at rest.
const AT_REST: f64 = 1e-3;

impl PolonskyKeer {
    /// Minimises from the start `x`, in place; `watch` sees every iterate. The final gradient is not returned;
    /// recompute it to certify the result.
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
        let share = &problem.share();
        rescale(share, x, share.total_of(x), target.mean);
        let mut gradient = vec![0.0; n];
        let mut direction = vec![0.0; n];
        let mut residual_before = 1.0;
        let mut conjugate = false;
        let mut iteration = 0;
        macro_rules! visit_all {
            ($visitor:expr) => {{
                let visitor: &mut dyn Visit = $visitor;
                visitor.rows(share, x);
                visitor.rows(share, &mut direction);
                visitor.number(&mut residual_before);
                visitor.flag(&mut conjugate);
                visitor.count(&mut iteration);
                problem.visit(visitor);
            }};
        }
        if let Some(kept) = watch.recall() {
            visit_all!(kept);
        }
        loop {
            watch.checkpoint(&mut |visitor| visit_all!(visitor));
            problem.gradient(x, &mut gradient);
            let (sum, positive) = sum_over_positive(share, x, &gradient);
            let multiplier = if target.mean.is_some() { sum / positive as f64 } else { 0.0 };
            let sweep = shift(share, &mut gradient, x, &direction, multiplier);
            let optimality = sweep.judged.optimality(target.gradient_scale);
            let now = Iterate { iteration, optimality, multiplier, positive };
            if let Some(ending) = target.judge(&now, watch, share) {
                return Ok(Minimum { reached: now, ending });
            }

            // If the positive variables are at rest, the direction must include the entering variables.
            let at_rest = sweep.squares <= positive as f64 * (AT_REST * sweep.judged.lowest).powi(2);
            let ratio = if conjugate && !at_rest { sweep.squares / residual_before } else { 0.0 };
            let mean = match target.mean {
                None => 0.0,
                Some(_) if at_rest => sweep.entering / (positive as f64 + sweep.entrants),
                Some(_) => ratio * sweep.direction / positive as f64,
            };
            residual_before = sweep.squares;
            let free = |x: f64, g: f64| x > 0.0 || (at_rest && g < 0.0);
            let mut slope = turn(share, &mut direction, x, &gradient, ratio, mean, &free);
            if slope < LEAST_DESCENT * sweep.squares {
                // The old direction, restricted to fewer variables, leads uphill: restart.
                slope = turn(share, &mut direction, x, &gradient, 0.0, 0.0, &free);
            }
            let Some(step) = step_length(slope, problem.curvature(&direction)) else {
                return Ok(Minimum { reached: now, ending: Ending::GaveUp(Why::Direction) });
            };
            let (entered, sum) = advance(share, x, &direction, &gradient, step);
            conjugate = entered == 0 && !at_rest;
            rescale(share, x, sum, target.mean);
            iteration += 1;
        }
    }
}

/// Sums over one iterate.
struct Sweep {
    judged: OptimalitySums,
    /// Σ g² over x > 0.
    squares: f64,
    /// Σ d over x > 0.
    direction: f64,
    /// Σ g over the entering variables: x = 0 and g < 0.
    entering: f64,
    entrants: f64,
}

impl Serialise for Sweep {
    const WORDS: usize = OptimalitySums::WORDS + 4;

    fn put(&self, words: &mut [u64]) {
        self.judged.put(&mut words[..OptimalitySums::WORDS]);
        [self.squares, self.direction, self.entering, self.entrants].put(&mut words[OptimalitySums::WORDS..]);
    }

    fn get(words: &[u64]) -> Self {
        let [squares, direction, entering, entrants] = Serialise::get(&words[OptimalitySums::WORDS..]);
        Self { judged: OptimalitySums::get(&words[..OptimalitySums::WORDS]), squares, direction, entering, entrants }
    }
}

/// Subtracts λ from g, and sums over the iterate.
fn shift(share: &Share, gradient: &mut [f64], x: &[f64], direction: &[f64], multiplier: f64) -> Sweep {
    share.pass(
        [gradient],
        &|start, [g]| {
            let mut sums =
                Sweep { judged: OptimalitySums::EMPTY, squares: 0.0, direction: 0.0, entering: 0.0, entrants: 0.0 };
            for ((g, x), d) in g.iter_mut().zip(&x[start..]).zip(&direction[start..]) {
                *g -= multiplier;
                sums.judged.see(*x, *g);
                if *x > 0.0 {
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
            judged: OptimalitySums::merge(a.judged, b.judged),
            squares: a.squares + b.squares,
            direction: a.direction + b.direction,
            entering: a.entering + b.entering,
            entrants: a.entrants + b.entrants,
        },
    )
}

/// Sets x ← max(0, x − step d); variables then at zero with a negative gradient enter with −step g. Returns the number
/// of variables that entered, and Σ x.
fn advance(share: &Share, x: &mut [f64], direction: &[f64], gradient: &[f64], step: f64) -> (usize, f64) {
    share.pass(
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
