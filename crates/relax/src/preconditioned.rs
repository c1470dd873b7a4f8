use gfmd_vector::{Share, Split};

use crate::{Upper, Visit};

/// The number of variables in a block of [`Preconditioned::mark`].
pub const BLOCK: usize = 64;

/// A convex quadratic function ½⟨x, A x⟩ + ⟨b, x⟩ of variables between zero and upper bounds, for
/// [`PreconditionedCg`](crate::PreconditionedCg). A is symmetric and positive (semi-)definite, and has a
/// preconditioner.
///
/// Steps and gradients have single precision, in their own units: steps in U, gradients in U times
/// [`unit`](Self::unit). Only [`gradient`](Self::gradient) works in double precision. Vectors are passed in stretches,
/// so that operations on them need no separate sweep over memory.
pub trait Preconditioned {
    /// The number of variables of this process.
    fn length(&self) -> usize;

    /// The partition of the variables among processes, with stretches as rows; by default this process has all.
    /// Vectors, bounds and stretches belong to this process, sums to all, and every process makes the same calls.
    fn share(&self) -> Share {
        Share::whole(self.length() / self.stretch(), self.stretch())
    }

    /// The largest values of the variables, infinite by default.
    fn upper(&self) -> Upper {
        Upper::All(f64::INFINITY)
    }

    /// The number of variables in a stretch; it divides the number of variables.
    fn stretch(&self) -> usize;

    /// The magnitude of A, so that A divided by it has entries that single precision can represent.
    fn unit(&self) -> f64;

    /// Computes the gradient A x + b and passes each stretch of it to `sink`, with the stretch of `output`; the result
    /// goes to `sums`, which has one entry for each stretch.
    fn gradient<O: Split, R: Send>(
        &mut self,
        x: &[f64],
        output: O,
        sink: impl Fn(&[f64], O) -> R + Sync,
        sums: &mut [R],
    );

    /// Computes A v / [`unit`](Self::unit) in single precision, for the vector v whose stretches `source` generates
    /// from those of `input`.
    fn image<I: Split>(&mut self, input: I, source: impl Fn(I, &mut [f32]) + Sync);

    /// Passes the stretches of the last [`image`](Self::image) to `sink`, like [`gradient`](Self::gradient).
    fn collect<O: Split, R: Send>(&mut self, output: O, sink: impl Fn(&[f32], O) -> R + Sync, sums: &mut [R]);

    /// ⟨d, A d⟩ / [`unit`](Self::unit), the sum over all variables.
    fn curvature(&mut self, direction: &[f32]) -> f64;

    /// `out ← M (gradient − level)` on the free variables, zero elsewhere: approximately the step to the point where
    /// the gradient of the free variables equals the level. Variables are free between the bounds, or at a bound from
    /// which their gradient pulls them off. M depends on the free set; it is symmetric positive definite and
    /// approximates A⁻¹ on this set, times [`unit`](Self::unit). Overestimating A⁻¹ is safer than underestimating it.
    fn precondition(&mut self, x: &[f64], gradient: &[f32], level: f32, out: &mut [f32]);

    /// Marks the blocks of [`BLOCK`] variables in which x or `out` of the last [`precondition`](Self::precondition) may
    /// differ from zero; returns false and marks none if they are unknown, as by default.
    fn mark(&self, blocks: &mut [bool]) -> bool {
        let _ = blocks;
        false
    }

    /// True if a search may end with a gradient from images, which has errors of single precision; the caller then
    /// recomputes what it needs in double precision.
    fn trusts_images(&self) -> bool {
        false
    }

    /// Visits the variables that the problem itself changes during a search, such as a counter of its effort.
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let _ = visitor;
    }
}
