use gfmd_vector::{add, for_each, pass, reduce};

use crate::quadratic::{Iterate, LEAST_DESCENT, Minimum, Optimality, Quadratic, Target, rescale, total};
use crate::{Ending, RelaxError, Visit, Watch, Why};

/// Projected conjugate gradients with a preconditioner M close to the inverse of A on the free variables
/// ([`Quadratic::precondition`]). An iteration takes one image and one preconditioning.
///
/// Since z = M g is nearly Newton's step, the step length is 1; M should not be smaller than the inverse of A, so that
/// this is not too short. x goes to `max(0, x − z − μ)`, with μ such that the prescribed mean is kept. With the old
/// gradient and the new one, which is needed anyway, the function is a known parabola along the segment from the old x
/// to the new x. If its minimum lies inside the segment, x steps back to it, which costs no further image. The function
/// thus decreases in every iteration, and no curvature has to be computed.
///
/// While no variable reaches zero, these are exact line searches, and directions are made conjugate to the last step.
/// If some variables reach zero, a step that lowers the function is kept whole, since stepping back would make them
/// positive again; the next length is between the present and the optimal one. If a step back is necessary, the next
/// length is shorter by its factor, since steps to one and the same end of a segment would make no progress.
///
/// Every 25th direction, and any direction that the projection turns uphill, is the gradient. Projected gradients with
/// a step that lowers the function converge for any steps in between (Bertsekas 1976).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PreconditionedCg;

/// Number of directions of which one is the gradient.
const PLAIN: u64 = 25;

/// A step that brings variables to zero is kept if at least this fraction of it was downhill. For one half the function
/// has not increased.
const DOWNHILL: f64 = 0.5;

/// After a step back to less than this fraction of the step, the gradient is computed anew: the rounding errors of the
/// whole step are too large for what is left of it.
const CANCELLED: f64 = 1e-4;

/// Largest factor by which the length changes from one step to the next.
const CHANGE: f64 = 10.0;

/// Largest number of times that a step is halved until it begins downhill.
const HALVINGS: usize = 30;

/// Relative accuracy of the mean in the search for μ; a factor then makes the mean exact.
const MEAN: f64 = 1e-2;

/// Relative accuracy of the mean with an upper bound, which a factor might exceed.
const EXACT: f64 = 1e-13;

