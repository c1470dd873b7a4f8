use std::sync::Arc;

use gfmd_contact::{Effort, Fields, Solution};
use gfmd_field::Share;
use gfmd_measure::{Scales, Summary};
use gfmd_vector::contiguous;
use ndarray::{Array2, Array3, ArrayView2, CowArray, Ix2};

use crate::PlasticStrain;
use crate::cells::{Cell, Mesh};

/// State of an elastic-plastic contact at the end of a step. Energies are per area of the surface, in stress × length.
#[derive(Clone, Debug, PartialEq)]
pub struct PlasticState {
    /// Pressure, displacement, gap, and the residuals of the contact conditions. The displacement includes the plastic
    /// part. The effort counts all transforms of the step; its iterations are [`operators`](Self::operators).
    pub solution: Solution,
    /// Normal displacement of the surface by plastic strain alone, `[x, y]`, in length: the residual topography of the
    /// unloaded surface.
    pub plastic_displacement: Array2<f64>,
    /// Plastic strain and κ of all cells.
    pub plastic: PlasticStrain,
    /// Plastic strain and κ before the step, from which the residuals of the flow follow.
    pub plastic_before: PlasticStrain,
    /// Elastic energy, with the energy of residual stress.
    pub elastic_energy: f64,
    /// Energy stored by hardening; isotropic hardening does not give it back.
    pub hardening_energy: f64,
    /// Energy dissipated in the step, Σ h ⟨Y Δκ⟩; the plastic work of the step is this and the change of the hardening
    /// energy.
    pub dissipated: f64,
    /// Difference between the work of the load, by the trapezoidal rule, and the energy stored and dissipated: the
    /// error by the size of the step.
    pub work_imbalance: f64,
    /// Residuals of the plastic flow.
    pub residual: FlowResidual,
    /// Number of volume operators in the step: changes from plastic strain and pressure to strain.
    pub operators: u64,
    pub(crate) mesh: Arc<Mesh>,
}

/// Residuals of yield condition and plastic flow; zero for the exact solution. They are computed from the final
/// pressure, plastic strain and κ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowResidual {
    /// Largest excess of the equivalent stress over R(κ), divided by the yield stress.
    pub yielding: f64,
    /// Largest error of the increment of plastic strain, |Δε^p − (3/2) Δκ ξ/q|, divided by the largest κ.
    pub flow: f64,
    /// Largest Δκ (R − q) divided by the yield stress and by the largest κ.
    pub flow_complementarity: f64,
    /// Root mean square of the unbalanced forces on the nodes between cells, on the surface and on the body below the
    /// cells, divided by the root mean square of the forces on them, from the strain and the plastic strain.
    pub equilibrium: f64,
    /// 1 if the lowest of [graded](crate::Cells::Graded) cells has yielded and the layer goes on below it, else 0.
    pub bottom: f64,
}

impl FlowResidual {
    /// Returns the residuals with their names.
    pub fn parts(&self) -> [(&'static str, f64); 5] {
        [
            ("yield", self.yielding),
            ("flow", self.flow),
            ("flow_complementarity", self.flow_complementarity),
            ("equilibrium", self.equilibrium),
            ("bottom", self.bottom),
        ]
    }
}

impl PlasticState {
    /// Returns the cells, from the surface down.
    pub fn cells(&self) -> &[Cell] {
        &self.mesh.cells
    }

    /// Returns the rows of this process on the grid of a cell.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn rows(&self, cell: usize) -> &Share {
        self.mesh.division.of(cell)
    }

