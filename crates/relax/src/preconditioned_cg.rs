mod active;
mod constants;
mod pair;
mod path;
mod single;
mod sums;

use constants::{CHANGE, DOWNHILL, PLAIN, STALLED};
use gfmd_vector::Share;
pub use pair::Paired;

use crate::quadratic::{Iterate, Minimum, Target};
use crate::{Ending, Preconditioned, RelaxError, Visit, Watch, Why};

/// Projected conjugate gradients with a preconditioner M close to the inverse of A on the free variables
/// ([`Preconditioned`]). An iteration needs one image and one preconditioning.
///
/// Since z = M g is nearly the Newton step, the step length is 1. M should not be smaller than the inverse of A, or
/// steps are too short. x goes to `max(0, x − z − μ)`, with μ such that the prescribed mean is kept. The image of the
/// step gives the new gradient. Both gradients determine the function along the segment from the old x to the new x, a
/// parabola. If its minimum lies inside the segment, x steps back to it without another image. The function thus
/// decreases in every iteration, and no curvature has to be computed.
///
/// While no variable reaches zero, these are exact line searches, and directions are made conjugate to the last step.
/// If variables reach zero, a step that lowers the function is kept as a whole, since stepping back would make them
/// positive again. The next step then has the optimal length of this one (Barzilai and Borwein 1988), but at most 1:
/// with a constant length, steps may overshoot repeatedly where M is too large.
///
/// Every 25th direction, and any direction that the projection turns uphill, is the gradient. Projected gradients with
/// steps that lower the function converge for any steps in between (Bertsekas 1976).
///
/// The variables have double precision. Steps, images and the gradient updated with them have single precision, which
/// halves their memory and nearly halves the time of a transform. Whenever the residual has fallen to 1e-4 of its last
/// exact value, and before the search ends (unless the problem [trusts images](Preconditioned::trusts_images)), the
/// gradient is recomputed from x in double precision. Rounding errors are then relative to a smaller gradient and
/// smaller steps, so no accuracy is lost (Sleijpen and van der Vorst 1996).
///
/// [`minimise_pair`](Self::minimise_pair) takes the same steps for two fields that are coupled by A and by their means,
/// with all vectors in double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PreconditionedCg;

impl PreconditionedCg {
    /// Minimises from the start `x`, in place; `watch` sees every iterate.
    ///
    /// # Errors
    /// Returns an error if the start or the target is invalid. An unsuccessful search is an [`Ending`], not an error.
    pub fn minimise<P: Preconditioned>(
        &self,
        problem: &mut P,
        x: &mut [f64],
        target: &Target,
        watch: &mut dyn Watch,
    ) -> Result<Minimum, RelaxError> {
        let share = problem.share();
        target.check_between(x, &share, &problem.upper())?;
        Ok(search(single::Single::new(problem, x, target), target, &share, watch))
    }

    /// Minimises a function of two fields, the halves of `x`, from the start `x` and in place.
    ///
    /// Each field has the prescribed mean of the [`Target`]. The gradient is determined up to a constant on each field;
    /// the constant of the first field is the multiplier of the [`Iterate`]. Without a prescribed mean, the two means
    /// are equal, and the gradient is determined up to a constant with opposite signs on the two fields. A step goes to
    /// `max(0, x − z − μ)`, at most the upper bound, with a constant μ for each field that keeps the means.
    ///
    /// # Errors
    /// Returns the errors of [`minimise`](Self::minimise), and an error if the number of variables is odd.
    pub fn minimise_pair(
        &self,
        problem: &mut impl Paired,
        x: &mut [f64],
        target: &Target,
        watch: &mut dyn Watch,
    ) -> Result<Minimum, RelaxError> {
        let even = x.len().is_multiple_of(2);
        RelaxError::check_parameter("the number of variables", x.len() as f64, even, "even")?;
        let share = problem.share();
        target.check_between(x, &share, &problem.upper())?;
        Ok(search(pair::Pair::new(problem, x, target), target, &share, watch))
    }
}

/// Problem with the vectors of its search and the operations on them.
trait Vectors {
    /// Point of the projected path along a direction.
    type Path;

    /// Returns the residual factor at which the gradient is recomputed; 0 means only at the end of the search.
    fn refresh_at() -> f64;

    /// Visits all variables, including the `course`.
    fn visit(&mut self, course: &mut Course, visitor: &mut dyn Visit);

    /// Computes the gradient from x.
    fn refresh(&mut self);

    /// Returns true if rounding errors of the gradient exceed the tolerance, because it was computed for another
    /// multiplier, as at the start of a search.
    fn is_coarse(&self) -> bool {
        false
    }

    /// Sets the multipliers to the mean gradients of the variables between the bounds. Does not count the iteration.
    fn settle(&mut self) -> Iterate;