impl PreconditionedCg {
    /// Minimises from the start `x`, in place; `watch` sees every iterate.
    ///
    /// # Errors
    /// An invalid start or target. A search without success is not an error but an [`Ending`].
    pub fn minimise(
        &self,
        problem: &mut dyn Quadratic,
        x: &mut [f64],
        target: &Target,
        watch: &mut dyn Watch,
    ) -> Result<Minimum, RelaxError> {
        target.check_between(x, problem)?;
        let (n, upper) = (x.len(), problem.upper());
        begin(x, target.mean, upper);
        let [mut gradient, mut other_gradient, mut step, mut last_step] = std::array::from_fn(|_| vec![0.0; n]);
        let mut multiplier = 0.0;
        let mut length: f64 = 1.0;
        let mut settled = false;
        let mut iteration = 0;
        problem.apply(x, &mut gradient);
        let mut sums = measure(problem.linear(), &mut gradient, x, &step, multiplier, upper);
        macro_rules! visit_all {
            ($visitor:expr) => {{
                let visitor: &mut dyn Visit = $visitor;
                for field in [&mut *x, &mut gradient, &mut other_gradient, &mut last_step] {
                    visitor.field(field);
                }
                visitor.number(&mut multiplier);
                visitor.number(&mut length);
                visitor.flag(&mut settled);
                visitor.count(&mut iteration);
                sums.visit(visitor);
                problem.visit(visitor);
            }};
        }
        if let Some(kept) = watch.recall() {
            visit_all!(kept);
        }
        loop {
            watch.checkpoint(&mut |visitor| visit_all!(visitor));
            let shift = if target.mean.is_some() { sums.shift() } else { 0.0 };
            multiplier += shift;
            let optimality = sums.optimality(shift, target.gradient_scale);
            let now = Iterate { iteration, optimality, multiplier, positive: sums.positive };
            if let Some(ending) = target.judge(&now, watch) {
                return Ok(Minimum { reached: now, ending });
            }

            let mut path = None;
            if iteration % PLAIN != PLAIN - 1 {
                problem.precondition(x, &gradient, multiplier, &mut step);
                if settled {
                    conjugate(&mut step, &last_step, &gradient, &other_gradient, multiplier);
                }
                path = downhill(x, &step, length, &gradient, multiplier, target.mean, upper);
            }
            let preconditioned = path.is_some();
            if path.is_none() {
                let squares = steepest(x, &gradient, multiplier, target.mean.is_some(), upper, &mut step);
                let length = squares / problem.curvature(&step);
                path = downhill(x, &step, length, &gradient, multiplier, target.mean, upper);
            }
            let Some(path) = path else {
                return Ok(Minimum { reached: now, ending: Ending::GaveUp(Why::NoDescent) });
            };

            advance(x, &mut step, &path);
            problem.apply(x, &mut other_gradient);
            sums = measure(problem.linear(), &mut other_gradient, x, &step, multiplier, upper);
            // Along the step the slope changes linearly.
            let rise = sums.slope - path.slope;
            let lowest = if rise > 0.0 { -path.slope / rise } else { f64::INFINITY };
            settled = sums.clipped == 0;
            if preconditioned {
                length = match lowest {
                    _ if settled => (path.length * lowest.min(CHANGE)).max(1.0),
                    ..DOWNHILL => path.length * lowest.max(1.0 / CHANGE),
                    _ => (path.length * lowest).min(1.0).sqrt(),
                };
            }
            if lowest < if settled { 1.0 } else { DOWNHILL } {
                let part = lowest.max(0.0);
                sums = step_back(x, &step, &mut gradient, &other_gradient, part, multiplier, upper);
                if part < CANCELLED {
                    problem.apply(x, &mut gradient);
                    sums = measure(problem.linear(), &mut gradient, x, &step, multiplier, upper);
                }
            } else {
                std::mem::swap(&mut gradient, &mut other_gradient);
            }
            std::mem::swap(&mut step, &mut last_step);
            iteration += 1;
        }
    }
}

/// Sums over one iterate; gradients are relative to the multiplier before it.
struct Sums {
    x: f64,
    x_gradient: f64,
    positive: usize,
    positive_gradient: f64,
    lowest: f64,
    /// The highest gradient at the upper bound.
    highest: f64,
    /// ⟨g, step⟩ at the end of the step.
    slope: f64,
    /// Number of variables that the step has brought to a bound.
    clipped: usize,
}

impl Sums {
    const EMPTY: Self = Self {
        x: 0.0,
        x_gradient: 0.0,
        positive: 0,
        positive_gradient: 0.0,
        lowest: f64::INFINITY,
        highest: f64::NEG_INFINITY,
        slope: 0.0,
        clipped: 0,
    };

    /// The change of the multiplier to the mean gradient of the variables between the bounds; if there are none, to the
    /// middle of the gradients at either bound.
    fn shift(&self) -> f64 {
        if self.positive > 0 {
            self.positive_gradient / self.positive as f64
        } else {
            match (self.lowest.is_finite(), self.highest.is_finite()) {
                (true, true) => 0.5 * (self.lowest + self.highest),
                (true, false) => self.lowest,
                (false, _) => self.highest,
            }
        }
    }

    fn optimality(&self, shift: f64, scale: f64) -> Optimality {
        let complementarity = if self.x > 0.0 { (self.x_gradient / self.x - shift) / scale } else { 0.0 };
        let violation = (shift - self.lowest).max(self.highest - shift).max(0.0) / scale;
        Optimality { complementarity, violation }
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self { x, x_gradient, positive, positive_gradient, lowest, highest, slope, clipped } = self;
        visitor.numbers(&mut [x, x_gradient, positive_gradient, lowest, highest, slope]);
        for number in [positive, clipped] {
            let mut count = *number as u64;
            visitor.count(&mut count);
            *number = count as usize;
        }
    }

    fn see(&mut self, x: f64, gradient: f64, step: f64, upper: f64) {
        self.slope += gradient * step;
        // A search that diverges may reach infinity, which is no bound.
        if x >= upper && x.is_finite() {
            self.highest = self.highest.max(gradient);
            self.clipped += usize::from(step > 0.0);
            return;
        }
        self.lowest = self.lowest.min(gradient);
        if x > 0.0 {
            self.x += x;
            self.x_gradient += x * gradient;
            self.positive += 1;
            self.positive_gradient += gradient;
        } else if step < 0.0 {
            self.clipped += 1;
        }
    }

