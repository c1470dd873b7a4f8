//! Matrix inertia for problems without bounds.

use crate::Landscape;

/// Energy without bounds, with an inertia matrix M. If M is close to the stiffness, the number of steps is small and
/// does not depend on the number of modes (theory.md, section 6.3).
///
/// The trait has no bounds, because projection after steps M⁻¹ f stops at a wrong point. Use
/// [`AugmentedLagrangian`](crate::AugmentedLagrangian) for problems with bounds.
pub trait Smooth {
    /// Returns the number of entries of u.
    fn len(&self) -> usize;

    /// Returns true if there are no entries.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes M⁻¹ f into `acceleration`, with f = −∂U/∂u, and returns U.
    fn accelerate(&mut self, u: &[f64], acceleration: &mut [f64]) -> f64;

    /// Returns the dimensionless distance from the minimum, computed from the acceleration; zero at zero acceleration.
    fn residual(&self, u: &[f64], acceleration: &[f64]) -> f64;
}

/// [`Smooth`] problem as a [`Landscape`] without bounds and with force M⁻¹ f, for any [`Method`](crate::Method). Its
/// stiffnesses are the eigenvalues of M⁻¹ K, about 1.
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
