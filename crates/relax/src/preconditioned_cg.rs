mod active;
mod path;
mod sums;

use active::{Active, Flags};
use gfmd_vector::{Share, add, add_times, for_each, pass};
use multiversion::multiversion;
use path::{Path, Start};
use sums::{Sums, View, block_sums, measure};

use crate::preconditioned::BLOCK;
use crate::quadratic::{Iterate, LEAST_DESCENT, Minimum, Target, rescale};
use crate::{Ceiling, Ending, Preconditioned, RelaxError, Upper, Visit, Watch, Why};

/// Projected conjugate gradients with a preconditioner M close to the inverse of A on the free variables
/// ([`Preconditioned`]). An iteration takes one image and one preconditioning.
///
/// Since z = M g is nearly Newton's step, the step length is 1; M should not be smaller than the inverse of A, so that
/// this is not too short. x goes to `max(0, x − z − μ)`, with μ such that the prescribed mean is kept. The image of the step
/// gives the new gradient, and with both gradients the function is a known parabola along the segment from the old x
/// to the new x. If its minimum lies inside the segment, x steps back to it, which costs no further image. The function
/// thus decreases in every iteration, and no curvature has to be computed.
///
/// While no variable reaches zero, these are exact line searches, and directions are made conjugate to the last step.
/// If some variables reach zero, a step that lowers the function is kept whole, since stepping back would make them
/// positive again. The next step has the length that would have been the best for this one, as those of Barzilai and
/// Borwein (1988), but at most 1: steps of one length may overshoot again and again where M is too large.
///
/// Every 25th direction, and any direction that the projection turns uphill, is the gradient. Projected gradients with
/// a step that lowers the function converge for any steps in between (Bertsekas 1976).
///
/// The variables have double precision. Steps, their images and the gradient to which these are added have single precision,
/// which halves their memory and nearly the time of a transform. Whenever the residual has fallen to 1e-4 of what it was,
/// and before the search ends (unless the problem [trusts images](Preconditioned::trusts_images)), the gradient is computed anew
/// from x in double precision: rounding errors then are relative to a smaller gradient and smaller steps, so that no
/// accuracy is lost (Sleijpen and van der Vorst 1996).
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

/// The gradient is computed anew when the residual has fallen by this factor. The rounding errors of a step are some
/// 1e-7 of it, and a solution takes ten to thirty steps.
const REFRESH: f64 = 1e-4;

/// Largest factor by which the length changes from one step to the next.
const CHANGE: f64 = 10.0;

impl PreconditionedCg {
    /// Minimises from the start `x`, in place; `watch` sees every iterate.
    ///
    /// # Errors
    /// An invalid start or target. A search without success is not an error but an [`Ending`].
    pub fn minimise<P: Preconditioned>(
        &self,
        problem: &mut P,
        x: &mut [f64],
        target: &Target,
        watch: &mut dyn Watch,
    ) -> Result<Minimum, RelaxError> {
        let upper = problem.upper();
        let share = problem.share();
        target.check_between(x, &share, &upper)?;
        begin(&share, x, target.mean, &upper);
        let mut search = Search::new(problem, target);
        search.refresh(problem, x);
        if let Some(kept) = watch.recall() {
            search.visit(problem, x, kept);
        }
        loop {
            watch.checkpoint(&mut |visitor| search.visit(problem, x, visitor));
            let mut now = search.settle(target);
            let worst = now.optimality.worst();
            let is_over = problem.trusts_images() && worst <= target.budget.tolerance;
            if !(search.is_fresh || is_over) && worst <= target.budget.tolerance.max(REFRESH * search.reference) {
                search.refresh(problem, x);
                now = search.settle(target);
            }
            if search.is_fresh {
                search.reference = now.optimality.worst();
            }
            if let Some(ending) = target.judge(&now, watch, &share) {
                return Ok(Minimum { reached: now, ending });
            }
            if search.step(problem, x, target.mean) {
                continue;
            } else if search.is_fresh {
                return Ok(Minimum { reached: now, ending: Ending::GaveUp(Why::NoDescent) });
            }
            search.refresh(problem, x);
        }
    }
}

