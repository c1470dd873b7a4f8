//! Starts of a search: contacts with a hard wall, which the faster pressure solver finds.

use std::ops::Range;
use std::sync::Arc;

use gfmd_contact::{Contact, Drive, Equilibrium, Load, SolveError, Solver};
use gfmd_law::{HardWall, Opening};
use gfmd_relax::{Budget, Watch};
use gfmd_response::Elastic;
use gfmd_vector::{add, contiguous, for_each};
use ndarray::Array2;

use crate::numbers::{reduce, total};
use crate::{Interface, State};

/// Largest number of rounds with the attraction held. Measured: of 3 to 6 rounds, 4 take the fewest transform pairs
/// (loops of nine loads, 128 to 512 points along an axis).
const ROUNDS: usize = 4;
/// Change of the attraction in the last round, divided by the largest attraction. Chosen.
const SETTLED: f64 = 0.2;
/// Relative change of the load that the search follows as well from the last state. Chosen.
const SMALL: f64 = 0.1;
/// Tolerance of the contact in a round.
const TOLERANCE_OF_ROUND: f64 = 1e-2;

impl Interface {
    /// Solves the contact with a hard wall instead of the law, roughly. Returns `None` if a wall does not allow the
    /// drive: an approach beyond full contact, which is allowed without a wall.
    pub(crate) fn without_attraction(
        &self,
        drive: Drive,
        budget: &Budget,
        watch: &mut dyn Watch,
    ) -> Result<Option<State>, SolveError<State>> {
        let wall = Interface { law: Arc::new(HardWall), ..self.clone() };
        if wall.frame(drive).is_err() {
            return Ok(None);
        }
        let rough = Budget { tolerance: budget.tolerance.max(1e-3), ..*budget };
        // If a traction jumps with the gap, the state reached depends on every digit of the start.
        let is_smooth = self.law.stiffness_bound(0.0) > 0.0;
        if let Some(state) = is_smooth.then(|| wall.by_pressure(drive, None, &rough, watch)).flatten() {
            return Ok(Some(state));
        }
        wall.rest(drive, Solver::Newton, &rough, None, watch).map(Some)
    }

    /// Moves `start` towards the equilibrium under another mean pressure. Each round solves the contact with a hard
    /// wall under the attraction at the gaps found before. Where attraction does not grow with the gap, its potential
    /// lies below the tangent that replaces it: the energy falls all the way, and no barrier is crossed
    /// (majorise-minimise: Hunter and Lange, Am. Stat. 58 (2004) 30). Returns `None` for other laws and loads, and if
    /// the first round fails.
    pub(crate) fn with_attraction_held(
        &self,
        drive: Drive,
        budget: &Budget,
        start: &State,
        watch: &mut dyn Watch,
    ) -> Option<State> {
        let Load::MeanPressure(mean) = drive.load else { return None };
        let change = mean - start.mean_pressure;
        if change.abs() <= SMALL * mean.abs().max(start.mean_pressure.abs()) {
            return None;
        }
        if !self.law.has_wall() || self.gives_way() || self.law.stiffness_bound(0.0) == 0.0 {
            return None;
        }
        let budget = Budget { tolerance: budget.tolerance.max(TOLERANCE_OF_ROUND), ..*budget };
        let mut pull = self.pull(&start.gap)?;
        // Force on the points before a round: at first the change of the load.
        let mut force = vec![change; pull.len()];
        let mut found: Option<State> = None;
        for _ in 0..ROUNDS {
            let from = found.as_ref().unwrap_or(start);
            let Some(mut state) = self.by_pressure(drive, Some(&pull), &budget, watch) else { break };
            let Some(next) = self.pull(&state.gap) else { break };
            for_each([&mut pull[..]], &|start, [pull]| {
                pull.iter_mut().zip(&next[start..]).for_each(|(pull, next)| *pull = next - *pull);
            });
            // Work of the forces at both ends along the way: it grows where the curvature of the energy is negative.
            let (gaps, change) = ([contiguous(&from.gap), contiguous(&state.gap)], &pull);
            let works = |range: Range<usize>| {
                range.fold([0.0; 2], |sums, i| {
                    let step = gaps[0][i] - gaps[1][i];
                    add(sums, [step * force[i], step * change[i]])
                })
            };
            let [before, after] = reduce(&self.share, pull.len(), &works, &add);
            let largest = |values: &[f64]| {
                let of = |range: Range<usize>| values[range].iter().fold(0.0, |most: f64, value| most.max(value.abs()));
                reduce(&self.share, values.len(), &of, &f64::max)
            };
            let is_last = largest(&pull) <= SETTLED * largest(&next);
            // Where the attraction hardly changes, rounding errors would decide.
            state.passed_instability = !is_last && after > before.max(0.0);
            if let Some(found) = &found {
                state.passed_instability |= found.passed_instability;
                state.effort.transform_pairs += found.effort.transform_pairs;
            }
            (force, pull) = (pull, next);
            found = Some(state);
            if is_last {
                break;
            }
        }
        found
    }

    /// Returns the attraction at these gaps; `None` if it grows with the gap at a point.
    fn pull(&self, gap: &Array2<f64>) -> Option<Vec<f64>> {
        let gap = contiguous(gap);
        let [mut pull, mut slope] = [vec![0.0; gap.len()], vec![0.0; gap.len()]];
        for_each([&mut pull[..], &mut slope], &|start, [pull, slope]| {
            for ((pull, slope), gap) in pull.iter_mut().zip(slope).zip(&gap[start..]) {
                Opening { traction: *pull, slope: *slope, .. } = self.law.opening(gap.max(0.0));
            }
        });
        let grows = slope.iter().any(|slope| *slope > 0.0);
        (!self.share.any(grows)).then_some(pull)
    }

    /// Solves the contact of a periodic surface with a hard wall, in u_z alone, by the faster pressure solver; under a
    /// mean pressure also with an upward traction `pull`. Returns `None` if this fails, and with springs.
    fn by_pressure(&self, drive: Drive, pull: Option<&[f64]>, budget: &Budget, watch: &mut dyn Watch) -> Option<State> {
        let (Elastic::Normal(response), None, false) = (&self.elastic, &self.patch, self.has_springs()) else {
            return None;
        };
        // The search that follows finds and reports the same refusal or failure.
        let heights = self.surface.clearance().iter().map(|c| -c).collect();
        let (mut heights, mut load) = (Array2::from_shape_vec(self.surface.shape(), heights).ok()?, drive.load);
        let mut transforms = self.elastic.transforms();
        if let (Some(pull), Load::MeanPressure(pressure)) = (pull, &mut load) {
            let mut raised = vec![0.0; pull.len()];
            transforms.compliance(pull, &self.elastic.uniform_compliance(), &mut raised);
            heights.iter_mut().zip(&raised).for_each(|(height, u)| *height += u);
            *pressure += total(&self.share, pull) / self.share.total() as f64;
        }
        let mut contact = Contact::with_response(Arc::clone(response), &heights).ok()?;
        if let Some(hardness) = self.hardness_in(1.0) {
            contact = contact.with_hardness(hardness).ok()?;
        }
        let solution = contact.press(load).budget(*budget).watch(watch).solve().ok()?;
        let plastic = solution.plastic.as_ref().map(|plastic| &*plastic.depth);
        let mut state = self.certify_pressed_in(&solution.gap, &solution.pressure, plastic, drive).ok()?;
        state.effort.transform_pairs += solution.effort.transform_pairs + transforms.pairs();
        state.is_pressed = true;
        state.wall_pressure = solution.pressure;
        Some(state)
    }
}
