//! Interface between relaxation methods and problems.

use crate::{Bounds, Visit};

/// Energy U(u) to be minimised over all u within [`Landscape::bounds`].
///
/// Methods call each function once per step with whole vectors, so `dyn` costs nothing. The unit of `force` is energy
/// divided by displacement. The mass is 1, so a stiffness (second derivative of U) is a squared frequency.
///
/// Example: the quadratic function U = u₀² − u₀ u₁ + 3/2 u₁² − u₀ − u₁ with its minimum at (4, 3)/5:
///
/// ```
/// use gfmd_relax::{Bounds, Fire, Landscape, Method, Stop, relax};
///
/// struct Quadratic { upper: [f64; 2] }
///
/// impl Landscape for Quadratic {
///     fn len(&self) -> usize { 2 }
///
///     fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
///         force[0] = 1.0 - 2.0 * u[0] + u[1];
///         force[1] = 1.0 - 3.0 * u[1] + u[0];
///         u[0] * u[0] - u[0] * u[1] + 1.5 * u[1] * u[1] - u[0] - u[1]
///     }
///
///     fn bounds(&self) -> Bounds<'_> { Bounds::Upper(&self.upper) }
///
///     fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
///         self.bounds().natural_residual(u, force, 1.0, 1.0)
///     }
/// }
///
/// # fn main() -> Result<(), gfmd_relax::RelaxError> {
/// let method = Fire::v2(Fire::largest_dt(3.7)); // the eigenvalues are (5 ± √5)/2
/// let stop = Stop { residual: 1e-12, settled: 20, max_steps: 1000 };
/// let minimum = |upper| -> Result<Vec<f64>, gfmd_relax::RelaxError> {
///     let mut problem = Quadratic { upper };
///     let mut state = method.start(&mut problem, vec![0.0; 2])?;
///     relax(&mut problem, &method, &mut state, &stop, &mut ())?;
///     Ok(state.u)
/// };
/// let u = minimum([f64::INFINITY; 2])?;
/// assert!((u[0] - 0.8).abs() < 1e-11 && (u[1] - 0.6).abs() < 1e-11);
/// // With u₀ = 1/2 at its bound, u₁ is free: 1 − 3 u₁ + 1/2 = 0.
/// let u = minimum([0.5, f64::INFINITY])?;
/// assert!(u[0] == 0.5 && (u[1] - 0.5).abs() < 1e-11);
/// # Ok(())
/// # }
/// ```
pub trait Landscape {
    /// Returns the number of entries of u.
    fn len(&self) -> usize;

    /// Returns true if there are no entries.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes −∂U/∂u into `force` and returns U. This is the expensive function, called once per step.
    ///
    /// A hard wall is a constraint, not a force, and is not included (theory.md, section 6.5).
    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64;

    /// Returns the allowed values of u. They are constant during a relaxation; after a change, start a new
    /// [`State`](crate::State) from the old u.
    fn bounds(&self) -> Bounds<'_> {
        Bounds::Free
    }

    /// Returns the dimensionless distance from the constrained minimum, computed from the force at u; zero at the
    /// minimum. The problem defines it, because methods do not know the scales of forces and lengths.
    /// [`Bounds::natural_residual`] with the scales of the problem is a good choice (theory.md, section 6.6).
    fn residual(&self, u: &[f64], force: &[f64]) -> f64;

    /// Visits the variables that the problem itself changes during a search, for example an effort counter.
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let _ = visitor;
    }
}
