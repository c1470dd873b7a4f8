use gfmd_contact::{Effort, Fields, Residual, Solution};
use gfmd_measure::{Scales, Summary};
use serde::{Deserialize, Serialize};

/// Numbers of one converged load of a run. The unit of length is the cell; stresses have the unit of Young's modulus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pressed {
    /// Area, pressure, gap, energy.
    pub summary: Summary,
    /// Rigid approach beyond first touch.
    pub approach: f64,
    /// Violation of each condition of the solution.
    pub residual: Residual,
    /// Effort of the solve.
    pub effort: Effort,
}

impl Pressed {
    /// Measures a solution.
    pub(crate) fn of(solution: &Solution, scales: &Scales) -> Self {
        let Solution { approach, residual, effort, .. } = *solution;
        Self { summary: solution.summary_in(scales), approach, residual, effort }
    }
}
