//! One field, with steps, images and gradient in single precision.

use gfmd_vector::{Share, add, add_times, for_each, pass};
use multiversion::multiversion;

use super::active::{Active, Flags};
use super::constants::{CANCELLED, CHANGE, REFRESH, ROUNDING_OF_START};
use super::path::{Path, Start};
use super::sums::{Sums, View, block_sums, measure};
use super::{Advance, Course, Vectors};
use crate::preconditioned::BLOCK;
use crate::quadratic::{Iterate, LEAST_DESCENT, Target, rescale};
use crate::{Ceiling, Preconditioned, Upper, Visit};

pub(super) struct Single<'a, P> {
    problem: &'a mut P,
    x: &'a mut [f64],
    target: &'a Target,
    share: Share,
    /// Units of gradients and of steps.
    units: [f64; 2],
    upper: Upper,
    /// Gradient minus a level, and the level, which is the multiplier at the last refresh.
    gradient: Vec<f32>,
    level: f64,
    multiplier: f64,
    /// Direction of the next step; empty while an exact gradient needs the memory.
    direction: Vec<f32>,
    last_step: Vec<f32>,
    /// Image of the last step.
    image: Vec<f32>,
    active: Active,
    sums: Sums,
    /// Sums of each stretch.
    parts: Vec<Sums>,
}

impl<'a, P: Preconditioned> Single<'a, P> {
    /// Creates the search and moves the start to the prescribed mean.
    pub(super) fn new(problem: &'a mut P, x: &'a mut [f64], target: &'a Target) -> Self {
        let n = problem.length();
        let (share, upper) = (problem.share(), problem.upper());
        begin(&share, x, target.mean, &upper);
        // A power of two, which causes no rounding.
        let unit = target.gradient_scale.log2().floor().exp2();
        Self {
            x,
            target,
            share,
            units: [unit, unit / problem.unit()],
            upper,
            gradient: vec![0.0; n],
            level: 0.0,
            multiplier: 0.0,
            direction: Vec::new(),
            last_step: vec![0.0; n],
            image: vec![0.0; n],
            active: Active::all(n, problem.stretch()),
            sums: Sums::EMPTY,
            parts: (0..n / problem.stretch()).map(|_| Sums::EMPTY).collect(),
            problem,
        }
    }

    fn view(&self) -> View {
        let [gradient, step] = self.units;
        let offset = (self.multiplier - self.level) / gradient;
        View { gradient, step, offset, level: self.level }
    }

    /// Subtracts (1 − part) s from x. The gradient is interpolated between the beginning and the end of the step.
    fn step_back(&mut self, part: f64) {
        let view = self.view();
        let rest = 1.0 - part;
        let Self { x, target, share, upper, gradient, last_step, image, active, .. } = self;
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
            keep_mean(share, x, target.mean, upper);
        } else if self.sums.x > 0.0 {
            rescale(share, x, self.sums.x, target.mean);
        }
    }

    /// Subtracts β s from z, with β such that z is conjugate to s (Hestenes and Stiefel 1952), where z ≠ 0 (free
    /// variables). β does not depend on the length of s.
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
}