    /// Returns ε^p of a cell, `[component, x, y]` on the grid of the cell, of the rows of this process. The five
    /// components of a deviatoric strain are √(3/2) ε_zz, (ε_xx − ε_yy)/√2, √2 ε_xy, √2 ε_xz and √2 ε_yz; their squares
    /// add to ε^p:ε^p.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn plastic_strain(&self, cell: usize) -> Array3<f64> {
        self.strain_of(&self.plastic, cell)
    }

    /// Returns a plastic strain of these cells, such as [`plastic_before`](Self::plastic_before), as
    /// [`plastic_strain`](Self::plastic_strain) does.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn strain_of(&self, plastic: &PlasticStrain, cell: usize) -> Array3<f64> {
        plastic.strain_field(&self.mesh, cell)
    }

    /// Returns the equivalent plastic strain κ of a cell, `[x, y]` on the grid of the cell.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn equivalent_plastic_strain(&self, cell: usize) -> Array2<f64> {
        self.equivalent_of(&self.plastic, cell)
    }

    /// Returns κ of a plastic strain of these cells, as
    /// [`equivalent_plastic_strain`](Self::equivalent_plastic_strain) does.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn equivalent_of(&self, plastic: &PlasticStrain, cell: usize) -> Array2<f64> {
        plastic.equivalent_field(&self.mesh, cell)
    }

    /// Returns κ integrated over depth, averaged over the surface, in length.
    pub fn plastic_strain_integral(&self) -> f64 {
        self.plastic.integral(&self.mesh, |_, _, _, equivalent| equivalent)
    }

    /// Returns the volume that has yielded, per area of the surface, in length.
    pub fn yielded_volume(&self) -> f64 {
        self.plastic.integral(&self.mesh, |_, _, _, equivalent| f64::from(equivalent > 0.0))
    }

    /// Returns the depth of the bottom of the lowest cell that has yielded, in length; 0 if none has.
    pub fn yield_depth(&self) -> f64 {
        let own = self.plastic.cells.iter().map(|cell| cell.equivalent.iter().any(|k| *k > 0.0));
        let lowest = self.mesh.division.any(&own.collect::<Vec<bool>>()).into_iter().rposition(|yields| yields);
        lowest.map_or(0.0, |lowest| self.mesh.cells[lowest].depth)
    }

    /// Returns true if the lowest cell has yielded although its layer goes on below it, where it cannot yield.
    pub fn yields_at_bottom(&self) -> bool {
        self.mesh.is_cut && self.mesh.division.surface.any(self.plastic.yields_in_lowest())
    }

    /// Returns the largest κ.
    pub fn max_plastic_strain(&self) -> f64 {
        self.mesh.division.largest(self.plastic.largest())
    }

    /// Returns the mean, the root mean square and the lowest value of the plastic displacement, in length.
    pub fn plastic_displacement_measures(&self) -> PlasticDisplacement {
        let (values, share) = (contiguous(&self.plastic_displacement), &self.mesh.division.surface);
        let n = share.total() as f64;
        let mean = share.total_of(&values) / n;
        let squares = share.sum(&|range| values[range].iter().map(|u| (u - mean).powi(2)).sum());
        let least = values.iter().copied().fold(f64::INFINITY, gfmd_vector::lower);
        let min = share.each(least).into_iter().fold(f64::INFINITY, gfmd_vector::lower);
        PlasticDisplacement { mean, rms: (squares / n).sqrt(), min }
    }
}

/// Measures of the plastic displacement u_z of the surface, in length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticDisplacement {
    /// Mean.
    pub mean: f64,
    /// Root mean square of the difference from the mean.
    pub rms: f64,
    /// Lowest value: the deepest imprint.
    pub min: f64,
}

impl Fields for PlasticState {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.solution.pressure()
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.solution.displacement_z()
    }

    fn gap(&self) -> ArrayView2<'_, f64> {
        self.solution.gap()
    }

    fn mean_pressure(&self) -> f64 {
        self.solution.mean_pressure()
    }

    fn approach(&self) -> f64 {
        self.solution.approach()
    }

    fn effort(&self) -> Effort {
        self.solution.effort()
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        self.solution.residuals().into_iter().chain(self.residual.parts()).collect()
    }

    fn scales(&self) -> Scales {
        self.solution.scales()
    }

    fn summary_in(&self, scales: &Scales) -> Summary {
        Summary { elastic_energy: self.elastic_energy, ..self.solution.summary_in(scales) }
    }
}