/// The state of a search.
struct Search {
    share: Share,
    /// The units of gradients and of steps.
    units: [f64; 2],
    upper: Upper,
    /// The gradient less a level, and that level: the multiplier at the last refresh.
    gradient: Vec<f32>,
    level: f64,
    multiplier: f64,
    direction: Vec<f32>,
    last_step: Vec<f32>,
    /// The image of the last step.
    image: Vec<f32>,
    active: Active,
    sums: Sums,
    /// One for each stretch.
    parts: Vec<Sums>,
    length: f64,
    settled: bool,
    iteration: u64,
    /// True if the gradient is that of x in double precision.
    is_fresh: bool,
    /// The residual at the last refresh.
    reference: f64,
}

impl Search {
    fn new<P: Preconditioned>(problem: &P, target: &Target) -> Self {
        let n = problem.length();
        // A power of two, by which nothing is rounded.
        let unit = target.gradient_scale.log2().floor().exp2();
        Self {
            share: problem.share(),
            units: [unit, unit / problem.unit()],
            upper: problem.upper(),
            gradient: vec![0.0; n],
            level: 0.0,
            multiplier: 0.0,
            direction: vec![0.0; n],
            last_step: vec![0.0; n],
            image: vec![0.0; n],
            active: Active::all(n, problem.stretch()),
            sums: Sums::EMPTY,
            parts: (0..n / problem.stretch()).map(|_| Sums::EMPTY).collect(),
            length: 1.0,
            settled: false,
            iteration: 0,
            is_fresh: false,
            reference: f64::INFINITY,
        }
    }

    fn visit<P: Preconditioned>(&mut self, problem: &mut P, x: &mut [f64], visitor: &mut dyn Visit) {
        visitor.field(x);
        for field in [&mut self.gradient, &mut self.last_step, &mut self.image] {
            visitor.single(field);
        }
        visitor.numbers(&mut [&mut self.level, &mut self.multiplier, &mut self.length, &mut self.reference]);
        visitor.flag(&mut self.settled);
        visitor.flag(&mut self.is_fresh);
        visitor.count(&mut self.iteration);
        self.sums.visit(visitor);
        problem.visit(visitor);
    }

    /// Computes the gradient from x, less the multiplier.
    fn refresh<P: Preconditioned>(&mut self, problem: &mut P, x: &[f64]) {
        self.level = self.multiplier;
        self.is_fresh = true;
        let view = self.view();
        let Self { upper, gradient, last_step, parts, .. } = self;
        let sink = |row: &[f64], (gradient, x, step, upper): (&mut [f32], &[f64], &[f32], Ceiling)| {
            pass(
                (gradient, row, x, step, upper),
                &|_, (gradient, row, x, step, upper)| {
                    round(row, view, gradient);
                    measure(view, |row| row - view.level, (row, x, step, upper, Flags::Unknown))
                },
                &Sums::merge,
            )
        };
        problem.gradient(x, (&mut gradient[..], x, &last_step[..], upper.ceiling()), sink, parts);
        self.sums = Sums::all(&self.share, parts);
    }

    /// Moves the multiplier to the mean gradient of the variables between the bounds.
    fn settle(&mut self, target: &Target) -> Iterate {
        let Self { sums, iteration, .. } = self;
        let shift = if target.mean.is_some() { sums.shift() } else { 0.0 };
        let (optimality, positive) = (sums.optimality(shift, target.gradient_scale), sums.positive);
        self.multiplier += shift;
        Iterate { iteration: *iteration, optimality, multiplier: self.multiplier, positive }
    }

