//! Derivatives along a path, which is followed again.

use gfmd_contact::{Cotangents, Drive, Fields as _, SolveError};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_interface::{Path, PathGradient, Refinement, follow};
use gfmd_problem::{AnyState, Inelastic, OfState};

use super::{Args, path_input};

/// Derivatives of a number with respect to the input of a path.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// Derivatives, with one load and one lateral displacement for each step.
    pub gradient: PathGradient,
    /// Mean pressure and approach at the end of each step, followed again.
    pub reached: Vec<[f64; 2]>,
}

/// Computes the derivatives of a number along the path of the command. `of` returns its derivatives with respect to the
/// state of a step, from the number of the step and of the waypoint, if the step ends at one.
///
/// # Errors
/// Returns an error for unusable input, for a path without derivatives, and for a step that was not solved.
pub fn derivatives(
    args: &Args,
    of: impl Fn(usize, Option<usize>) -> Cotangents,
    session: &Session,
) -> Result<Derivatives, Failure> {
    let input = path_input(args, session)?;
    let (prepared, drives) = (&input.prepared, &input.drives);
    prepared.facts.check_gradient()?;
    let asked = args.asked()?;
    let contact = prepared.pose(asked.source, &prepared.law)?;
    // A first look names what has no derivative, before the path is followed.
    contact.gradient_along(&[])?;
    let Inelastic { shear, relaxation, wear, .. } = &prepared.inelastic;
    let has_history = shear.is_some() || relaxation.is_some() || wear.is_some() || prepared.hardness.is_some();
    let increments = match args.energy_solves() {
        solves_per_step if solves_per_step > 0 && has_history => {
            let refinement = Refinement { tolerance: args.energy_tolerance, solves_per_step };
            let mut path = Path::new(&contact, asked.budget, refinement);
            let made = drives.iter().map(|drive| Ok(path.step(*drive, &mut session.stop())?.increments.max(1)));
            made.collect::<Result<Vec<u64>, _>>().map_err(unsolved)?
        }
        _ => vec![1; drives.len()],
    };
    let steps: Vec<(Drive, u64)> = drives.iter().copied().zip(increments.iter().copied()).collect();
    let states = follow(&contact, &steps, &asked.budget, &mut session.stop()).map_err(unsolved)?;
    let of: Vec<Cotangents> = (0..drives.len()).map(|step| of(step, input.places.of(step))).collect();
    let (mut all, mut reached): (Vec<OfState<AnyState>>, _) = (Vec::new(), Vec::new());
    let mut states = states.iter();
    for ((step, of), count) in drives.iter().zip(&of).zip(&increments) {
        let of_step = |(increment, state)| (step.load, state, (increment + 1 == *count).then_some(of));
        all.extend((0..*count).zip(&mut states).map(of_step));
        reached.extend(all.last().map(|(_, state, _)| [state.mean_pressure(), state.approach()]));
    }
    let gradient = contact.gradient_along(&all)?.of_steps(&increments);
    Ok(Derivatives { gradient, reached })
}

/// Returns the failure of a step.
fn unsolved(error: SolveError<AnyState>) -> Failure {
    match error {
        SolveError::Refused(refusal) => refusal.into(),
        SolveError::Interrupted { .. } => Failure::interrupted("interrupted"),
        error => Failure::computation(error.to_string()),
    }
}
