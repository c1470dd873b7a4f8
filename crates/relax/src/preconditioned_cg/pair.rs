//! Two fields coupled by the function and by their means, in double precision.

use gfmd_vector::{Share, add, for_each};

use super::constants::{BOUNDED_MEAN, CHANGE, DOWNHILL, HALVINGS, PAIR_MEAN, SHIFTS};
use super::path::middle;
use super::single::begin;
use super::{Advance, Course, Vectors};
use crate::quadratic::{Iterate, LEAST_DESCENT, OptimalitySums, Target, turn};
use crate::{Ceiling, Upper, Visit};

/// Convex quadratic function ½⟨x, A x⟩ + ⟨b, x⟩ of the non-negative variables of two fields, the halves of one vector,
/// possibly with upper bounds, for [`PreconditionedCg::minimise_pair`](crate::PreconditionedCg::minimise_pair). A is
/// symmetric and positive semi-definite, and has a preconditioner.
pub trait Paired {
    /// Returns b, one value for each variable; the number of variables is even.
    fn linear(&self) -> &[f64];

    /// Writes `A x` into `out`.
    fn apply(&mut self, x: &[f64], out: &mut [f64]);

    /// Returns the upper bounds of all variables, positive; infinite if there are none.
    fn upper(&self) -> Upper {
        Upper::All(f64::INFINITY)
    }

    /// Writes `M gradient` into `out` on the free variables, and zero elsewhere. This is approximately the step to the
    /// point where the gradient of the free variables vanishes. Variables are free if between the bounds, if zero with
    /// a negative gradient, or if at the upper bound with a positive one. M depends on the free set; it is symmetric
    /// positive (semi-)definite and approximates A⁻¹ on this set.
    fn precondition(&mut self, x: &[f64], gradient: &[f64], out: &mut [f64]);

    /// Returns the rows of this process of both fields; by default, the process is alone.
    fn share(&self) -> Share {
        Share::whole(self.linear().len() / 2, 1).of_faces()
    }

    /// Visits the variables that the problem itself changes during a search, for example an effort counter.
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let _ = visitor;
    }
}

/// Constraint on the means of the two halves.
#[derive(Clone, Copy)]
enum Means {
    /// Both means have this value.
    Both(f64),
    /// The two means are equal.
    Equal,
}

pub(super) struct Pair<'a, P> {
    problem: &'a mut P,
    /// Rows of this process, of both halves.
    share: Share,
    x: &'a mut [f64],
    means: Means,
    upper: Upper,
    /// Scale of gradients in the residuals.
    scale: f64,
    /// Gradient minus the multiplier of each half.
    gradient: Vec<f64>,
    direction: Vec<f64>,
    last_step: Vec<f64>,
    /// Image of the last step.
    image: Vec<f64>,
}

impl<'a, P: Paired> Pair<'a, P> {
    pub(super) fn new(problem: &'a mut P, x: &'a mut [f64], target: &Target) -> Self {
        let [gradient, direction, last_step, image] = std::array::from_fn(|_| vec![0.0; x.len()]);
        let means = target.mean.map_or(Means::Equal, Means::Both);
        let (upper, share) = (problem.upper(), problem.share());
        if upper.ceiling().is_finite() {
            let middle = x.len() / 2;
            for (half, x) in halves(x).into_iter().enumerate() {
                let upper = match &upper {
                    Upper::All(bound) => Upper::All(*bound),
                    Upper::Each(bounds) => Upper::Each(bounds[half * middle..(half + 1) * middle].into()),
                };
                begin(&share.face(), x, target.mean, &upper);
            }
        }
        Self { problem, share, x, means, upper, scale: target.gradient_scale, gradient, direction, last_step, image }
    }

    /// Subtracts β s from z, with β such that z is conjugate to s, where z ≠ 0 (free variables).
    fn conjugate(&mut self) {
        let Self { share, gradient, direction, last_step, image, .. } = self;
        let [z_image, s_image, z_gradient, s_gradient] = share.reduce(
            &|range| {
                range.fold([0.0; 4], |sums, k| {
                    let (z, s, y, g) = (direction[k], last_step[k], image[k], gradient[k]);
                    add(sums, [z * y, s * y, z * g, if z == 0.0 { 0.0 } else { s * g }])
                })
            },
            &add,
        );
        let beta = z_image / s_image;
        if z_gradient - beta * s_gradient >= LEAST_DESCENT * z_gradient {
            for_each((&mut direction[..], &last_step[..]), &|_, (z, s)| {
                z.iter_mut().zip(s).for_each(|(z, s)| *z -= if *z == 0.0 { 0.0 } else { beta * s });
            });
        }
    }
}