impl<P: Preconditioned> Vectors for Single<'_, P> {
    type Path = Path;

    fn refresh_at() -> f64 {
        REFRESH
    }

    fn visit(&mut self, course: &mut Course, visitor: &mut dyn Visit) {
        let share = &self.problem.share();
        visitor.rows(share, self.x);
        for field in [&mut self.gradient, &mut self.last_step, &mut self.image] {
            visitor.single_rows(share, field);
        }
        visitor.numbers(&mut [&mut self.level, &mut self.multiplier]);
        course.visit(visitor);
        self.sums.visit(visitor);
        self.problem.visit(visitor);
    }

    fn refresh(&mut self) {
        self.direction = Vec::new();
        self.level = self.multiplier;
        let view = self.view();
        let Self { problem, x, upper, gradient, last_step, parts, .. } = self;
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
        problem.gradient(x, (&mut gradient[..], &**x, &last_step[..], upper.ceiling()), sink, parts);
        self.sums = Sums::all(&self.share, parts);
    }

    fn is_coarse(&self) -> bool {
        let Target { gradient_scale, budget, .. } = self.target;
        (self.multiplier - self.level).abs() * f64::from(f32::EPSILON) > budget.tolerance * gradient_scale
    }

    fn settle(&mut self) -> Iterate {
        let Self { sums, target, .. } = self;
        let shift = if target.mean.is_some() { sums.shift() } else { 0.0 };
        let (optimality, positive) = (sums.optimality(shift, target.gradient_scale), sums.positive);
        self.multiplier += shift;
        Iterate { iteration: 0, optimality, multiplier: self.multiplier, positive }
    }

    fn trusts_images(&self) -> bool {
        self.problem.trusts_images()
    }

    fn turn(&mut self, settled: bool) {
        let offset = self.view().offset as f32;
        self.direction.resize(self.x.len(), 0.0);
        self.problem.precondition(self.x, &self.gradient, offset, &mut self.direction);
        if !self.problem.mark(self.active.flags_mut()) {
            self.active.survey(self.x, &self.direction);
        }
        if settled {
            self.conjugate();
        }
    }

    /// The direction has zero mean if the mean is prescribed.
    fn steepest(&mut self) -> f64 {
        let view = self.view();
        let is_free =
            |x: f64, g: f64, upper: f64| if x >= upper && x.is_finite() { g > 0.0 } else { x > 0.0 || g < 0.0 };
        let Self { x, target, share, upper, gradient, direction, .. } = self;
        direction.resize(x.len(), 0.0);
        let x = &x[..];
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
        let mean = if target.mean.is_some() { sum / count } else { 0.0 };
        let squares = share.pass(
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
        );
        self.active.survey(self.x, &self.direction);
        squares / self.problem.curvature(&self.direction)
    }

    fn downhill(&self, length: f64) -> Option<Path> {
        let Self { x, target, share, upper, direction, gradient, active, .. } = self;
        let upper = upper.ceiling();
        Start { share, x, direction, gradient, active, view: self.view(), upper }.downhill(length, target.mean)
    }

    /// The gradient at the end follows from the image of the step.
    fn advance(&mut self, path: &Path) -> Advance {
        let view = self.view();
        let Self { problem, x, upper, gradient, direction, image, active, parts, .. } = self;
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
        problem.collect((&mut gradient[..], &mut image[..], &**x, &direction[..], bounds), sink, parts);
        self.sums = Sums::all(&self.share, parts);
        std::mem::swap(&mut self.direction, &mut self.last_step);
        // Along the step the slope changes linearly.
        let rise = self.sums.slope - path.slope;
        let lowest = if rise > 0.0 { -path.slope / rise } else { f64::INFINITY };
        Advance { length: path.length, lowest, clipped: self.sums.clipped > 0 }
    }

    fn keep(&mut self, part: f64) -> bool {
        if part < 1.0 {
            self.step_back(part);
        }
        let cancelled = part < CANCELLED;
        if cancelled {
            self.refresh();
        }
        cancelled
    }

    fn length_after(length: f64, lowest: f64) -> f64 {
        (length * lowest.max(1.0 / CHANGE)).min(1.0)
    }
}

/// Writes the gradient minus the level in its unit.
#[multiversion(targets = "simd")]
fn round(row: &[f64], view: View, gradient: &mut [f32]) {
    // The unit is a power of two.
    let factor = 1.0 / view.gradient;
    gradient.iter_mut().zip(row).for_each(|(g, row)| *g = ((row - view.level) * factor) as f32);
}

/// Moves x to the end of the path along z, and writes the step, in its unit, into z and `row`.
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

/// Subtracts `rest` s from x, within the bounds.
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

/// Subtracts β s from z where z ≠ 0.
#[multiversion(targets = "simd")]
fn subtract(beta: f32, step: &[f32], flags: Flags<'_>, direction: &mut [f32]) {
    for (block, (z, s)) in direction.chunks_mut(BLOCK).zip(step.chunks(BLOCK)).enumerate() {
        if !flags.idle(block) {
            z.iter_mut().zip(s).for_each(|(z, s)| *z -= if *z != 0.0 { beta * s } else { 0.0 });
        }
    }
}

/// Scales the variables between the bounds to remove rounding errors from the prescribed mean.
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

/// Moves the start to the prescribed mean, between zero and the upper bounds: towards the bounds scaled to this mean,
/// as far as necessary.
pub(super) fn begin(share: &Share, x: &mut [f64], mean: Option<f64>, upper: &Upper) {
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
    if part < 1.0 && part > 1.0 - ROUNDING_OF_START {
        // The start has this mean already; the other variables stay where they are, above all those at zero.
        for_each((&mut *x, ceiling), &|_, (x, ceiling)| {
            x.iter_mut().enumerate().for_each(|(i, x)| *x = x.min(ceiling.at(i)));
        });
        keep_mean(share, x, Some(mean), ceiling);
    } else if part < 1.0 {
        for_each((x, ceiling), &|_, (x, ceiling)| {
            for (i, x) in x.iter_mut().enumerate() {
                let base = base(ceiling.at(i));
                *x = (base + part * (*x - base)).clamp(0.0, ceiling.at(i));
            }
        });
    }
}
