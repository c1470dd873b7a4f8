use gfmd_vector::{Share, Split};

use crate::{Upper, Visit};

/// Number of variables in a block of [`Preconditioned::mark`].
pub const BLOCK: usize = 64;

/// Convex quadratic function ½⟨x, A x⟩ + ⟨b, x⟩ of variables between zero and upper bounds, for
/// [`PreconditionedCg`](crate::PreconditionedCg). A is symmetric and positive (semi-)definite, and has a
/// preconditioner.
///
/// Steps and gradients have single precision, in their own units: steps in U, gradients in U times
/// [`unit`](Self::unit). Only [`gradient`](Self::gradient) works in double precision. Vectors are passed in stretches,
/// so operations on them need no separate sweep over memory.
pub trait Preconditioned {
    /// Returns the number of variables of this process.
    fn length(&self) -> usize;

    /// Returns the partition of the variables among processes, with stretches as rows; by default this process has all.
    /// Vectors, bounds and stretches are local, sums are global, and all processes make the same calls.
    fn share(&self) -> Share {
        Share::whole(self.length() / self.stretch(), self.stretch())
    }

    /// Returns the upper bounds of the variables, infinite by default.
    fn upper(&self) -> Upper {
        Upper::All(f64::INFINITY)
    }

    /// Returns the number of variables in a stretch, a divisor of the number of variables.
    fn stretch(&self) -> usize;

    /// Returns the magnitude of A. Single precision can represent the entries of A divided by it.
    fn unit(&self) -> f64;

    /// Computes the gradient A x + b and passes each of its stretches to `sink`, with the stretch of `output`. The
    /// results are stored in `sums`, one per stretch.
    fn gradient<O: Split, R: Send>(
        &mut self,
        x: &[f64],
        output: O,
        sink: impl Fn(&[f64], O) -> R + Sync,
        sums: &mut [R],
    );

    /// Computes A v / [`unit`](Self::unit) in single precision, for the vector v that `source` generates stretch by
    /// stretch from `input`.
    fn image<I: Split>(&mut self, input: I, source: impl Fn(I, &mut [f32]) + Sync);

    /// Passes the stretches of the last [`image`](Self::image) to `sink`, like [`gradient`](Self::gradient).
    fn collect<O: Split, R: Send>(&mut self, output: O, sink: impl Fn(&[f32], O) -> R + Sync, sums: &mut [R]);

    /// Returns ⟨d, A d⟩ / [`unit`](Self::unit), summed over all variables.
    fn curvature(&mut self, direction: &[f32]) -> f64;

    /// Writes `M (gradient − level)` into `out` on the free variables, and zero elsewhere. This is nearly the step to
    /// the point where their gradient equals the level. Variables are free between the bounds, or at a bound if their
    /// gradient pulls them off. M depends on the free set; it is symmetric positive definite and approximates A⁻¹ on
    /// this set, times [`unit`](Self::unit). Overestimating A⁻¹ is safer than underestimating it.
    fn precondition(&mut self, x: &[f64], gradient: &[f32], level: f32, out: &mut [f32]);

    /// Marks the blocks of [`BLOCK`] variables in which x or `out` of the last [`precondition`](Self::precondition) may
    /// differ from zero. Returns false and marks none if they are unknown, which is the default.
    fn mark(&self, blocks: &mut [bool]) -> bool {
        let _ = blocks;
        false
    }

    /// Returns true if a search may end with a gradient from images, which has single-precision errors. The caller then
    /// recomputes what it needs in double precision.
    fn trusts_images(&self) -> bool {
        false
    }

    /// Visits the variables that the problem itself changes during a search, for example an effort counter.
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let _ = visitor;
    }
}
