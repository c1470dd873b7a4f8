//! Two fields coupled by the function and by their means, in double precision.

use gfmd_vector::{Share, add, for_each, pass, reduce, sum};

use super::constants::{CHANGE, DOWNHILL, HALVINGS, PAIR_MEAN, SHIFTS};
use super::{Advance, Course, Vectors};
use crate::Visit;
use crate::quadratic::{Iterate, LEAST_DESCENT, OptimalitySums, Target, add_linear, turn};

/// Convex quadratic function ½⟨x, A x⟩ + ⟨b, x⟩ of the non-negative variables of two fields, the halves of one vector,
/// for [`PreconditionedCg::minimise_pair`](crate::PreconditionedCg::minimise_pair). A is symmetric and positive
/// semi-definite, and has a preconditioner.
pub trait Paired {
    /// Returns b, one value for each variable; the number of variables is even.
    fn linear(&self) -> &[f64];

    /// Writes `A x` into `out`.
    fn apply(&mut self, x: &[f64], out: &mut [f64]);

    /// Writes `M gradient` into `out` on the free variables, and zero elsewhere. This is approximately the step to the
    /// point where the gradient of the free variables vanishes. Variables are free if positive, or if zero with a
    /// negative gradient. M depends on the free set; it is symmetric positive (semi-)definite and approximates A⁻¹ on
    /// this set.
    fn precondition(&mut self, x: &[f64], gradient: &[f64], out: &mut [f64]);

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
    x: &'a mut [f64],
    means: Means,
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
        Self { problem, x, means, scale: target.gradient_scale, gradient, direction, last_step, image }
    }

    /// Subtracts β s from z, with β such that z is conjugate to s, where z ≠ 0 (free variables).
    fn conjugate(&mut self) {
        let Self { gradient, direction, last_step, image, .. } = self;
        let [z_image, s_image, z_gradient, s_gradient] = reduce(
            direction.len(),
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
        visitor.field(self.x);
        for field in [&mut self.gradient, &mut self.last_step, &mut self.image] {
            visitor.field(field);
        }
        course.visit(visitor);
        self.problem.visit(visitor);
    }

    /// Rescales the means first, so that they are exact.
    fn refresh(&mut self) {
        keep_means(self.x, self.means);
        self.problem.apply(self.x, &mut self.gradient);
        add_linear(&Share::whole(self.x.len(), 1), self.problem.linear(), self.x, &mut self.gradient);
    }

    /// Subtracts the multipliers from the gradient.
    fn settle(&mut self) -> Iterate {
        let x = &*self.x;
        let of_half = |x: &[f64], gradient: &[f64]| {
            reduce(
                x.len(),
                &|range| {
                    let all = x[range.clone()].iter().zip(&gradient[range]);
                    all.filter(|(x, _)| **x > 0.0).fold([0.0; 2], |sums, (_, g)| add(sums, [*g, 1.0]))
                },
                &add,
            )
        };
        let middle = x.len() / 2;
        let [[first, in_first], [second, in_second]] =
            [of_half(&x[..middle], &self.gradient[..middle]), of_half(&x[middle..], &self.gradient[middle..])];
        let multipliers = match self.means {
            Means::Both(_) => [first / in_first, second / in_second],
            Means::Equal if in_first + in_second == 0.0 => [0.0; 2],
            Means::Equal => [1.0, -1.0].map(|sign| sign * (first - second) / (in_first + in_second)),
        };
        let judged = halves(&mut self.gradient).into_iter().zip(x.chunks(middle)).zip(multipliers);
        let judged = judged.map(|((gradient, x), multiplier)| {
            let leaf = |start: usize, [gradient]: [&mut [f64]; 1]| {
                let mut judged = OptimalitySums::EMPTY;
                for (g, x) in gradient.iter_mut().zip(&x[start..]) {
                    *g -= multiplier;
                    judged.see(*x, *g);
                }
                judged
            };
            pass([gradient], &leaf, &OptimalitySums::merge)
        });
        let judged = judged.fold(OptimalitySums::EMPTY, OptimalitySums::merge);
        let optimality = judged.optimality(self.scale);
        Iterate { iteration: 0, optimality, multiplier: multipliers[0], positive: (in_first + in_second) as usize }
    }

    fn turn(&mut self, settled: bool) {
        self.problem.precondition(self.x, &self.gradient, &mut self.direction);
        if settled {
            self.conjugate();
        }
    }

    fn steepest(&mut self) -> f64 {
        let Self { problem, x, gradient, direction, image, .. } = self;
        // The preconditioner may have left values that are not finite.
        direction.fill(0.0);
        let squares = turn(&Share::whole(x.len(), 1), direction, x, gradient, 0.0, 0.0, &|x, g| x > 0.0 || g < 0.0);
        problem.apply(direction, image);
        squares / gfmd_vector::dot(direction, image)
    }

    fn downhill(&self, length: f64) -> Option<Path> {
        let Self { x, direction, gradient, means, .. } = self;
        let middle = x.len() / 2;
        let mut path = Path { length, shifts: [0.0; 2], slope: 0.0 };
        for _ in 0..HALVINGS {
            path.shifts =
                path.kept(*means, [&x[..middle], &x[middle..]], [&direction[..middle], &direction[middle..]])?;
            path.slope = sum(x.len(), &|range| {
                let term = |k: usize| gradient[k] * (path.end(usize::from(k >= middle), x[k], direction[k]) - x[k]);
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
        let Self { problem, x, direction, last_step, image, .. } = self;
        let middle = x.len() / 2;
        let clipped = pass(
            (&mut x[..], &direction[..], &mut last_step[..]),
            &|start, (x, direction, step)| {
                let mut clipped = false;
                for (k, (x, (z, step))) in x.iter_mut().zip(direction.iter().zip(step)).enumerate() {
                    let end = path.end(usize::from(start + k >= middle), *x, *z);
                    *step = end - *x;
                    clipped |= (end == 0.0) & (*step < 0.0);
                    *x = end;
                }
                clipped
            },
            &|a, b| a | b,
        );
        problem.apply(last_step, image);
        let lowest = -path.slope / gfmd_vector::dot(last_step, image);
        Advance { length: path.length, lowest: if lowest > 0.0 { lowest } else { f64::INFINITY }, clipped }
    }

    /// Updates the gradient as well.
    fn keep(&mut self, part: f64) -> bool {
        let Self { x, gradient, last_step, image, .. } = self;
        for_each((&mut x[..], &mut gradient[..], &last_step[..], &image[..]), &|_, (x, gradient, step, image)| {
            gradient.iter_mut().zip(image).for_each(|(g, y)| *g += part * y);
            if part < 1.0 {
                let all = x.iter_mut().zip(step).filter(|(_, s)| **s != 0.0);
                all.for_each(|(x, s)| *x = (*x - (1.0 - part) * s).max(0.0));
            }
        });
        false
    }

    fn length_after(length: f64, lowest: f64) -> f64 {
        if lowest < DOWNHILL { length * lowest.max(1.0 / CHANGE) } else { (length * lowest).min(1.0).sqrt() }
    }
}

/// Point of the projected path: `max(0, x − length z − shift)` on the free variables (positive or with z ≠ 0). The
/// others do not change.
#[derive(Clone, Copy)]
pub(super) struct Path {
    length: f64,
    shifts: [f64; 2],
    /// ⟨g, step⟩ at the beginning of the step.
    slope: f64,
}

impl Path {
    fn end(&self, half: usize, x: f64, z: f64) -> f64 {
        let end = x - self.length * z - self.shifts[half];
        if (end > 0.0) & ((x > 0.0) | (z != 0.0)) { end } else { 0.0 }
    }

    /// Returns the sum of one half at the end of the path with a shift, and the number of its positive variables.
    fn total(&self, x: &[f64], direction: &[f64], shift: f64) -> [f64; 2] {
        let path = Self { shifts: [shift; 2], ..*self };
        reduce(
            x.len(),
            &|range| {
                let all = x[range.clone()].iter().zip(&direction[range]);
                all.fold([0.0; 2], |sums, (x, z)| {
                    let end = path.end(0, *x, *z);
                    add(sums, [end, f64::from(u8::from(end > 0.0))])
                })
            },
            &add,
        )
    }

    /// Returns the shifts that keep the means, if they exist.
    fn kept(&self, means: Means, x: [&[f64]; 2], direction: [&[f64]; 2]) -> Option<[f64; 2]> {
        let total = |half: usize, shift: f64| self.total(x[half], direction[half], shift);
        match means {
            Means::Both(mean) => {
                let asked = mean * x[0].len() as f64;
                let shift = |half: usize| {
                    root(&|shift| {
                        let [sum, positive] = total(half, shift);
                        [sum - asked, positive, asked]
                    })
                };
                Some([shift(0)?, shift(1)?])
            }
            Means::Equal => {
                let shift = root(&|shift| {
                    let ([first, in_first], [second, in_second]) = (total(0, shift), total(1, -shift));
                    [first - second, in_first + in_second, first + second]
                })?;
                Some([shift, -shift])
            }
        }
    }
}

/// Returns the zero of a decreasing function, given its value, negative slope and scale of rounding errors, by Newton's
/// method within a bracket.
fn root(excess: &dyn Fn(f64) -> [f64; 3]) -> Option<f64> {
    let mut shift = 0.0;
    let mut bracket = [f64::NEG_INFINITY, f64::INFINITY];
    for _ in 0..SHIFTS {
        let [value, slope, scale] = excess(shift);
        if value.abs() <= PAIR_MEAN * scale {
            return Some(shift);
        }
        bracket[usize::from(value < 0.0)] = shift;
        let newton = shift + value / slope;
        let next = if bracket[0] < newton && newton < bracket[1] { newton } else { 0.5 * (bracket[0] + bracket[1]) };
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

/// Scales the halves to remove rounding errors from the prescribed means.
fn keep_means(x: &mut [f64], means: Means) {
    let points = x.len() / 2;
    let [first, second] = [&x[..points], &x[points..]].map(gfmd_vector::total);
    let asked = match means {
        Means::Both(mean) => mean * points as f64,
        Means::Equal => 0.5 * (first + second),
    };
    for (half, sum) in halves(x).into_iter().zip([first, second]) {
        let factor = asked / sum;
        if factor.is_finite() && factor != 1.0 {
            for_each([half], &|_, [x]| x.iter_mut().for_each(|x| *x *= factor));
        }
    }
}

fn halves<T>(x: &mut [T]) -> [&mut [T]; 2] {
    let (first, second) = x.split_at_mut(x.len() / 2);
    [first, second]
}