    fn merge(a: Self, b: Self) -> Self {
        Self {
            x: a.x + b.x,
            x_gradient: a.x_gradient + b.x_gradient,
            positive: a.positive + b.positive,
            positive_gradient: a.positive_gradient + b.positive_gradient,
            lowest: a.lowest.min(b.lowest),
            highest: a.highest.max(b.highest),
            slope: a.slope + b.slope,
            clipped: a.clipped + b.clipped,
        }
    }
}

/// g ← g + b.
fn measure(b: &[f64], gradient: &mut [f64], x: &[f64], step: &[f64], level: f64, upper: f64) -> Sums {
    pass(
        [gradient],
        &|start, [g]| {
            let mut sums = Sums::EMPTY;
            for (((g, b), x), s) in g.iter_mut().zip(&b[start..]).zip(&x[start..]).zip(&step[start..]) {
                *g += b;
                sums.see(*x, *g - level, *s, upper);
            }
            sums
        },
        &Sums::merge,
    )
}

/// x ← x − (1 − part) s; the gradient is interpolated between those before and after the step.
fn step_back(
    x: &mut [f64],
    step: &[f64],
    gradient: &mut [f64],
    after: &[f64],
    part: f64,
    level: f64,
    upper: f64,
) -> Sums {
    pass(
        [x, gradient],
        &|start, [x, g]| {
            let mut sums = Sums::EMPTY;
            for (((x, g), s), after) in x.iter_mut().zip(g).zip(&step[start..]).zip(&after[start..]) {
                *x = (*x - (1.0 - part) * s).max(0.0).min(upper);
                *g += part * (after - *g);
                sums.see(*x, *g - level, *s, upper);
            }
            sums
        },
        &Sums::merge,
    )
}

/// z ← z − β s with β such that z is conjugate to s (Hestenes and Stiefel 1952), on the free variables, where z ≠ 0.
/// A s is proportional to the difference of the two gradients, and β does not depend on the factor.
fn conjugate(z: &mut [f64], s: &[f64], gradient: &[f64], other: &[f64], multiplier: f64) {
    let [z_image, s_image, z_gradient, s_gradient] = reduce(
        z.len(),
        &|range| {
            let mut sums = [0.0; 4];
            let gradients = gradient[range.clone()].iter().zip(&other[range.clone()]);
            for ((z, s), (g, other)) in z[range.clone()].iter().zip(&s[range]).zip(gradients) {
                let (image, g) = (other - g, g - multiplier);
                sums = add(sums, [z * image, s * image, z * g, if *z != 0.0 { s * g } else { 0.0 }]);
            }
            sums
        },
        &add,
    );
    let beta = z_image / s_image;
    if z_gradient - beta * s_gradient >= LEAST_DESCENT * z_gradient {
        for_each([z], &|start, [z]| {
            z.iter_mut().zip(&s[start..]).filter(|(z, _)| **z != 0.0).for_each(|(z, s)| *z -= beta * s)
        });
    }
}

/// z ← g − λ on the free variables, with zero mean if the mean is prescribed; zero elsewhere. Returns ⟨z, z⟩.
fn steepest(x: &[f64], gradient: &[f64], multiplier: f64, constrained: bool, upper: f64, z: &mut [f64]) -> f64 {
    let is_free = |x: f64, g: f64| if x >= upper && x.is_finite() { g > multiplier } else { x > 0.0 || g < multiplier };
    let [sum, count] = reduce(
        x.len(),
        &|range| {
            let free = x[range.clone()].iter().zip(&gradient[range]).filter(|(x, g)| is_free(**x, **g));
            free.fold([0.0; 2], |sums, (_, g)| add(sums, [g - multiplier, 1.0]))
        },
        &add,
    );
    let mean = if constrained { sum / count } else { 0.0 };
    pass(
        [z],
        &|start, [z]| {
            let mut squares = 0.0;
            for ((z, x), g) in z.iter_mut().zip(&x[start..]).zip(&gradient[start..]) {
                *z = if is_free(*x, *g) { g - multiplier - mean } else { 0.0 };
                squares += *z * *z;
            }
            squares
        },
        &|a, b| a + b,
    )
}

