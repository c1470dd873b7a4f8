//! What a relaxation method may ask of a problem.

use crate::Bounds;

/// An energy U(u) to minimise over the u that [`Landscape::bounds`] allows.
///
/// The methods call each function once per step with whole vectors, so `dyn` costs nothing. The unit of `force` is that
/// of U over that of u; the mass is 1, so that a stiffness (second derivative of U) is a squared frequency.
pub trait Landscape {
    /// Number of entries of u.
    fn len(&self) -> usize;

    /// Whether there is nothing to minimise.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes −∂U/∂u into `force` and returns U. The one expensive call: methods make it once per step.
    ///
    /// A hard wall is not part of it: that is a constraint, not a force (theory.md, section 6.5).
    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64;

    /// The allowed values of u. They stay the same while a relaxation runs; after a change, start a new
    /// [`State`](crate::State) from the old u.
    fn bounds(&self) -> Bounds<'_> {
        Bounds::Free
    }

    /// Dimensionless distance from the constrained minimum, zero there, from the force at u. Only the problem can judge
    /// it, because only the problem knows what is large; [`Bounds::natural_residual`] with the problem's own scales is a
    /// good choice (theory.md, section 6.6).
    fn residual(&self, u: &[f64], force: &[f64]) -> f64;
}
