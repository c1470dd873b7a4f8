//! Contacts with a displacement that is very small beside the roughness: they are solved again on a finer length scale.

use gfmd_relax::{Budget, Ending, InnerWatch, Variables, Visit, Watch, Why};

use crate::{Effort, Fields, Load, Refusal};

/// State with residuals relative to a length scale that follows from its displacement.
pub(crate) trait Refined: Fields {
    /// Returns the length scale of the residuals, in the units of the solve.
    fn length_scale(&self) -> f64;

    /// Returns the pressure to start from on a finer scale, in the units of the solve.
    fn start(&self) -> Vec<f64>;

    /// Returns the effort of the solve.
    fn effort_mut(&mut self) -> &mut Effort;
}

/// Length scale of a search, and the effort of the searches before.
#[derive(Clone, Copy)]
struct Stage {
    length_scale: f64,
    effort: Effort,
}

impl Variables for Stage {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.number(&mut self.length_scale);
        self.effort.visit(visitor);
    }
}

/// Largest part of a prescribed approach that is within the tolerance on the coarsest scale.
const OF_THE_APPROACH: f64 = 0.1;

/// Returns the coarsest length scale of a search under `load`, at most `scale`: without pressure, a surface moved by a
/// prescribed approach must not be within the tolerance.
pub(crate) fn coarsest(scale: f64, load: Load, tolerance: f64) -> f64 {
    match load {
        Load::Approach(approach) if approach > 0.0 => scale.min(OF_THE_APPROACH * approach / tolerance),
        _ => scale,
    }
}

/// Calls `search(scale, budget, start, watch)` with the `coarsest` length scale, and again with the scale of the state
/// found while this is finer and its residuals exceed the tolerance. The displacement is not known in advance.
pub(crate) fn refine<S: Refined>(
    coarsest: f64,
    budget: &Budget,
    mut start: Option<Vec<f64>>,
    watch: &mut dyn Watch,
    mut search: impl FnMut(f64, Budget, Option<Vec<f64>>, &mut dyn Watch) -> Result<(S, Ending), Refusal>,
) -> Result<(S, Ending), Refusal> {
    let mut stage = Stage { length_scale: coarsest, effort: Effort::default() };
    if let Some(kept) = watch.recall() {
        stage.visit(kept);
    }
    loop {
        let Stage { length_scale, effort } = stage;
        let left = Budget { max_iterations: budget.max_iterations.saturating_sub(effort.iterations), ..*budget };
        let outer = |visitor: &mut dyn Visit| stage.visit(visitor);
        let mut inner = InnerWatch { watch: &mut *watch, before: effort.iterations, outer, hides_layer: false };
        let (mut state, ending) = search(length_scale, left, start.take(), &mut inner)?;
        state.effort_mut().add(effort);
        // On a coarse scale a small displacement may not be resolved at all.
        let is_settled = matches!(ending, Ending::Converged | Ending::GaveUp(Why::Rounding | Why::NoDescent));
        let is_coarse = state.length_scale() < length_scale && state.worst() > budget.tolerance;
        if !(is_settled && is_coarse) || state.effort().iterations >= budget.max_iterations {
            return Ok((state, ending));
        }
        stage = Stage { length_scale: state.length_scale(), effort: state.effort() };
        start = Some(state.start());
    }
}
