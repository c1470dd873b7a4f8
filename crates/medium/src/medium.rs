//! Bodies as the steps of a contact see them.

use gfmd_contact::Refusal;

use crate::{Energies, Memory, MemoryDerivatives};

/// Body with a memory, in the steps of a contact.
///
/// During a step the displacement of its surface is an affine function of the traction at the end, u = −H + G t/m: an
/// elastic body that is stiffer by m, below a surface with the residual indentation H (theory.md, section 7.7). A
/// contact solves the step for this relation, and gives back what was reached. Vectors are stored component by
/// component, z last; a body without lateral memory has u_z alone.
pub trait Medium: Send + Sync {
    /// Returns the memory of the undeformed body.
    fn rest(&self) -> Memory;

    /// Prepares a step of this `duration` that begins with `memory`.
    ///
    /// # Errors
    /// Returns an error for the memory of another body.
    fn begin(&self, memory: &Memory, duration: f64) -> Result<Affine, Refusal>;

    /// Computes the memory and the energies at the end of a step that reaches an `indentation`, −u, under `pressure`,
    /// −t/m.
    ///
    /// # Errors
    /// Returns an error for the memory of another body.
    fn end(
        &self,
        memory: &Memory,
        step: &Affine,
        indentation: Vec<f64>,
        pressure: &[f64],
    ) -> Result<(Memory, Energies), Refusal>;

    /// Computes the derivatives of the energy stored in all springs, per area, with respect to the memory, times
    /// `factor`. The mean displacement has no share where nothing moves it.
    ///
    /// # Errors
    /// Returns an error for the memory of another body.
    fn energy_derivatives(&self, memory: &Memory, factor: f64) -> Result<MemoryDerivatives, Refusal>;

    /// Transposes [`end`](Self::end): from the derivatives of a number with respect to the
    /// memory at the end of a step, computes those with respect to the indentation reached, and to the memory at the
    /// start for a fixed indentation.
    ///
    /// # Errors
    /// Returns an error for the memory of another body.
    fn end_transposed(&self, of: &MemoryDerivatives, duration: f64) -> Result<(Vec<f64>, MemoryDerivatives), Refusal>;

    /// Transposes [`begin`](Self::begin): adds to the derivatives `of` a number with respect
    /// to the memory at the start the effect of its derivatives with respect to the residual indentation.
    ///
    /// # Errors
    /// Returns an error for the memory of another body.
    fn begin_transposed(
        &self,
        by_residual_indentation: &[f64],
        duration: f64,
        of: &mut MemoryDerivatives,
    ) -> Result<(), Refusal>;

    /// Returns the largest number of branches of a wave.
    fn branches(&self) -> usize;
}

/// Affine relation between traction and displacement during a step.
#[derive(Clone, Debug)]
pub struct Affine {
    /// Residual indentation H at zero traction, component by component, in length.
    pub residual_indentation: Vec<f64>,
    /// Stiffness of the step divided by the long-term stiffness.
    pub stiffening: Stiffening,
    /// Duration of the step.
    pub duration: f64,
}

/// Stiffness during a step divided by the long-term stiffness.
#[derive(Clone, Debug)]
pub enum Stiffening {
    /// Common factor of all waves.
    All(f64),
    /// One factor per wave of this process, laid out as the [modes](gfmd_field::Grid::modes) of the grid.
    Waves(Vec<f64>),
}

impl Affine {
    /// Returns the factor m common to all waves; 1 if each wave has its own.
    pub fn factor(&self) -> f64 {
        if let Stiffening::All(factor) = self.stiffening { factor } else { 1.0 }
    }
}
