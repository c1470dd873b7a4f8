use std::ops::ControlFlow;

use crate::{Budget, Divergence, Ending, Landscape, Method, Outcome, Progress, RelaxError, State, Status, Stop, Watch};
use crate::{Why, relax};

/// Steps for which the entries at their bounds must have stayed the same (theory.md, section 6.6).
const SETTLED: u64 = 20;

/// Relaxes until `certify` confirms the tolerance of the budget. `certify` returns the largest residual of the problem at
/// a state, recomputed and not taken from the method. While it exceeds the tolerance although the method has converged,
/// the target of the method is tightened.
///
/// # Errors
/// A state or bounds that do not fit the landscape. A search without success is no error but an [`Ending`].
pub fn relax_until<L: Landscape, M: Method>(
    landscape: &mut L,
    method: &M,
    state: &mut State<M::Memory>,
    budget: &Budget,
    certify: &mut dyn FnMut(&mut L, &State<M::Memory>) -> f64,
    watch: &mut dyn Watch,
) -> Result<Ending, RelaxError> {
    let mut observe = |now: &Status, _: &State<M::Memory>| -> std::io::Result<ControlFlow<()>> {
        Ok(watch.see(&Progress { iteration: now.step, residual: now.residual }))
    };
    let mut stop = Stop { residual: budget.tolerance, settled: SETTLED, max_steps: budget.max_iterations };
    loop {
        let now = match relax(landscape, method, state, &stop, &mut observe) {
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
        // Rounding keeps residuals, which are relative, above such a target, so that the method would never end. A target
        // of zero would be met at once, again and again.
        if stop.residual < f64::EPSILON {
            return Ok(Ending::GaveUp(Why::Rounding));
        }
    }
}