    /// Takes one step; false if none begins downhill.
    fn step<P: Preconditioned>(&mut self, problem: &mut P, x: &mut [f64], mean: Option<f64>) -> bool {
        let view = self.view();
        let mut path = None;
        if self.iteration % PLAIN != PLAIN - 1 {
            problem.precondition(x, &self.gradient, view.offset as f32, &mut self.direction);
            if !problem.mark(self.active.flags_mut()) {
                self.active.survey(x, &self.direction);
            }
            if self.settled {
                self.conjugate();
            }
            path = self.downhill(x, self.length, mean);
        }
        let preconditioned = path.is_some();
        if path.is_none() {
            let squares = self.steepest(x, mean.is_some());
            self.active.survey(x, &self.direction);
            path = self.downhill(x, squares / problem.curvature(&self.direction), mean);
        }
        let Some(path) = path else { return false };

        self.advance(problem, x, &path);
        // Along the step the slope changes linearly.
        let rise = self.sums.slope - path.slope;
        let lowest = if rise > 0.0 { -path.slope / rise } else { f64::INFINITY };
        self.settled = self.sums.clipped == 0;
        if preconditioned {
            self.length = if self.settled {
                (path.length * lowest.min(CHANGE)).max(1.0)
            } else {
                (path.length * lowest.max(1.0 / CHANGE)).min(1.0)
            };
        }
        if lowest < if self.settled { 1.0 } else { DOWNHILL } {
            let part = lowest.max(0.0);
            self.step_back(x, part, mean);
            if part < CANCELLED {
                self.refresh(problem, x);
            }
        }
        self.iteration += 1;
        true
    }

    fn view(&self) -> View {
        let [gradient, step] = self.units;
        let offset = (self.multiplier - self.level) / gradient;
        View { gradient, step, offset, level: self.level }
    }

    /// x ← the end of the path; the gradient there follows from the image of the step.
    fn advance<P: Preconditioned>(&mut self, problem: &mut P, x: &mut [f64], path: &Path) {
        let view = self.view();
        let Self { upper, gradient, direction, image, active, parts, .. } = self;
        let bounds = (upper.ceiling(), active.flags());
        problem.image((&mut x[..], &mut direction[..], bounds), |(x, z, bounds), row| {
            go(path, view.step, (x, z, bounds), row);
        });
        type Parts<'a> = (&'a mut [f32], &'a mut [f32], &'a [f64], &'a [f32], (Ceiling<'a>, Flags<'a>));
        let sink = |row: &[f32], (gradient, image, x, step, bounds): Parts| {
            pass(
                (gradient, (image, row), x, step, bounds),
                &|_, (gradient, (image, row), x, step, (upper, flags))| {
                    image.copy_from_slice(row);
                    add_times(gradient, 1.0, row);
                    measure(view, |g| view.own(g), (&*gradient, x, step, upper, flags))
                },
                &Sums::merge,
            )
        };
        problem.collect((&mut gradient[..], &mut image[..], &*x, &direction[..], bounds), sink, parts);
        self.sums = Sums::all(&self.share, parts);
        self.is_fresh = false;
        std::mem::swap(&mut self.direction, &mut self.last_step);
    }

    /// x ← x − (1 − part) s; the gradient is interpolated between those before and after the step.
    fn step_back(&mut self, x: &mut [f64], part: f64, mean: Option<f64>) {
        let view = self.view();
        let rest = 1.0 - part;
        let Self { share, upper, gradient, last_step, image, active, .. } = self;
        let upper = upper.ceiling();
        self.sums = share.pass(
            (&mut x[..], &mut gradient[..], &image[..], &last_step[..], (upper, active.flags())),
            &|_, (x, gradient, image, step, (upper, flags))| {
                add_times(gradient, -(rest as f32), image);
                retreat(rest * view.step, step, (upper, flags), x);
                measure(view, |g| view.own(g), (&*gradient, x, step, upper, flags))
            },
            &Sums::merge,
        );
        if upper.is_finite() {
            keep_mean(share, x, mean, upper);
        } else if self.sums.x > 0.0 {
            rescale(share, x, self.sums.x, mean);
        }
    }

