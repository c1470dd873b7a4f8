use crate::{Analysis, Example, Keep, Plan, Pressed, SweepError, run};

/// The results of a sweep.
#[derive(Clone, Debug)]
pub struct Study {
    /// The plan that was carried out.
    pub plan: Plan,
    /// The loads of every run, in the order of the plan.
    pub runs: Vec<Vec<Pressed>>,
    /// kappa of every point, and the extrapolations.
    pub analysis: Analysis,
    /// One contact with its fields, as an example.
    pub example: Example,
}

impl Study {
    /// Carries out a plan.
    ///
    /// # Errors
    /// A contact that did not converge, a run that could not be kept, a model that the points cannot determine, an
    /// interruption.
    pub fn new(plan: Plan, keep: &dyn Keep) -> Result<Self, SweepError> {
        let runs = run(&plan, keep)?;
        let analysis = Analysis::new(&plan, &runs)?;
        let example = Example::new(&plan, keep)?;
        Ok(Self { plan, runs, analysis, example })
    }
}
