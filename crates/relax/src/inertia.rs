//! Inertia that is a matrix, for problems without bounds.

use crate::Landscape;

/// An energy without bounds, with an inertia matrix M. If M is close to the stiffness, the number of steps is small and
/// does not depend on the number of modes (theory.md, section 6.3).
///
/// The trait has no bounds, because projection after steps M⁻¹ f stops at a wrong point. Use
/// [`AugmentedLagrangian`](crate::AugmentedLagrangian) for problems with bounds.
pub trait Smooth {
    /// Number of entries of u.
    fn len(&self) -> usize;

    /// True if there are no entries.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes M⁻¹ f into `acceleration`, with f = −∂U/∂u, and returns U.
    fn accelerate(&mut self, u: &[f64], acceleration: &mut [f64]) -> f64;

    /// Dimensionless distance from the minimum, computed from the acceleration; zero if the acceleration is zero.
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