    /// z ← z − β s with β such that z is conjugate to s (Hestenes and Stiefel 1952), on the free variables, where z ≠ 0.
    /// β does not depend on the length of s.
    fn conjugate(&mut self) {
        let offset = self.view().offset;
        let Self { share, gradient, direction, last_step, image, active, .. } = self;
        let (z, s, y, g) = (&*direction, &*last_step, &*image, &*gradient);
        let [z_image, s_image, z_gradient, s_gradient] = share.reduce(
            &|range| {
                active.blocks(range).fold([0.0; 4], |sums, block| {
                    let [z, s, y, g] = [z, s, y, g].map(|field| &field[block.clone()]);
                    let terms = |z: f32, s: f32, y: f32, g: f32| {
                        let [z, s, y] = [z, s, y].map(f64::from);
                        let g = f64::from(g) - offset;
                        [z * y, s * y, z * g, if z != 0.0 { s * g } else { 0.0 }]
                    };
                    add(sums, block_sums((z, s, y, g), terms))
                })
            },
            &add,
        );
        let beta = z_image / s_image;
        if z_gradient - beta * s_gradient >= LEAST_DESCENT * z_gradient {
            let beta = beta as f32;
            for_each((&mut direction[..], &last_step[..], active.flags()), &|_, (z, s, flags)| {
                subtract(beta, s, flags, z);
            });
        }
    }

    /// z ← g − λ on the free variables, with zero mean if the mean is prescribed; zero elsewhere. Returns ⟨z, z⟩.
    fn steepest(&mut self, x: &[f64], constrained: bool) -> f64 {
        let view = self.view();
        let is_free =
            |x: f64, g: f64, upper: f64| if x >= upper && x.is_finite() { g > 0.0 } else { x > 0.0 || g < 0.0 };
        let Self { share, upper, gradient, direction, .. } = self;
        let (gradient, upper) = (&gradient[..], upper.ceiling());
        let own = |g: f32| f64::from(g) - view.offset;
        let [sum, count] = share.reduce(
            &|range| {
                let all = range.map(|i| (i, own(gradient[i])));
                let free = all.filter(|(i, g)| is_free(x[*i], *g, upper.at(*i)));
                free.fold([0.0; 2], |sums, (_, g)| add(sums, [g, 1.0]))
            },
            &add,
        );
        let mean = if constrained { sum / count } else { 0.0 };
        share.pass(
            (&mut direction[..], x, gradient, upper),
            &|_, (z, x, gradient, upper)| {
                let mut squares = 0.0;
                for (i, ((z, x), g)) in z.iter_mut().zip(x).zip(gradient).enumerate() {
                    let g = own(*g);
                    *z = if is_free(*x, g, upper.at(i)) { (g - mean) as f32 } else { 0.0 };
                    squares += f64::from(*z) * f64::from(*z);
                }
                squares
            },
            &|a, b| a + b,
        )
    }

    fn downhill(&self, x: &[f64], length: f64, mean: Option<f64>) -> Option<Path> {
        let Self { share, upper, direction, gradient, active, .. } = self;
        let upper = upper.ceiling();
        Start { share, x, direction, gradient, active, view: self.view(), upper }.downhill(length, mean)
    }
}

/// The gradient in its unit, less the level.
#[multiversion(targets = "simd")]
fn round(row: &[f64], view: View, gradient: &mut [f32]) {
    // The unit is a power of two.
    let factor = 1.0 / view.gradient;
    gradient.iter_mut().zip(row).for_each(|(g, row)| *g = ((row - view.level) * factor) as f32);
}

