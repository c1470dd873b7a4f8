//! Inertia that is a matrix, where that is legitimate.

use crate::Landscape;

/// An energy without bounds that knows a matrix of inertia M, best one near the stiffness: all modes then take the same
/// few steps, however many there are (theory.md, section 6.3).
///
/// There is nothing here to say a bound with, because a projection after steps M⁻¹ f stops at a wrong point:
/// [`AugmentedLagrangian`](crate::AugmentedLagrangian) is for those who have both.
pub trait Smooth {
    /// Number of entries of u.
    fn len(&self) -> usize;

    /// Whether there is nothing to minimise.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes M⁻¹ f into `acceleration`, with f = −∂U/∂u, and returns U.
    fn accelerate(&mut self, u: &[f64], acceleration: &mut [f64]) -> f64;

    /// Dimensionless distance from the minimum, judged from the acceleration: zero where that is.
    fn residual(&self, u: &[f64], acceleration: &[f64]) -> f64;
}

/// A [`Smooth`] problem as a [`Landscape`] for any [`Method`](crate::Method): its force is M⁻¹ f, and it has no bounds.
/// Stiffnesses are the eigenvalues of M⁻¹ K, about 1.
#[derive(Clone, Debug)]
pub struct Inertial<S>(pub S);

impl<S: Smooth> Landscape for Inertial<S> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.0.accelerate(u, force)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.0.residual(u, force)
    }
}
