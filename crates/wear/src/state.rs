use gfmd_contact::{Solution, Solved};
use ndarray::Array2;

/// A state of surfaces that wear, after one sliding distance.
#[derive(Clone, Debug)]
pub struct WearState {
    /// Fields and residuals of the contact of the surfaces as they are worn. The displacement is that of the elastic
    /// body, and the approach counts from first touch of the unworn surfaces.
    pub solution: Solution,
    /// Sliding distance since the first touch, in length.
    pub distance: f64,
    /// The depth lost so far, `[x, y]`, in length.
    pub depth: Array2<f64>,
    /// Mean of `depth` over the whole surface, in length.
    pub volume: f64,
    /// The largest depth, in length.
    pub deepest: f64,
    /// Elastic energy per area, in stress × length.
    pub elastic_energy: f64,
    /// Work of the pressure on the depth lost in the step to this state, per area, in stress × length. The work of
    /// friction is no part of it.
    pub dissipated: f64,
    /// The difference between the work of the load in the step, by the trapezoidal rule, and the energy gained and
    /// lost, in magnitude. It falls with the square of the length of the step; 0 in a step over no distance.
    pub work_imbalance: f64,
}

impl Solved for WearState {
    type Inner = Solution;

    fn solution(&self) -> &Solution {
        &self.solution
    }
}
