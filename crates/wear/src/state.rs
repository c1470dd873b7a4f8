use gfmd_contact::{Solution, Solved};
use ndarray::Array2;

/// State of wearing surfaces after a sliding distance.
#[derive(Clone, Debug)]
pub struct WearState {
    /// Fields and residuals of the contact of the worn surfaces. The displacement is purely elastic, and the approach
    /// is measured from first touch of the unworn surfaces.
    pub solution: Solution,
    /// Sliding distance since the first touch, in length.
    pub distance: f64,
    /// Depth lost so far, `[x, y]`, in length.
    pub depth: Array2<f64>,
    /// Mean of `depth` over the whole surface, in length.
    pub volume: f64,
    /// Largest depth, in length.
    pub deepest: f64,
    /// Elastic energy per area, in stress × length.
    pub elastic_energy: f64,
    /// Work of the pressure on the depth lost in the step to this state, per area, in stress × length. The work of
    /// friction is not included.
    pub dissipated: f64,
    /// Magnitude of the difference between the work of the load in the step, by the trapezoidal rule, and the energy
    /// stored and dissipated. It falls with the square of the step length; 0 over no distance.
    pub work_imbalance: f64,
}

impl Solved for WearState {
    type Inner = Solution;

    fn solution(&self) -> &Solution {
        &self.solution
    }
}