/// x ← the end of the path along z; z and `row` ← the step there, in the unit of steps.
#[multiversion(targets = "simd")]
fn go(path: &Path, unit: f64, ends: (&mut [f64], &mut [f32], (Ceiling<'_>, Flags<'_>)), row: &mut [f32]) {
    let (x, z, (upper, flags)) = ends;
    // The unit is a power of two.
    let steps = 1.0 / unit;
    let blocks = x.chunks_mut(BLOCK).zip(z.chunks_mut(BLOCK)).zip(row.chunks_mut(BLOCK));
    for (block, ((x, z), row)) in blocks.enumerate() {
        if flags.idle(block) {
            row.fill(0.0);
            continue;
        }
        let upper = upper.part(block * BLOCK..block * BLOCK + x.len());
        for (i, ((x, z), row)) in x.iter_mut().zip(z).zip(row).enumerate() {
            let end = path.factor * path.end(*x, *z, upper.at(i));
            *z = ((end - *x) * steps) as f32;
            *x = end;
            *row = *z;
        }
    }
}

/// x ← x − `rest` s, between the bounds.
#[multiversion(targets = "simd")]
fn retreat(rest: f64, step: &[f32], bounds: (Ceiling<'_>, Flags<'_>), x: &mut [f64]) {
    let (upper, flags) = bounds;
    for (block, (x, step)) in x.chunks_mut(BLOCK).zip(step.chunks(BLOCK)).enumerate() {
        if !flags.idle(block) {
            let upper = upper.part(block * BLOCK..block * BLOCK + x.len());
            for (i, (x, s)) in x.iter_mut().zip(step).enumerate() {
                *x = (*x - rest * f64::from(*s)).max(0.0).min(upper.at(i));
            }
        }
    }
}

/// z ← z − β s where z ≠ 0.
#[multiversion(targets = "simd")]
fn subtract(beta: f32, step: &[f32], flags: Flags<'_>, direction: &mut [f32]) {
    for (block, (z, s)) in direction.chunks_mut(BLOCK).zip(step.chunks(BLOCK)).enumerate() {
        if !flags.idle(block) {
            z.iter_mut().zip(s).for_each(|(z, s)| *z -= if *z != 0.0 { beta * s } else { 0.0 });
        }
    }
}

/// Scales the variables between the bounds such that the mean is the prescribed one, from which it differs by rounding errors.
fn keep_mean(share: &Share, x: &mut [f64], mean: Option<f64>, upper: Ceiling) {
    let Some(mean) = mean else { return };
    let [inside, at_bound] = share.reduce(
        &|range| {
            let each = range.map(|i| if x[i] < upper.at(i) { [x[i], 0.0] } else { [0.0, x[i]] });
            each.fold([0.0; 2], add)
        },
        &add,
    );
    let factor = (mean * share.total() as f64 - at_bound) / inside;
    if factor > 0.0 && factor.is_finite() {
        for_each((x, upper), &|_, (x, upper)| {
            for (i, x) in x.iter_mut().enumerate() {
                *x = if *x < upper.at(i) { (factor * *x).min(upper.at(i)) } else { *x };
            }
        });
    }
}

/// Brings the start to the prescribed mean, between zero and the upper bounds: as far as they allow from the bounds scaled to
/// that mean.
fn begin(share: &Share, x: &mut [f64], mean: Option<f64>, upper: &Upper) {
    rescale(share, x, share.total_of(x), mean);
    let Some(mean) = mean.filter(|_| upper.ceiling().is_finite()) else { return };
    let fraction = mean / upper.mean_over(share);
    let base = |bound: f64| if let Upper::All(_) = upper { mean } else { fraction * bound };
    let ceiling = upper.ceiling();
    let allowed = |(i, x): (usize, &f64)| {
        let bound = ceiling.at(i);
        if *x > bound { (bound - base(bound)) / (*x - base(bound)) } else { 1.0 }
    };
    let part = x.iter().enumerate().map(allowed).fold(1.0, f64::min);
    let part = share.each(part).into_iter().fold(1.0, f64::min);
    if part < 1.0 {
        for_each((x, ceiling), &|_, (x, ceiling)| {
            for (i, x) in x.iter_mut().enumerate() {
                let base = base(ceiling.at(i));
                *x = (base + part * (*x - base)).clamp(0.0, ceiling.at(i));
            }
        });
    }
}
