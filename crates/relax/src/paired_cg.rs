use gfmd_vector::{Share, add, for_each, pass, reduce, sum};

use crate::quadratic::{Iterate, Judged, LEAST_DESCENT, Minimum};
use crate::{Ending, RelaxError, Target, Upper, Visit, Watch, Why};

/// A convex quadratic function ½⟨x, A x⟩ + ⟨b, x⟩ of non-negative variables that form two halves of one vector, for
/// [`PairedCg`]. A is symmetric and positive semi-definite, and has a preconditioner.
pub trait Paired {
    /// b, one value for each variable; the number of variables is even.
    fn linear(&self) -> &[f64];

    /// `out ← A x`.
    fn apply(&mut self, x: &[f64], out: &mut [f64]);

    /// `out ← M gradient` on the free variables, zero elsewhere: approximately the step to the point where the gradient of the
    /// free variables vanishes. Variables are free if they are positive, or if they are zero and their gradient is negative. M
    /// depends on the free set; it is symmetric positive (semi-)definite and approximates A⁻¹ on this set.
    fn precondition(&mut self, x: &[f64], gradient: &[f64], out: &mut [f64]);

    /// Visits the variables that the problem itself changes during a search, such as a counter of its effort.
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let _ = visitor;
    }
}

/// Projected conjugate gradients for two halves of variables that are coupled by A and by their means, with a preconditioner
/// close to the inverse of A on the free variables ([`Paired`]).
///
/// Each half has the prescribed mean of the [`Target`], and the gradient is determined up to a constant on each half. Without a
/// prescribed mean the two means are equal, and it is determined up to a constant with opposite signs on the two halves.
///
/// The steps are those of [`PreconditionedCg`](crate::PreconditionedCg), in double precision: x goes to `max(0, x − z − μ)`
/// with a constant μ for each half that keeps the means, and back to the minimum on this segment if that lies inside of it.
/// Directions are made conjugate to the last step as long as no variable reaches zero. Every 25th direction, and any that the
/// projection turns uphill, is the gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairedCg;

/// Number of directions of which one is the gradient.
const PLAIN: u64 = 25;

/// A step that brings variables to zero is kept if at least this fraction of it was downhill.
const DOWNHILL: f64 = 0.5;

/// Largest factor by which the length changes from one step to the next.
const CHANGE: f64 = 10.0;

/// Largest number of times that a step is halved until it begins downhill.
const HALVINGS: usize = 30;

/// Relative accuracy of the means along a path; scaling then makes them exact.
const MEAN: f64 = 1e-14;

/// Largest number of steps of the search for μ.
const SHIFTS: usize = 200;

impl PairedCg {
    /// Minimises from the start `x`, in place; `watch` sees every iterate, with the multiplier of the first half.
    ///
    /// # Errors
    /// An invalid start or target. A search without success is not an error but an [`Ending`].
    pub fn minimise(
        &self,
        problem: &mut impl Paired,
        x: &mut [f64],
        target: &Target,
        watch: &mut dyn Watch,
    ) -> Result<Minimum, RelaxError> {
        let &Target { mean, gradient_scale, budget } = target;
        let share = Share::whole(problem.linear().len(), 1);
        target.check_between(x, &share, &Upper::All(f64::INFINITY))?;
        let even = x.len().is_multiple_of(2);
        RelaxError::check_parameter("the number of variables", x.len() as f64, even, "even")?;
        let mut search = Search::new(x.len(), mean.map_or(Means::Equal, Means::Both));
        search.refresh(problem, x);
        if let Some(kept) = watch.recall() {
            search.visit(problem, x, kept);
        }
        loop {
            watch.checkpoint(&mut |visitor| search.visit(problem, x, visitor));
            let mut now = search.settle(x, gradient_scale);
            if !search.is_fresh && now.optimality.worst() <= budget.tolerance {
                search.refresh(problem, x);
                now = search.settle(x, gradient_scale);
            }
            if let Some(ending) = target.judge(&now, watch, &share) {
                return Ok(Minimum { reached: now, ending });
            }
            if search.step(problem, x) {
                continue;
            } else if search.is_fresh {
                return Ok(Minimum { reached: now, ending: Ending::GaveUp(Why::NoDescent) });
            }
            search.refresh(problem, x);
        }
    }
}

/// The constraint on the means of the two halves.
#[derive(Clone, Copy)]
enum Means {
    /// Both are this number.
    Both(f64),
    /// They are equal.
    Equal,
}

/// The state of a search.
struct Search {
    means: Means,
    /// The gradient less the multiplier of each half.
    gradient: Vec<f64>,
    direction: Vec<f64>,
    last_step: Vec<f64>,
    /// The image of the last step.
    image: Vec<f64>,
    length: f64,
    settled: bool,
    iteration: u64,
    /// True if the gradient was computed from x.
    is_fresh: bool,
}

impl Search {
    fn new(variables: usize, means: Means) -> Self {
        Self {
            means,
            gradient: vec![0.0; variables],
            direction: vec![0.0; variables],
            last_step: vec![0.0; variables],
            image: vec![0.0; variables],
            length: 1.0,
            settled: false,
            iteration: 0,
            is_fresh: false,
        }
    }