    /// Returns true if a search may end with a gradient from images.
    fn trusts_images(&self) -> bool {
        false
    }

    /// Sets z ← M g; if `settled`, makes z conjugate to the last step.
    fn turn(&mut self, settled: bool);

    /// Sets z ← g on the free variables, zero elsewhere. Returns the exact step length.
    fn steepest(&mut self) -> f64;

    /// Returns the point of the path at `length`, shortened until the step begins downhill.
    fn downhill(&self, length: f64) -> Option<Self::Path>;

    /// Moves x to the end of the path and computes the image of the step.
    fn advance(&mut self, path: &Self::Path) -> Advance;

    /// Keeps the fraction `part` of the last step, all of it at 1 or above. Returns true if the gradient was
    /// recomputed.
    fn keep(&mut self, part: f64) -> bool;

    /// Returns the length after a step that brought variables to a bound, with `lowest` as in [`Advance`].
    fn length_after(length: f64, lowest: f64) -> f64;
}

/// Step to the end of a path.
struct Advance {
    length: f64,
    /// Fraction of the step at which the function is lowest; infinite if it falls without bound.
    lowest: f64,
    /// True if the step brought variables to a bound.
    clipped: bool,
}

/// Scalar variables of a search.
struct Course {
    length: f64,
    /// Residual at the last refresh.
    reference: f64,
    /// Smallest residual since then, and the number of iterations since it was reached.
    least: f64,
    stalled: u64,
    /// True if the last step brought no variable to a bound.
    settled: bool,
    /// True if the gradient was computed from x.
    is_fresh: bool,
    iteration: u64,
}

impl Course {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.numbers(&mut [&mut self.length, &mut self.reference, &mut self.least]);
        visitor.flag(&mut self.settled);
        visitor.flag(&mut self.is_fresh);
        visitor.count(&mut self.stalled);
        visitor.count(&mut self.iteration);
    }

    /// Records the residual of an iterate. Returns true if it has stalled, possibly by rounding errors of the images.
    fn stalls<V: Vectors>(&mut self, worst: f64) -> bool {
        if worst < self.least {
            (self.least, self.stalled) = (worst, 0);
        } else {
            self.stalled += 1;
        }
        self.stalled >= STALLED && worst <= V::refresh_at()
    }

    /// Takes one step. Returns false if no step begins downhill.
    fn step<V: Vectors>(&mut self, vectors: &mut V) -> bool {
        let mut path = None;
        if self.iteration % PLAIN != PLAIN - 1 {
            vectors.turn(self.settled);
            path = vectors.downhill(self.length);
        }
        let preconditioned = path.is_some();
        if path.is_none() {
            let length = vectors.steepest();
            path = vectors.downhill(length);
        }
        let Some(path) = path else { return false };

        let Advance { length, lowest, clipped } = vectors.advance(&path);
        self.settled = !clipped;
        if preconditioned {
            self.length =
                if self.settled { (length * lowest.min(CHANGE)).max(1.0) } else { V::length_after(length, lowest) };
        }
        let enough = if self.settled { 1.0 } else { DOWNHILL };
        self.is_fresh = vectors.keep(if lowest < enough { lowest } else { 1.0 });
        self.iteration += 1;
        true
    }
}

fn search<V: Vectors>(mut vectors: V, target: &Target, share: &Share, watch: &mut dyn Watch) -> Minimum {
    let mut course = Course {
        length: 1.0,
        reference: f64::INFINITY,
        least: f64::INFINITY,
        stalled: 0,
        settled: false,
        is_fresh: true,
        iteration: 0,
    };
    vectors.refresh();
    if let Some(kept) = watch.recall() {
        vectors.visit(&mut course, kept);
    }
    let tolerance = target.budget.tolerance;
    loop {
        watch.checkpoint(&mut |visitor| vectors.visit(&mut course, visitor));
        let mut now = vectors.settle();
        let worst = now.optimality.worst();
        let is_over = vectors.trusts_images() && worst <= tolerance;
        let is_due = course.stalls::<V>(worst) || worst <= tolerance.max(V::refresh_at() * course.reference);
        if !(course.is_fresh || is_over) && is_due {
            vectors.refresh();
            course.is_fresh = true;
            now = vectors.settle();
        }
        if course.is_fresh {
            course.reference = now.optimality.worst();
            (course.least, course.stalled) = (course.reference, 0);
        }
        now.iteration = course.iteration;
        if let Some(ending) = target.judge(&now, watch, share) {
            return Minimum { reached: now, ending };
        }
        if course.step(&mut vectors) {
            continue;
        } else if course.is_fresh && !vectors.is_coarse() {
            return Minimum { reached: now, ending: Ending::GaveUp(Why::NoDescent) };
        }
        vectors.refresh();
        course.is_fresh = true;
    }
}
