use gfmd_relax::{Budget, Ending, InnerWatch, Variables as _, Visit, Watch};

use crate::{Contact, Effort, Load};

/// Fraction of the tolerance that a search has to reach; the rest is left to rounding errors of the certificate.
pub(crate) const MARGIN: f64 = 0.95;

/// Running solve: its task, its start, and its effort so far.
pub(crate) struct Attempt<'a> {
    pub(crate) contact: &'a Contact,
    pub(crate) load: Load,
    /// Length scale of the residuals.
    pub(crate) length_scale: f64,
    pub(crate) budget: Budget,
    /// Start pressure.
    pub(crate) start: Option<Vec<f64>>,
    pub(crate) watch: &'a mut dyn Watch,
    pub(crate) effort: Effort,
}

/// Result of a solver.
pub(crate) struct SolverResult {
    pub(crate) reached: FoundPressure,
    pub(crate) effort: Effort,
    pub(crate) ending: Ending,
}

/// End of a search. Only the pressure is trusted: all other fields are computed from it by [`Contact::certified`].
pub(crate) struct FoundPressure {
    pub(crate) pressure: Vec<f64>,
    /// Displacement u_z by the waves of this pressure, from fresh transforms, if the solver has computed it; counted in
    /// its effort.
    pub(crate) displacement: Option<Vec<f64>>,
}

impl From<Vec<f64>> for FoundPressure {
    fn from(pressure: Vec<f64>) -> Self {
        Self { pressure, displacement: None }
    }
}

impl Attempt<'_> {
    /// Returns the remaining budget.
    pub(crate) fn budget_left(&self) -> Budget {
        let max_iterations = self.budget.max_iterations.saturating_sub(self.effort.iterations);
        Budget { max_iterations, ..self.budget }
    }

    /// Returns the watcher of a part of the solve, which counts its iterations from zero. `outer` visits the variables
    /// outside this part; `hides_layer` is true if the variables of the part are not the displacement.
    pub(crate) fn part_watch<F: FnMut(&mut dyn Visit)>(
        &mut self,
        hides_layer: bool,
        mut outer: F,
    ) -> InnerWatch<'_, impl FnMut(&mut dyn Visit)> {
        let Self { watch, effort, .. } = self;
        let before = effort.iterations;
        InnerWatch {
            watch: &mut **watch,
            before,
            hides_layer,
            outer: move |visitor: &mut dyn Visit| {
                effort.visit(visitor);
                outer(visitor);
            },
        }
    }
}