    fn visit(&mut self, problem: &mut impl Paired, x: &mut [f64], visitor: &mut dyn Visit) {
        visitor.field(x);
        for field in [&mut self.gradient, &mut self.last_step, &mut self.image] {
            visitor.field(field);
        }
        visitor.number(&mut self.length);
        visitor.flag(&mut self.settled);
        visitor.flag(&mut self.is_fresh);
        visitor.count(&mut self.iteration);
        problem.visit(visitor);
    }

    /// Makes the means exact, and computes the gradient from x.
    fn refresh(&mut self, problem: &mut impl Paired, x: &mut [f64]) {
        keep_means(x, self.means);
        problem.apply(x, &mut self.gradient);
        let linear = problem.linear();
        for_each([&mut self.gradient[..]], &|start, [g]| {
            g.iter_mut().zip(&linear[start..]).for_each(|(g, b)| *g += b);
        });
        self.is_fresh = true;
    }

    /// Subtracts the multipliers from the gradient.
    fn settle(&mut self, x: &[f64], scale: f64) -> Iterate {
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
                let mut judged = Judged::EMPTY;
                for (g, x) in gradient.iter_mut().zip(&x[start..]) {
                    *g -= multiplier;
                    judged.see(*x, *g);
                }
                judged
            };
            pass([gradient], &leaf, &Judged::merge)
        });
        let judged = judged.fold(Judged::EMPTY, Judged::merge);
        let optimality = judged.optimality(scale);
        let positive = (in_first + in_second) as usize;
        Iterate { iteration: self.iteration, optimality, multiplier: multipliers[0], positive }
    }

    /// Takes one step; false if none begins downhill.
    fn step(&mut self, problem: &mut impl Paired, x: &mut [f64]) -> bool {
        let mut path = None;
        if self.iteration % PLAIN != PLAIN - 1 {
            problem.precondition(x, &self.gradient, &mut self.direction);
            if self.settled {
                self.conjugate();
            }
            path = self.downhill(x, self.length);
        }
        let preconditioned = path.is_some();
        if path.is_none() {
            let squares = self.steepest(x);
            problem.apply(&self.direction, &mut self.image);
            path = self.downhill(x, squares / gfmd_vector::dot(&self.direction, &self.image));
        }
        let Some(path) = path else { return false };

        self.settled = !self.advance(x, &path);
        problem.apply(&self.last_step, &mut self.image);
        let lowest = -path.slope / gfmd_vector::dot(&self.last_step, &self.image);
        let lowest = if lowest > 0.0 { lowest } else { f64::INFINITY };
        if preconditioned {
            self.length = match lowest {
                _ if self.settled => (path.length * lowest.min(CHANGE)).max(1.0),
                ..DOWNHILL => path.length * lowest.max(1.0 / CHANGE),
                _ => (path.length * lowest).min(1.0).sqrt(),
            };
        }
        let part = if lowest < if self.settled { 1.0 } else { DOWNHILL } { lowest } else { 1.0 };
        let Self { gradient, last_step, image, .. } = self;
        for_each((&mut x[..], &mut gradient[..], &last_step[..], &image[..]), &|_, (x, gradient, step, image)| {
            gradient.iter_mut().zip(image).for_each(|(g, y)| *g += part * y);
            if part < 1.0 {
                let all = x.iter_mut().zip(step).filter(|(_, s)| **s != 0.0);
                all.for_each(|(x, s)| *x = (*x - (1.0 - part) * s).max(0.0));
            }
        });
        self.is_fresh = false;
        self.iteration += 1;
        true
    }

    /// x ← the end of the path. Returns true if this brings variables to zero.
    fn advance(&mut self, x: &mut [f64], path: &Path) -> bool {
        let middle = x.len() / 2;
        pass(
            (&mut x[..], &self.direction[..], &mut self.last_step[..]),
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
        )
    }

    /// z ← z − β s with β such that z is conjugate to s, on the free variables, where z ≠ 0.
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

    /// z ← g on the free variables, zero elsewhere. Returns ⟨z, z⟩.
    fn steepest(&mut self, x: &[f64]) -> f64 {
        pass(
            (&mut self.direction[..], x, &self.gradient[..]),
            &|_, (z, x, gradient)| {
                let mut squares = 0.0;
                for ((z, x), g) in z.iter_mut().zip(x).zip(gradient) {
                    *z = if *x > 0.0 || *g < 0.0 { *g } else { 0.0 };
                    squares += *z * *z;
                }
                squares
            },
            &|a, b| a + b,
        )
    }

    /// The point of the path at `length`, halved until the step to it begins downhill.
    fn downhill(&self, x: &[f64], length: f64) -> Option<Path> {
        let Self { direction, gradient, means, .. } = self;
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
}

/// A point of the projected path: `max(0, x − length z − shift)` on the free variables, those that are positive or have z ≠ 0;
/// the others stay.
#[derive(Clone, Copy)]
struct Path {
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

    /// The sum of one half at its end with a shift, and the number of its positive variables.
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

    /// The shifts that keep the means, if there are any.
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

/// The shift at which a decreasing function vanishes, from its value, its slope with the opposite sign, and the scale of its
/// rounding errors: Newton's method within a bracket.
fn root(excess: &dyn Fn(f64) -> [f64; 3]) -> Option<f64> {
    let mut shift = 0.0;
    let mut bracket = [f64::NEG_INFINITY, f64::INFINITY];
    for _ in 0..SHIFTS {
        let [value, slope, scale] = excess(shift);
        if value.abs() <= MEAN * scale {
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

/// Scales the halves to the means that they must have, from which they differ by rounding errors.
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