/// A point of the projected path: `factor · max(0, x − length z − μ)`, at most the upper bound, on the free variables, between
/// the bounds or with z ≠ 0; the others stay.
struct Path {
    upper: f64,
    length: f64,
    mu: f64,
    factor: f64,
    /// ⟨g, step⟩ at the beginning of the step.
    slope: f64,
}

impl Path {
    fn end(&self, x: f64, z: f64) -> f64 {
        // Without branches, which could not be predicted.
        let end = x - self.length * z - self.mu;
        let held = (x >= self.upper) & (z == 0.0);
        let end = if (end > 0.0) & ((x > 0.0) | (z != 0.0)) { end.min(self.upper) } else { 0.0 };
        if held { x } else { end }
    }
}

/// The point of the path at `length`, halved until the step to it begins downhill.
fn downhill(
    x: &[f64],
    z: &[f64],
    length: f64,
    gradient: &[f64],
    multiplier: f64,
    mean: Option<f64>,
    upper: f64,
) -> Option<Path> {
    let mut path = Path { upper, length, mu: 0.0, factor: 1.0, slope: 0.0 };
    for _ in 0..HALVINGS {
        path.mu = 0.0;
        let mut bracket = [f64::NEG_INFINITY, f64::INFINITY];
        loop {
            let [sum, positive, slope, along] = reduce(
                x.len(),
                &|range| {
                    let mut sums = [0.0; 4];
                    for ((x, z), g) in x[range.clone()].iter().zip(&z[range.clone()]).zip(&gradient[range]) {
                        let (end, g) = (path.end(*x, *z), g - multiplier);
                        let moves = (end > 0.0) & (end < upper);
                        sums = add(sums, [end, f64::from(moves), g * (end - x), g * end]);
                    }
                    sums
                },
                &add,
            );
            (path.factor, path.slope) = (1.0, slope);
            let Some(mean) = mean else { break };
            let asked = mean * x.len() as f64;
            let excess = sum - asked;
            if upper.is_finite() && excess.abs() <= EXACT * asked {
                break;
            }
            if upper == f64::INFINITY && excess.abs() <= MEAN * asked {
                path.factor = asked / sum;
                path.slope += (path.factor - 1.0) * along;
                break;
            }
            // Newton's method on a convex, piecewise linear function takes a few steps. With two bounds the function is
            // not convex, and the steps are kept within a bracket.
            let mut mu = path.mu + excess / positive;
            if upper.is_finite() {
                bracket[usize::from(excess < 0.0)] = path.mu;
                let inside = bracket[0] < mu && mu < bracket[1];
                if !inside {
                    mu = middle(bracket, path.mu, upper);
                }
            }
            if !mu.is_finite() || mu == path.mu {
                return None;
            }
            path.mu = mu;
        }
        if path.slope < 0.0 {
            return Some(path);
        }
        path.length *= 0.5;
    }
    None
}

/// The middle of a bracket; one that is open on a side is opened further.
fn middle([low, high]: [f64; 2], mu: f64, upper: f64) -> f64 {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => 0.5 * (low + high),
        (true, false) => mu + mu.abs().max(upper),
        _ => mu - mu.abs().max(upper),
    }
}

/// Brings the start to the prescribed mean, between zero and the upper bound.
fn begin(x: &mut [f64], mean: Option<f64>, upper: f64) {
    rescale(x, total(x), mean);
    let Some(mean) = mean.filter(|_| upper.is_finite()) else { return };
    let highest = x.iter().copied().fold(0.0, f64::max);
    if highest > upper {
        let part = (upper - mean) / (highest - mean);
        for_each([x], &|_, [x]| x.iter_mut().for_each(|x| *x = (mean + part * (*x - mean)).clamp(0.0, upper)));
    }
}

/// x ← the end of the path; z ← the step to it.
fn advance(x: &mut [f64], z: &mut [f64], path: &Path) {
    for_each([x, z], &|_, [x, z]| {
        for (x, z) in x.iter_mut().zip(z) {
            let end = path.factor * path.end(*x, *z);
            (*z, *x) = (end - *x, end);
        }
    });
}
