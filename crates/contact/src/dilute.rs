//! Contact of few points: the pressure is sought on blocks of points where contact is possible, with compliance and
//! stiffness between these points only (`gfmd_response::Scattered`). All other points are checked by transforms of the
//! whole surface (theory.md, section 7.5).

mod candidates;
mod constants;
mod overlap;
mod points;

use std::ops::ControlFlow;

use candidates::Candidates;
use constants::{
    AT_ONCE, FIRST_CHECK_RESIDUAL, JOIN_GAP_PER_TOLERANCE, MAX_BLOCK_FRACTION, MAX_BLOCK_FRACTION_AT_START,
    MAX_ITERATIONS_BETWEEN_CHECKS, NEXT_CHECK_RESIDUAL, SMALL_GRID_POINTS,
};
use gfmd_relax::{Budget, Ending, PreconditionedCg, Progress, RelaxError, Target, Visit, Watch, Why};
use gfmd_response::{LANES, Scattered};
use gfmd_vector::Share;
use overlap::Overlap;
pub(crate) use points::{Gaps, Points, are_few, at_points, gathered};

use crate::Load;
use crate::attempt::MARGIN;
use crate::attempt::{Attempt, SolverResult};

/// Watcher of processes that take the same steps and stop together.
struct Unison<'a, W> {
    share: &'a Share,
    watch: W,
}

impl<W: Watch> Watch for Unison<'_, W> {
    fn see(&mut self, now: &Progress) -> ControlFlow<()> {
        let stop = self.watch.see(now).is_break();
        if self.share.any(stop) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        self.watch.checkpoint(variables);
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        self.watch.recall()
    }
}

/// Checkpoint of a search on blocks; the checkpoint of the search for their pressure follows it.
#[derive(Default)]
struct Checkpoint {
    tolerance: f64,
    approach: f64,
    places: Vec<usize>,
}

impl Checkpoint {
    /// Visits the checkpoint, which has at most `most` places.
    fn visit(&mut self, visitor: &mut dyn Visit, most: usize) {
        visitor.numbers(&mut [&mut self.tolerance, &mut self.approach]);
        let mut number = self.places.len() as u64;
        visitor.count(&mut number);
        self.places.resize((number as usize).min(most), 0);
        for place in &mut self.places {
            let mut number = *place as u64;
            visitor.count(&mut number);
            *place = (number as usize).min(most - 1);
        }
    }
}

/// Finds the pressure if few points touch. Without success, the pressure reached becomes the start of `attempt`.
/// `outer` visits the variables of the caller; `continued` is true if a checkpoint of this search is to be recalled.
pub(crate) fn solve(
    attempt: &mut Attempt,
    mut outer: impl FnMut(&mut dyn Visit),
    continued: bool,
) -> Result<Option<SolverResult>, RelaxError> {
    let contact = attempt.contact;
    let (response, surface) = (&contact.response, &contact.scaled);
    let suits = contact.free.is_none() && contact.hardness.is_none() && contact.springs.is_none();
    if !suits || surface.mean_clearance() == 0.0 {
        return Ok(None);
    }
    let Some(overlap) = Overlap::of(contact, attempt.load) else { return Ok(None) };
    let scale = attempt.length_scale;
    let finest = MARGIN * attempt.budget.tolerance;
    let blocks = contact.share.total() / LANES;
    let mut kept = match attempt.load {
        Load::MeanPressure(_) => Checkpoint::default(),
        Load::Approach(approach) => Checkpoint { approach, ..Checkpoint::default() },
    };
    let most = match attempt.watch.recall().filter(|_| continued) {
        Some(recalled) => {
            kept.visit(recalled, blocks);
            MAX_BLOCK_FRACTION
        }
        None => {
            kept.tolerance = finest.max(FIRST_CHECK_RESIDUAL * overlap.depth / scale);
            kept.places = Candidates::places(attempt, overlap);
            MAX_BLOCK_FRACTION_AT_START[usize::from(contact.share.total() > SMALL_GRID_POINTS)]
        }
    };
    if !are_few(&kept.places, most, contact.share.total()) {
        return Ok(None);
    }
    // Without a uniform mode in the search its compliance is zero.
    let Some(scattered) = Scattered::of(response, contact.level_under(attempt.load).unwrap_or_default()) else {
        return Ok(None);
    };
    let start = (std::mem::take(&mut kept.places), kept.approach);
    let (mut problem, mut x) = Candidates::new(attempt, scattered, start, overlap);
    loop {
        let left = attempt.budget_left();
        let budget = Budget {
            tolerance: kept.tolerance,
            max_iterations: left.max_iterations.min(MAX_ITERATIONS_BETWEEN_CHECKS),
        };
        let points = contact.share.total() as f64 / x.len() as f64;
        let mean = attempt.load.mean_pressure().map(|mean| mean * points);
        let target = Target { mean, gradient_scale: scale, budget };
        (kept.places, kept.approach) = problem.state();
        let is_finest = kept.tolerance == finest;
        problem.begin(is_finest);
        let minimum = {
            let watch = attempt.part_watch(false, |visitor: &mut dyn Visit| {
                outer(visitor);
                kept.visit(visitor, blocks);
            });
            PreconditionedCg.minimise(&mut problem, &mut x, &target, &mut Unison { share: &contact.share, watch })?
        };
        attempt.effort.iterations += minimum.reached.iteration;
        if minimum.ending == Ending::Interrupted {
            return Ok(Some(problem.ended(attempt, &x, minimum.ending)));
        }
        if minimum.ending != Ending::Converged {
            break;
        }
        problem.settle(&x);
        let survey = problem.survey(JOIN_GAP_PER_TOLERANCE * kept.tolerance * scale);
        if is_finest && survey.penetration <= finest * scale {
            return Ok(Some(problem.ended(attempt, &x, minimum.ending)));
        }
        let next = NEXT_CHECK_RESIDUAL * survey.deepest / scale;
        if next >= kept.tolerance.max(AT_ONCE * finest) {
            break;
        }
        kept.tolerance = if next < AT_ONCE * finest { finest } else { next };
        if !problem.revise(&survey, !is_finest, &mut x) {
            break;
        }
    }
    let ended = problem.ended(attempt, &x, Ending::GaveUp(Why::Iterations));
    (attempt.start, attempt.effort) = (Some(ended.reached.pressure), ended.effort);
    Ok(None)
}
