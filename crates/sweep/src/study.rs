use std::collections::BTreeMap;
use std::error::Error;
use std::sync::{Mutex, PoisonError};

use crate::{Analysis, Example, Keep, Plan, Pressed, Run, SweepError, SweepPrecision, run};

/// Results of a sweep.
#[derive(Clone, Debug)]
pub struct Study {
    /// Plan that was carried out; with a target, the final plan.
    pub plan: Plan,
    /// Loads of every run, in the order of the plan.
    pub runs: Vec<Vec<Pressed>>,
    /// kappa of every point, and the extrapolations.
    pub analysis: Analysis,
    /// Contact with its fields, as an example.
    pub example: Example,
}

impl Study {
    /// Carries out a plan. If its configuration has a target, surfaces are added in rounds until the target is met, or
    /// until no number of surfaces can meet it.
    ///
    /// # Errors
    /// Returns an error if a contact does not converge, if a run cannot be kept, if the points cannot determine a
    /// model, or after an interruption.
    pub fn new(mut plan: Plan, keep: &dyn Keep) -> Result<Self, SweepError> {
        let mut runs = run(&plan, keep)?;
        let mut analysis = Analysis::new(&plan, &runs)?;
        while let Some(next) = next_round(&plan, &analysis, keep)? {
            let known = plan.runs.iter().map(|run| (run.point, run.realisation)).zip(runs).collect();
            runs = run(&next, &Later { known: Mutex::new(known), keep })?;
            plan = next;
            analysis = Analysis::new(&plan, &runs)?;
        }
        let example = Example::new(&plan, keep)?;
        Ok(Self { plan, runs, analysis, example })
    }
}

/// Returns the plan of the next round, if there must be one.
fn next_round(plan: &Plan, analysis: &Analysis, keep: &dyn Keep) -> Result<Option<Plan>, SweepError> {
    let target = plan.config.statistics.target;
    let Some(reached) = (target > 0.0).then(|| SweepPrecision::new(plan, analysis, target)).flatten() else {
        return Ok(None);
    };
    let next = plan.with_surfaces(reached.surfaces)?;
    if next.runs.len() == plan.runs.len() {
        return Ok(None);
    }
    keep.more(&next, reached.relative);
    Ok(Some(next))
}

/// Runs of earlier rounds, then runs stored by `keep`.
struct Later<'a> {
    known: Mutex<BTreeMap<(usize, u64), Vec<Pressed>>>,
    keep: &'a dyn Keep,
}

impl Keep for Later<'_> {
    fn recall(&self, run: &Run) -> Option<Vec<Pressed>> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).remove(&(run.point, run.realisation));
        known.or_else(|| self.keep.recall(run))
    }

    fn keep(&self, run: &Run, loads: &[Pressed]) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.keep.keep(run, loads)
    }

    fn is_interrupted(&self) -> bool {
        self.keep.is_interrupted()
    }
}