impl<P: Paired> Vectors for Pair<'_, P> {
    type Path = Path;

    fn refresh_at() -> f64 {
        0.0
    }

    fn visit(&mut self, course: &mut Course, visitor: &mut dyn Visit) {
        visitor.rows(&self.share, self.x);
        for field in [&mut self.gradient, &mut self.last_step, &mut self.image] {
            visitor.rows(&self.share, field);
        }
        course.visit(visitor);
        self.problem.visit(visitor);
    }

    /// Rescales the means first, so that they are exact.
    fn refresh(&mut self) {
        keep_means(&self.share.face(), self.x, self.means, self.upper.ceiling());
        self.problem.apply(self.x, &mut self.gradient);
        for_each((&mut self.gradient[..], self.problem.linear()), &|_, (gradient, linear)| {
            gradient.iter_mut().zip(linear).for_each(|(gradient, linear)| *gradient += linear);
        });
    }

    /// Subtracts the multipliers from the gradient.
    fn settle(&mut self) -> Iterate {
        let (x, upper, face) = (&*self.x, self.upper.ceiling(), self.share.face());
        let middle = x.len() / 2;
        let parts = [0..middle, middle..x.len()];
        let found = parts
            .clone()
            .map(|part| HalfSums::of(&face, &x[part.clone()], &self.gradient[part.clone()], upper.part(part)));
        let multipliers = multipliers(&found, self.means);
        let judged = halves(&mut self.gradient).into_iter().zip(parts).zip(multipliers);
        let judged = judged.map(|((gradient, part), multiplier)| {
            let (x, upper) = (&x[part.clone()], upper.part(part));
            let leaf = |start: usize, [gradient]: [&mut [f64]; 1]| {
                let (mut judged, mut highest) = (OptimalitySums::EMPTY, f64::NEG_INFINITY);
                for (k, (g, x)) in (start..).zip(gradient.iter_mut().zip(&x[start..])) {
                    *g -= multiplier;
                    if is_full(*x, upper.at(k)) { highest = highest.max(*g) } else { judged.see(*x, *g) }
                }
                (judged, highest)
            };
            face.pass([gradient], &leaf, &merge)
        });
        let (judged, highest) = judged.fold((OptimalitySums::EMPTY, f64::NEG_INFINITY), merge);
        let mut optimality = judged.optimality(self.scale);
        optimality.violation = optimality.violation.max(highest / self.scale);
        let positive = found.iter().map(|half| half.between).sum::<f64>() as usize;
        Iterate { iteration: 0, optimality, multiplier: multipliers[0], positive }
    }

    fn turn(&mut self, settled: bool) {
        self.problem.precondition(self.x, &self.gradient, &mut self.direction);
        if settled {
            self.conjugate();
        }
    }

    fn steepest(&mut self) -> f64 {
        let Self { problem, share, x, gradient, direction, image, upper, .. } = self;
        // The preconditioner may have left values that are not finite.
        direction.fill(0.0);
        let mut squares = turn(share, direction, x, gradient, 0.0, 0.0, &|x, g| x > 0.0 || g < 0.0);
        let upper = upper.ceiling();
        if upper.is_finite() {
            let leaf = |start: usize, [direction]: [&mut [f64]; 1]| {
                let held = |k: usize| is_full(x[k], upper.at(k)) && gradient[k] <= 0.0;
                let all = (start..).zip(direction).map(|(k, z)| {
                    *z = if held(k) { 0.0 } else { *z };
                    *z * gradient[k]
                });
                all.sum()
            };
            squares = share.pass([&mut direction[..]], &leaf, &|a: f64, b| a + b);
        }
        problem.apply(direction, image);
        squares / share.dot(direction, image)
    }

    fn downhill(&self, length: f64) -> Option<Path> {
        let Self { share, x, direction, gradient, means, upper, .. } = self;
        let upper = upper.ceiling();
        let middle = x.len() / 2;
        let mut path = Path { length, shifts: [0.0; 2], slope: 0.0 };
        for _ in 0..HALVINGS {
            path.shifts = path.kept(share, *means, (x, direction, upper))?;
            path.slope = share.sum(&|range| {
                let end = |k: usize| path.end(usize::from(k >= middle), x[k], direction[k], upper.at(k));
                let term = |k: usize| gradient[k] * (end(k) - x[k]);
                range.map(term).sum()
            });
            if path.slope < 0.0 {
                return Some(path);
            }
            path.length *= 0.5;
        }
        None
    }

    fn advance(&mut self, path: &Path) -> Advance {
        let Self { problem, share, x, direction, last_step, image, upper, .. } = self;
        let (middle, upper) = (x.len() / 2, upper.ceiling());
        let clipped = share.pass(
            (&mut x[..], &direction[..], &mut last_step[..]),
            &|start, (x, direction, step)| {
                let mut clipped = false;
                for (k, (x, (z, step))) in x.iter_mut().zip(direction.iter().zip(step)).enumerate() {
                    let upper = upper.at(start + k);
                    let end = path.end(usize::from(start + k >= middle), *x, *z, upper);
                    *step = end - *x;
                    clipped |= (end == 0.0) & (*step < 0.0) | (end >= upper) & (*step > 0.0);
                    *x = end;
                }
                clipped
            },
            &|a, b| a | b,
        );
        problem.apply(last_step, image);
        let lowest = -path.slope / share.dot(last_step, image);
        Advance { length: path.length, lowest: if lowest > 0.0 { lowest } else { f64::INFINITY }, clipped }
    }

    /// Updates the gradient as well.
    fn keep(&mut self, part: f64) -> bool {
        let Self { x, gradient, last_step, image, upper, .. } = self;
        let fields = ((&mut x[..], &mut gradient[..]), (&last_step[..], &image[..]), upper.ceiling());
        for_each(fields, &|_, ((x, gradient), (step, image), upper)| {
            gradient.iter_mut().zip(image).for_each(|(g, y)| *g += part * y);
            if part < 1.0 {
                let all = x.iter_mut().zip(step).enumerate().filter(|(_, (_, s))| **s != 0.0);
                all.for_each(|(k, (x, s))| *x = (*x - (1.0 - part) * s).max(0.0).min(upper.at(k)));
            }
        });
        false
    }

    fn length_after(length: f64, lowest: f64) -> f64 {
        if lowest < DOWNHILL { length * lowest.max(1.0 / CHANGE) } else { (length * lowest).min(1.0).sqrt() }
    }
}

