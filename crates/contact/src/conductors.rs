//! Conductance of the points in contact between two conductors of heat or electric current (theory.md, section 7.6).

use gfmd_field::Grid;
use gfmd_green::{Conductor, Height};
use gfmd_relax::{Ceiling, Why};
use gfmd_vector::contiguous;
use ndarray::ArrayRef2;

use crate::{Boundary, Contact, Effort, Refusal, Stiffness};

/// Two conductors that touch at some points of a grid and are insulated from each other at the others. One has unit
/// conductivity and the other no resistance. Conductors with the resistivities ρ₁ and ρ₂ have the conductance found
/// here divided by ρ₁ + ρ₂: half of it if both conductivities are 1.
///
/// The conductors are half-spaces, or slabs on electrodes at one depth. The elastic body, its interaction with the
/// rigid surface and its hardness matter only because they decide which points touch. Clones share the data.
///
/// ```
/// use gfmd_contact::{Boundary, Conductors};
/// use gfmd_field::Grid;
/// use gfmd_green::Height;
/// use ndarray::Array2;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// // A square spot of side a = L/4 alone on a half-space conducts 2.305 a/ρ, half of what follows from its capacitance
/// // 0.3668 (4π ε a); a round one of this area 4 (a/√π)/ρ = 2.257 a/ρ.
/// let n = 128;
/// let spot = Array2::from_shape_fn((n, n), |(i, j)| if i < 32 && j < 32 { 1.0 } else { 0.0 });
/// let conductors = Conductors::new(Boundary::Free, &Grid::square(n, 1.0)?, Height::Infinite)?;
/// let found = conductors.conductance(&spot)?;
/// assert!((found.value / (2.305 / 4.0) - 1.0).abs() < 0.03 && found.error <= 1e-9, "{found:?}");
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Conductors {
    contact: Contact,
}

/// Conductance of points in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductance {
    /// Conductance per area times the sum of the two resistivities, in 1/length. Periodic surface: mean current
    /// density, divided by the potential difference in excess of the one that drives the same current through the bulk
    /// alone. Free boundaries: current, divided by the area of the patch and the whole potential difference. Infinite
    /// if all points of a periodic surface touch; NaN for a profile with free boundaries on half-spaces, where a
    /// constant of the potential is unknown.
    pub value: f64,
    /// Relative error of `value`, as [`Stiffness::error`].
    pub error: f64,
    /// Effort of the solve.
    pub effort: Effort,
}

impl From<Stiffness> for Conductance {
    fn from(Stiffness { value, error, effort }: Stiffness) -> Self {
        Self { value, error, effort }
    }
}

/// Largest relative error of a conductance.
const ERROR: f64 = 1e-9;

/// Reasons why there is no conductance, or no exact one.
#[derive(Debug, thiserror::Error)]
pub enum ConductanceError {
    /// The pressure differs in shape from the grid.
    #[error("the shape of the pressure is {found:?}; it must be {expected:?}, the shape of the grid")]
    Shape {
        /// Shape of the pressure.
        found: [usize; 2],
        /// Shape of the grid.
        expected: [usize; 2],
    },
    /// The error of the conductance exceeds 1e-9.
    #[error("the error of the conductance {:e} is {:.1e} ({why})", .reached.value, .reached.error)]
    Inexact {
        /// Conductance reached.
        reached: Conductance,
        /// Reason why the iterations ended.
        why: Why,
    },
}

impl Conductors {
    /// Makes conductors on a `grid`, each with its electrode at the depth `height` below the surface, or at infinity.
    ///
    /// # Errors
    /// A height that is not positive and finite; with free boundaries a height below 1/200 of the diagonal of the patch
    /// (of the length of a profile) or 1/4 of the grid spacing.
    pub fn new(boundary: Boundary, grid: &Grid, height: Height) -> Result<Self, Refusal> {
        let conductor = Conductor::new(height)?;
        Ok(Self { contact: Contact::of_conductor(boundary, &conductor, grid)? })
    }

    /// Computes the conductance of the points `[x, y]` with a positive `pressure`, such as the
    /// [repulsion](crate::Fields::repulsion) of a state; zero if there are none.
    ///
    /// # Errors
    /// A pressure that differs in shape from the grid; the conductance reached, if its error exceeds 1e-9.
    pub fn conductance(&self, pressure: &ArrayRef2<f64>) -> Result<Conductance, ConductanceError> {
        let (found, expected) = (pressure.dim().into(), self.contact.surface().shape());
        if found != expected {
            return Err(ConductanceError::Shape { found, expected });
        }
        let pressure = contiguous(pressure);
        let found = self.contact.stiffness_of_points(&pressure, Ceiling::All(f64::INFINITY), ERROR);
        found
            .map(Conductance::from)
            .map_err(|(reached, why)| ConductanceError::Inexact { reached: reached.into(), why })
    }
}
