use std::ops::ControlFlow;

use crate::{
    Budget, Divergence, Ending, Landscape, Method, Observer, Outcome, Progress, RelaxError, State, Status, Stop,
};
use crate::{Variables as _, Visit, Watch, Why, relax};

/// Number of steps without a change in the set of entries at their bounds (theory.md, section 6.6).
const SETTLED: u64 = 20;

/// Relaxes until `certify` confirms the tolerance of the budget. `certify` returns the largest residual of a state,
/// recomputed independently of the method. If it exceeds the tolerance although the method has converged, the target
/// residual of the method is reduced.
///
/// # Errors
/// Returns an error if the state or the bounds differ in length from the landscape. An unsuccessful search is an
/// [`Ending`], not an error.
pub fn relax_until<L: Landscape, M: Method>(
    landscape: &mut L,
    method: &M,
    state: &mut State<M::Memory>,
    budget: &Budget,
    certify: &mut dyn FnMut(&mut L, &State<M::Memory>) -> f64,
    watch: &mut dyn Watch,
) -> Result<Ending, RelaxError> {
    let mut stop = Stop { residual: budget.tolerance, settled: SETTLED, max_steps: budget.max_iterations };
    if let Some(kept) = watch.recall() {
        kept.number(&mut stop.residual);
        state.visit(kept);
        landscape.visit(kept);
    }
    loop {
        let mut observer = Watched { watch: &mut *watch, target: stop.residual };
        let now = match relax(landscape, method, state, &stop, &mut observer) {
            Ok(Outcome::Converged(now)) => now,
            Ok(Outcome::Interrupted(_)) => return Ok(Ending::Interrupted),
            Err(RelaxError::NotConverged { .. }) => return Ok(Ending::GaveUp(Why::Iterations)),
            Err(RelaxError::Diverged { reason, .. }) => return Ok(Ending::GaveUp(Why::Diverged(reason))),
            Err(RelaxError::Uphill { found, allowed, .. }) => {
                return Ok(Ending::GaveUp(Why::Uphill { found, allowed }));
            }
            Err(error) => return Err(error),
        };
        let worst = certify(landscape, state);
        if worst <= budget.tolerance {
            return Ok(Ending::Converged);
        }
        if worst.is_nan() {
            return Ok(Ending::GaveUp(Why::Diverged(Divergence::NotFinite)));
        }
        stop.residual = now.residual * (0.5 * budget.tolerance / worst).clamp(1e-3, 0.5);
        // Rounding keeps relative residuals above a target this low, and the method would never end. A target of zero
        // would be met immediately, again and again.
        if stop.residual < f64::EPSILON {
            return Ok(Ending::GaveUp(Why::Rounding));
        }
    }
}

/// Watcher of a whole search as the observer of one run.
struct Watched<'a> {
    watch: &'a mut dyn Watch,
    /// Residual at which the run ends.
    target: f64,
}

impl<Memory> Observer<State<Memory>> for Watched<'_> {
    fn observe(&mut self, now: &Status, state: &State<Memory>) -> std::io::Result<ControlFlow<()>> {
        let flow = self.watch.see(&Progress { iteration: now.step, residual: now.residual });
        self.watch.layer(now.energy, &state.u);
        Ok(flow)
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        let Self { watch, target } = self;
        watch.checkpoint(&mut |visitor| {
            visitor.number(target);
            variables(visitor);
        });
    }
}