/// Returns true if a variable is at its upper bound. A diverging search may reach infinity, which is no bound.
fn is_full(x: f64, upper: f64) -> bool {
    x >= upper && x.is_finite()
}

/// Sums over one half for its multiplier.
#[derive(Clone, Copy)]
struct HalfSums {
    /// Sum of the gradients between the bounds, and their number.
    gradient: f64,
    between: f64,
    /// Lowest gradient at zero, and highest one at the upper bound.
    lowest: f64,
    highest: f64,
}

impl HalfSums {
    fn of(face: &Share, x: &[f64], gradient: &[f64], upper: Ceiling) -> Self {
        let none = ([0.0; 2], [f64::INFINITY; 2]);
        let least = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.min(d)];
        let ([gradient, between], [lowest, minus_highest]) = face.reduce(
            &|range| {
                range.fold(none, |(sums, ends), k| {
                    let g = gradient[k];
                    if is_full(x[k], upper.at(k)) {
                        (sums, [ends[0], ends[1].min(-g)])
                    } else if x[k] > 0.0 {
                        (add(sums, [g, 1.0]), ends)
                    } else {
                        (sums, [ends[0].min(g), ends[1]])
                    }
                })
            },
            &|a, b| (add(a.0, b.0), least(a.1, b.1)),
        );
        Self { gradient, between, lowest, highest: -minus_highest }
    }
}

/// Returns the multipliers of the two halves: the mean gradients between the bounds or, if there are none, the middle
/// of the values that the gradients at the bounds allow.
fn multipliers([first, second]: &[HalfSums; 2], means: Means) -> [f64; 2] {
    match means {
        Means::Both(_) => [first, second].map(|half| {
            let HalfSums { gradient, between, lowest, highest } = *half;
            if between == 0.0 && highest > f64::NEG_INFINITY { inside([highest, lowest]) } else { gradient / between }
        }),
        Means::Equal => {
            let between = first.between + second.between;
            let multiplier = if between > 0.0 {
                (first.gradient - second.gradient) / between
            } else if first.highest.max(second.highest) > f64::NEG_INFINITY {
                inside([first.highest.max(-second.lowest), first.lowest.min(-second.highest)])
            } else {
                0.0
            };
            [multiplier, -multiplier]
        }
    }
}

/// Returns the middle of an interval, or its end if it is open on one side.
fn inside([low, high]: [f64; 2]) -> f64 {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => 0.5 * (low + high),
        (true, false) => low,
        _ => high,
    }
}

/// Merges the sums for the residuals, and the highest gradients at the upper bounds.
fn merge(a: (OptimalitySums, f64), b: (OptimalitySums, f64)) -> (OptimalitySums, f64) {
    (OptimalitySums::merge(a.0, b.0), a.1.max(b.1))
}

/// Point of the projected path: `max(0, x − length z − shift)`, at most the upper bound, on the free variables (between
/// the bounds or with z ≠ 0). The others do not change.
#[derive(Clone, Copy)]
pub(super) struct Path {
    length: f64,
    shifts: [f64; 2],
    /// ⟨g, step⟩ at the beginning of the step.
    slope: f64,
}

/// Variables, direction and upper bounds.
type Start<'a> = (&'a [f64], &'a [f64], Ceiling<'a>);

