use gfmd_contact::{Fields, Solution, Solved};
use gfmd_field::{Grid, Transform};
use ndarray::Array2;

use crate::history::History;

/// State of a viscoelastic contact at one time.
#[derive(Clone, Debug)]
pub struct ViscoelasticState<S = Solution> {
    /// Pressure, displacement, gap and residuals.
    pub solution: S,
    /// Time since the first touch of the undeformed surfaces.
    pub time: f64,
    /// Energy stored in the springs of all branches, per area, in stress × length.
    pub elastic_energy: f64,
    /// Energy lost in the step to this state, per area, in stress × length: in the dashpots and, with a law, in jumps.
    pub dissipated: f64,
    /// Magnitude of the difference between the work of the rigid surface in the step, by the trapezoidal rule, and the
    /// energy stored and lost. It is of second order in the duration of the step, but is not the error of `dissipated`:
    /// at a held approach it is 0 for any duration. It is 0 in an instantaneous step at a hard wall, and in the first
    /// step with a law, where the work is unknown. In a step with a jump, this difference is the loss, and the value is
    /// the largest error of the rule for forces that change monotonically.
    pub work_imbalance: f64,
    pub(crate) history: History,
}

impl<S: Fields> ViscoelasticState<S> {
    /// Returns the complete memory of the body: the indentation −u_z and the spring elongation of each branch,
    /// `[x, y]`, in length.
    pub fn memory(&self) -> Vec<Array2<f64>> {
        let (nx, ny) = self.solution.gap().dim();
        let field =
            |values: Vec<f64>| Array2::from_shape_vec((nx, ny), values).expect("every field has the size of the grid");
        match &self.history {
            History::Points { lengths, .. } => lengths.iter().map(|values| field(values.clone())).collect(),
            History::Waves(spectra) => {
                // The transform does not depend on the lengths of the cell.
                let grid = Grid::new([nx, ny], [1.0; 2]).expect("a field has points");
                let transform = Transform::new(grid);
                let mut workspace = transform.workspace();
                let mut of = |spectrum: &[_]| {
                    let mut values = vec![0.0; nx * ny];
                    let fits = transform.inverse(spectrum, &mut values, &mut workspace);
                    fits.expect("every spectrum has the size of the grid");
                    field(values)
                };
                spectra.iter().map(|spectrum| of(spectrum)).collect()
            }
        }
    }
}

impl<S: Fields> Solved for ViscoelasticState<S> {
    type Inner = S;

    fn solution(&self) -> &S {
        &self.solution
    }

    fn stored_energy(&self) -> Option<f64> {
        Some(self.elastic_energy)
    }
}
