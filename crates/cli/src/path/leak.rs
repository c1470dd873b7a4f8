//! Flow through the gap of a state on a path.

use gfmd_contact::Fields as _;
use gfmd_flow::{Flow, Wanted};
use gfmd_input::failure::Failure;
use gfmd_problem::AnyState;
use gfmd_record::StateContext;
use gfmd_run::flow::through;
use gfmd_run::series::Prepared;

/// Computes the flow through the gap of a state, if requested.
pub(super) fn leak(
    prepared: &Prepared,
    state: &AnyState,
    at: &StateContext,
    warn: impl FnOnce(String),
) -> Result<Option<Flow>, Failure> {
    let fields = [state.repulsion(), state.gap().into()];
    let [repulsion, gap] = [0, 1].map(|index| fields[index].view());
    let flow = || through(&prepared.surface, [repulsion, gap], at.summary.mean_gap, Wanted::Conductivity, warn);
    prepared.facts.flow.then(flow).transpose()
}
