use gfmd_contact::{Effort, Fields, Solution};
use gfmd_measure::{Scales, Summary};
use ndarray::{ArrayView2, CowArray, Ix2};

use crate::history::History;

/// A state of a viscoelastic contact at one time.
#[derive(Clone, Debug)]
pub struct ViscoelasticState {
    /// Pressure, displacement, gap and residuals.
    pub solution: Solution,
    /// Time since the first touch of the undeformed surfaces.
    pub time: f64,
    /// Energy stored in the springs of all branches, per area, in stress × length.
    pub elastic_energy: f64,
    /// Energy lost in the step to this state, per area, in stress × length.
    pub dissipated: f64,
    /// The difference between the work of the rigid surface in the step, by the trapezoidal rule, and the energy stored
    /// and lost. It falls with the square of the length of the step; 0 in a step of no time.
    pub dissipated_error: f64,
    pub(crate) history: History,
}

impl Fields for ViscoelasticState {
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
        self.solution.mean_pressure
    }

    fn approach(&self) -> f64 {
        self.solution.approach
    }

    fn effort(&self) -> Effort {
        self.solution.effort
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        self.solution.residuals()
    }

    fn scales(&self) -> Scales {
        self.solution.scales()
    }

    fn summary_in(&self, scales: &Scales) -> Summary {
        Summary { elastic_energy: self.elastic_energy, ..self.solution.summary_in(scales) }
    }
}
