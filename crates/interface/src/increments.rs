//! Paths followed in given numbers of increments, with all their states.

use gfmd_contact::{Drive, SolveError, Solver};
use gfmd_relax::{Budget, Watch};

use gfmd_contact::{Quasistatic, Reading};

/// Follows a path from the undeformed surfaces, without an energy balance: each step leads to a drive in a number of
/// equal increments, at least one. Returns the states at the ends of all increments, each to the tolerance of the
/// budget. They are the states of a [`Path`](crate::Path) whose steps were divided into as many increments
/// ([`Step::increments`](crate::Step)), which solves them less exactly where they only lead to the end of a step.
///
/// # Errors
/// Returns the errors of the solver.
pub fn follow<P: Quasistatic>(
    problem: &P,
    steps: &[(Drive, u64)],
    budget: &Budget,
    watch: &mut dyn Watch,
) -> Result<Vec<P::State>, SolveError<P::State>> {
    let mut states: Vec<P::State> = Vec::new();
    for (drive, increments) in steps {
        let begin = states.last().map_or(Reading::UNLOADED, |state| problem.reading(state));
        for increment in 1..=(*increments).max(1) {
            let share = increment as f64 / (*increments).max(1) as f64;
            let drive = begin.towards(*drive, share);
            states.push(problem.equilibrate(drive, Solver::Auto, budget, states.last(), watch)?);
        }
    }
    Ok(states)
}