impl Path {
    fn end(&self, half: usize, x: f64, z: f64, upper: f64) -> f64 {
        let end = x - self.length * z - self.shifts[half];
        let end = if (end > 0.0) & ((x > 0.0) | (z != 0.0)) { end } else { 0.0 };
        let end = if end < upper { end } else { upper };
        if (x >= upper) & (z == 0.0) { x } else { end }
    }

    /// Returns the sum of one half at the end of the path with a shift, and the number of its variables between the
    /// bounds.
    fn total(&self, face: &Share, (x, direction, upper): Start, shift: f64) -> [f64; 2] {
        let path = Self { shifts: [shift; 2], ..*self };
        face.reduce(
            &|range| {
                let all = range.clone().zip(x[range.clone()].iter().zip(&direction[range]));
                all.fold([0.0; 2], |sums, (k, (x, z))| {
                    let upper = upper.at(k);
                    let end = path.end(0, *x, *z, upper);
                    add(sums, [end, f64::from(u8::from((end > 0.0) & (end < upper)))])
                })
            },
            &add,
        )
    }

    /// Returns the shifts that keep the means, if they exist.
    fn kept(&self, share: &Share, means: Means, (x, direction, upper): Start) -> Option<[f64; 2]> {
        let (middle, size, face) = (x.len() / 2, upper.highest(share), share.face());
        let total = |half: usize, shift: f64| {
            let range = half * middle..(half + 1) * middle;
            self.total(&face, (&x[range.clone()], &direction[range.clone()], upper.part(range)), shift)
        };
        match means {
            Means::Both(mean) => {
                let asked = mean * face.total() as f64;
                let shift = |half: usize| {
                    root(size, &|shift| {
                        let [sum, positive] = total(half, shift);
                        [sum - asked, positive, asked]
                    })
                };
                Some([shift(0)?, shift(1)?])
            }
            Means::Equal => {
                let shift = root(size, &|shift| {
                    let ([first, in_first], [second, in_second]) = (total(0, shift), total(1, -shift));
                    [first - second, in_first + in_second, first + second]
                })?;
                Some([shift, -shift])
            }
        }
    }
}

/// Returns the zero of a decreasing function, given its value, negative slope and scale of rounding errors, by Newton's
/// method within a bracket. `size` is the highest upper bound of the variables.
fn root(size: f64, excess: &dyn Fn(f64) -> [f64; 3]) -> Option<f64> {
    let accuracy = if size.is_finite() { BOUNDED_MEAN } else { PAIR_MEAN };
    let mut shift = 0.0;
    let mut bracket = [f64::NEG_INFINITY, f64::INFINITY];
    for _ in 0..SHIFTS {
        let [value, slope, scale] = excess(shift);
        if value.abs() <= accuracy * scale {
            return Some(shift);
        }
        bracket[usize::from(value < 0.0)] = shift;
        let newton = shift + value / slope;
        let next = if bracket[0] < newton && newton < bracket[1] {
            newton
        } else if size.is_finite() {
            middle(bracket, shift, size)
        } else {
            0.5 * (bracket[0] + bracket[1])
        };
        if !next.is_finite() {
            return None;
        }
        if next == shift {
            return Some(shift);
        }
        shift = next;
    }
    Some(shift)
}

/// Scales the variables of each half below their upper bounds to remove rounding errors from the prescribed means.
fn keep_means(face: &Share, x: &mut [f64], means: Means, upper: Ceiling) {
    let points = x.len() / 2;
    let sums = [0..points, points..2 * points].map(|part| {
        if !upper.is_finite() {
            return [face.total_of(&x[part]), 0.0];
        }
        let (x, upper) = (&x[part.clone()], upper.part(part));
        let at = |k: usize| if x[k] < upper.at(k) { [x[k], 0.0] } else { [0.0, x[k]] };
        face.reduce(&|range| range.map(at).fold([0.0; 2], add), &add)
    });
    let asked = match means {
        Means::Both(mean) => mean * face.total() as f64,
        Means::Equal => 0.5 * sums.into_iter().map(|[below, at_bound]| below + at_bound).sum::<f64>(),
    };
    for (index, (half, [below, at_bound])) in halves(x).into_iter().zip(sums).enumerate() {
        let factor = (asked - at_bound) / below;
        let upper = upper.part(index * points..(index + 1) * points);
        if factor >= 0.0 && factor.is_finite() && factor != 1.0 {
            for_each((half, upper), &|_, (x, upper)| {
                for (k, x) in x.iter_mut().enumerate() {
                    *x = if *x < upper.at(k) { (factor * *x).min(upper.at(k)) } else { *x };
                }
            });
        }
    }
}

fn halves<T>(x: &mut [T]) -> [&mut [T]; 2] {
    let (first, second) = x.split_at_mut(x.len() / 2);
    [first, second]
}
