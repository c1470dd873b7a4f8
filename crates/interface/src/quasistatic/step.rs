//! One step of a contact: the normal contact under the last shear, and the shear within the limits set by the
//! pressure, are solved in turn until both agree (Panagiotopoulos 1975). Without shear the normal contact is solved
//! once.

use gfmd_contact::{Drive, Effort, Fields as _, Load, Refusal, SolveError, Solver, Springs, judge};
use gfmd_medium::{Affine, Memory, Stiffening};
use gfmd_relax::{Budget, Ending, Progress, Watch, Why};
use gfmd_vector::{contiguous, lower};
use ndarray::Array2;

use super::normal::{Normal, NormalState};
use super::shear::{Effect, ShearStep, Sheared};
use super::{QuasistaticContact, QuasistaticState, check_order};
use crate::numbers::reduce;

/// Relative rounding error below which an approach counts as zero.
const ROUNDING_OF_APPROACH: f64 = 8.0 * f64::EPSILON;

/// Maximum number of rounds of normal contact and shear.
const ROUNDS: usize = 150;
/// Final tolerance of either problem divided by the tolerance of the contact.
const SHARE: f64 = 0.1;
/// Tolerance of either problem divided by the previous residual of the contact. A round reduces the residual to about a
/// fifth, so that the next round would change more accurate results; with larger values slabs take more rounds.
const SHARE_OF_RESIDUAL: f64 = 0.075;
/// Tolerance of both problems in the first round, and upper limit for the later ones.
const FIRST_ROUND_TOLERANCE: f64 = 1e-3;
/// Largest fraction of a prescribed approach that lies within the tolerance of a round.
const OF_THE_APPROACH: f64 = 0.1;

/// Step during its solution. Tractions are divided by the common stiffening of the step. The normal contact does not
/// know the depths that the step begins with and the lift by the shear: they are part of its clearance, and its
/// approach is measured from first touch of these surfaces where they may be deep.
pub(super) struct Step<'a> {
    pub(super) contact: &'a QuasistaticContact,
    pub(super) drive: Drive,
    pub(super) start: Option<&'a QuasistaticState>,
    /// Memory at the start, of a body with memory.
    pub(super) memory: Option<Memory>,
    pub(super) affine: Affine,
    /// Sliding distance of the step.
    pub(super) moved: f64,
    /// Normal contact of the undeformed surfaces on the body of the step.
    normal: Normal,
    /// Depth of the surfaces at the start of the step: worn off, pressed in, and not yet recovered by the body. `None`
    /// for surfaces that keep none.
    depth: Option<Array2<f64>>,
    /// Lateral displacement not yet recovered by the body, below a law that moves all components; empty without memory.
    pub(super) sideways: Vec<f64>,
    pub(super) shear: Option<ShearStep>,
}

/// Result of the normal contact.
struct Pressed {
    state: NormalState,
    /// First touch, from which its approach is measured.
    touch: f64,
    /// True if the surfaces are apart, which needs no search.
    is_apart: bool,
    failed: Option<SolveError<()>>,
}

/// Fields reached by a step. Tractions are divided by the common stiffening of the step.
pub(super) struct Reached {
    pub(super) normal: NormalState,
    /// First touch, from which the approach of `normal` is measured.
    pub(super) touch: f64,
    /// Depth of the elastic surface at zero pressure, which the displacement of `normal` does not contain.
    pub(super) unpressed: Option<Array2<f64>>,
    pub(super) sheared: Option<Sheared>,
    /// Depth worn off in the step.
    pub(super) worn: Option<Array2<f64>>,
}

impl<'a> Step<'a> {
    pub(super) fn new(
        contact: &'a QuasistaticContact,
        drive: Drive,
        start: Option<&'a QuasistaticState>,
    ) -> Result<Self, Refusal> {
        let [time, distance] = start.map_or([0.0; 2], |start| [start.time, start.distance]);
        check_order(drive, [time, distance])?;
        let (memory, affine) = match &contact.medium {
            Some(medium) => {
                let memory = match start {
                    Some(start) => start.memory.clone().ok_or(Refusal::OtherKind)?,
                    None => medium.rest(),
                };
                let affine = medium.begin(&memory, drive.time - time)?;
                (Some(memory), affine)
            }
            None => {
                let stiffening = Stiffening::All(1.0);
                (None, Affine { residual_indentation: Vec::new(), stiffening, duration: drive.time - time })
            }
        };
        let points = contact.points();
        let normal = contact.normal.stiffened(&affine.stiffening)?;
        let sideways = match (&contact.medium, contact.all_components) {
            (Some(_), true) => {
                let lateral = &affine.residual_indentation[..affine.residual_indentation.len() - points];
                lateral.iter().map(|depth| -depth).collect()
            }
            _ => Vec::new(),
        };
        let normal = match (&sideways[..], &contact.sideways[..]) {
            ([], []) => normal,
            (own, []) | ([], own) => normal.displaced_sideways(own)?,
            (own, base) => {
                normal.displaced_sideways(&own.iter().zip(base).map(|(own, base)| own + base).collect::<Vec<f64>>())?
            }
        };
        let keeps_depth = contact.medium.is_some() || contact.wear.is_some() || contact.hardness.is_some();
        let depth = keeps_depth.then(|| {
            let mut depth = match &contact.medium {
                Some(_) => {
                    contact.field(affine.residual_indentation[affine.residual_indentation.len() - points..].to_vec())
                }
                None => contact.field(vec![0.0; points]),
            };
            start.iter().flat_map(|start| start.worn.iter().chain(&start.pressed_in)).for_each(|more| depth += more);
            depth
        });
        let shear = contact.response.as_ref().map(|response| ShearStep::new(contact, response, drive, start, &affine));
        let moved = drive.distance - distance;
        Ok(Self { contact, drive, start, memory, affine, moved, normal, depth, sideways, shear: shear.transpose()? })
    }

    /// Returns the depth of the surfaces, `grown` in the step, and without the lift by the shear.
    fn depth_with(&self, grown: Option<&Array2<f64>>, effect: Effect) -> Option<Array2<f64>> {
        let mut depth = match (&self.depth, &self.shear) {
            (None, None) => return None,
            (Some(depth), _) => depth.clone(),
            (None, Some(_)) => self.contact.field(vec![0.0; self.contact.points()]),
        };
        if let Some(grown) = grown {
            depth += grown;
        }
        if let Some(shear) = &self.shear {
            depth.iter_mut().zip(shear.lift(effect)).for_each(|(depth, lift)| *depth -= lift);
        }
        Some(depth)
    }

    /// Returns the depth of the elastic surface at zero pressure: not yet recovered, less the lift by the shear.
    pub(super) fn unpressed(&self, effect: Effect) -> Option<Array2<f64>> {
        let (points, base) = (self.contact.points(), &self.affine.residual_indentation);
        let mut depth = self.contact.medium.as_ref().map(|_| base[base.len() - points..].to_vec());
        if let Some(shear) = &self.shear {
            let depth = depth.get_or_insert_with(|| vec![0.0; points]);
            depth.iter_mut().zip(shear.lift(effect)).for_each(|(depth, lift)| *depth -= lift);
        }
        depth.map(|depth| self.contact.field(depth))
    }

    /// Returns the normal `contact` at a depth, and first touch, from which it measures its approach.
    fn at(&self, contact: Normal, depth: Option<&Array2<f64>>) -> Result<(Normal, f64), Refusal> {
        let Some(depth) = depth else { return Ok((contact, 0.0)) };
        let is_worn = self.contact.wear.is_some();
        let is_driven = matches!(self.drive.load, Load::Approach(_));
        if !(is_worn || self.contact.medium.is_some() || self.contact.hardness.is_some() && is_driven) {
            return Ok((contact.with_depth(depth, false)?, 0.0));
        }
        let (clearance, values) = (self.contact.normal.surface().clearance(), &*contiguous(depth));
        let lowest = |range: std::ops::Range<usize>| {
            range.fold(f64::INFINITY, |least, i| lower(least, clearance.at(i) + values[i]))
        };
        let touch = reduce(self.contact.share(), values.len(), &lowest, &lower);
        // Without the subtraction, endless wear would leave no digits of the roughness.
        Ok((contact.with_depth(&depth.mapv(|depth| depth - touch), is_worn)?, touch))
    }

    /// Returns the springs that stand for the wear during the step, with this length of the slip at each point.
    pub(super) fn springs(&self, slipped: &[f64]) -> Option<Springs> {
        let wear = self.contact.wear?;
        let factor = self.affine.factor();
        let by_distance = factor * (wear.by_distance * self.moved);
        match slipped {
            [_, ..] => {
                let of = |slip: &f64| by_distance + factor * wear.by_slip * slip;
                Some(Springs::Field(self.contact.field(slipped.iter().map(of).collect())))
            }
            [] => (by_distance > 0.0).then_some(Springs::Uniform(by_distance)),
        }
    }

    /// Computes the depth worn off in the step by a state with the present shear; `None` if the surfaces do not wear.
    fn worn_by(&mut self, state: &NormalState) -> Option<Array2<f64>> {
        self.contact.wear?;
        let repulsion = state.repulsion();
        let slipped = self.shear.as_mut().map_or_else(Vec::new, |shear| shear.slipped_by(state));
        Some(match self.springs(&slipped) {
            None => Array2::zeros(repulsion.raw_dim()),
            Some(Springs::Uniform(compliance)) => repulsion.mapv(|r| compliance * r),
            Some(Springs::Field(compliance)) => compliance * &repulsion,
        })
    }

    /// Returns the drive of the normal contact with this first touch, and true if its surfaces are apart.
    fn drive_from(&self, touch: f64) -> (Drive, bool) {
        let (load, is_apart) = match self.drive.load {
            Load::MeanPressure(mean) => {
                let is_apart = mean == 0.0 && matches!(self.normal, Normal::Wall(_));
                (Load::MeanPressure(mean / self.affine.factor()), is_apart)
            }
            Load::Approach(approach) => {
                let mut size = approach.abs().max(touch.abs());
                if self.contact.medium.is_some() {
                    size = size.max(self.contact.normal.surface().rms_height());
                }
                let beyond = approach - touch;
                let may_part = matches!(self.normal, Normal::Wall(_));
                let is_apart = may_part && beyond <= ROUNDING_OF_APPROACH * size;
                (Load::Approach(if is_apart { beyond.min(0.0) } else { beyond }), is_apart)
            }
        };
        let lateral = if self.contact.all_components { self.drive.lateral } else { [0.0; 2] };
        (Drive { lateral, ..load.into() }, is_apart)
    }

    /// Returns the normal contact of the step under the last shear, and first touch, from which it measures its
    /// approach.
    pub(super) fn normal(&self) -> Result<(Normal, f64), Refusal> {
        let contact = match self.springs(self.shear.as_ref().map_or(&[], |shear| &shear.slipped)) {
            Some(springs) => self.normal.softened(springs)?,
            None => self.normal.clone(),
        };
        self.at(contact, self.depth_with(None, Effect::Assumed).as_ref())
    }

    /// Solves the normal contact, from the state `warm` with its tractions and measured from the undeformed surfaces.
    fn press(
        &self,
        solver: Solver,
        budget: &Budget,
        warm: Option<&NormalState>,
        watch: &mut dyn Watch,
    ) -> Result<Pressed, Refusal> {
        let (contact, touch) = self.normal()?;
        let (drive, is_apart) = self.drive_from(touch);
        if is_apart {
            return Ok(Pressed { state: contact.unloaded(drive.load)?, touch, is_apart, failed: None });
        }
        let unpressed = self.unpressed(Effect::Assumed);
        let warm = warm.map(|state| state.to_step(self.affine.factor(), (unpressed.as_ref(), &self.sideways), touch));
        let (mut reached, mut failed) = (None, None);
        match contact.equilibrate(drive, solver, budget, warm.as_ref(), watch) {
            Ok(state) => reached = Some(state),
            Err(SolveError::Refused(refusal)) => return Err(refusal),
            Err(error) => failed = Some(error.map(|state| reached = Some(state))),
        }
        Ok(Pressed { state: reached.ok_or(Refusal::OtherKind)?, touch, is_apart, failed })
    }

    /// Computes what the step has reached with the pressure and the present shear, from fresh transforms.
    fn certify(&mut self, Pressed { state: mut normal, mut touch, is_apart, .. }: Pressed) -> Result<Reached, Refusal> {
        let worn = self.worn_by(&normal);
        // Below a law the depth pressed in is known, and becomes part of the surfaces like the depth worn off.
        let pressed_in = normal.law().and_then(|state| state.pressed_in.clone());
        if self.shear.is_some() || worn.is_some() || pressed_in.is_some() {
            let Effort { iterations, transform_pairs } = *normal.effort();
            let grown = match (&worn, &pressed_in) {
                (Some(worn), Some(pressed_in)) => Some(worn + pressed_in),
                (worn, pressed_in) => worn.as_ref().or(pressed_in.as_ref()).cloned(),
            };
            let (contact, first) =
                self.at(self.normal.clone(), self.depth_with(grown.as_ref(), Effect::Present).as_ref())?;
            let (drive, _) = self.drive_from(first);
            normal = if is_apart { contact.unloaded(drive.load)? } else { contact.certify(&normal, drive)? };
            if let NormalState::Law(state) = &mut normal {
                state.pressed_in = pressed_in;
            }
            let effort = normal.effort();
            effort.iterations += iterations;
            effort.transform_pairs += transform_pairs;
            touch = first;
        }
        let unpressed = self.unpressed(Effect::Present);
        let length = self.length(&normal);
        let sheared = self.shear.as_mut().map(|shear| shear.certify(&normal, length));
        Ok(Reached { normal, touch, unpressed, sheared, worn })
    }

    /// Computes what a step without shear reaches with a gap below a law, or a pressure at a wall.
    pub(super) fn reached(&self, (gap, pressure): (&Array2<f64>, &Array2<f64>)) -> Result<Reached, Refusal> {
        let (contact, touch) = self.at(self.normal.clone(), self.depth_with(None, Effect::Present).as_ref())?;
        let (drive, _) = self.drive_from(touch);
        let normal = contact.certify_fields((gap, pressure), drive)?;
        let worn = self.contact.wear.map(|_| Array2::zeros(gap.raw_dim()));
        Ok(Reached { normal, touch, unpressed: None, sheared: None, worn })
    }

    /// Returns the length scale of residuals.
    fn length(&self, state: &NormalState) -> f64 {
        match (state, &self.normal) {
            (NormalState::Wall(solution), _) => solution.length_scale(),
            (NormalState::Law(_), Normal::Law(interface)) => interface.length_scale(),
            (NormalState::Law(_), Normal::Wall(contact)) => contact.surface().rms_height(),
        }
    }

    /// Solves the step, with a search from the state `near` its end if it is given, else from the start.
    pub(super) fn solve(
        mut self,
        solver: Solver,
        budget: &Budget,
        near: Option<&QuasistaticState>,
        watch: &mut dyn Watch,
    ) -> Result<QuasistaticState, SolveError<QuasistaticState>> {
        if self.shear.is_some() {
            return self.alternate(solver, budget, near, watch);
        }
        let mut pressed = self.press(solver, budget, near.or(self.start).map(|start| &start.normal), watch)?;
        let failed = pressed.failed.take();
        let is_law = matches!(self.normal, Normal::Law(_));
        let is_new = self.contact.wear.is_some() || self.contact.hardness.is_some() && is_law;
        let reached = self.certify(pressed)?;
        let state = self.contact.end(&self, reached)?;
        match failed {
            None if is_new => judge(state, Ending::Converged, budget.tolerance),
            None => Ok(state),
            Some(SolveError::NotConverged { why, .. }) if is_new => judge(state, Ending::GaveUp(why), budget.tolerance),
            Some(error) => Err(error.map(|()| state)),
        }
    }

    /// Solves the normal contact and the shear in turn.
    fn alternate(
        mut self,
        solver: Solver,
        budget: &Budget,
        near: Option<&QuasistaticState>,
        watch: &mut dyn Watch,
    ) -> Result<QuasistaticState, SolveError<QuasistaticState>> {
        let mut effort = Effort::default();
        let mut tolerance = self.coarsest(self.contact.normal.surface().length_scale(self.drive.load));
        if let Some((shear, near)) = self.shear.as_mut().zip(near) {
            let sheared = near.sheared.as_ref().ok_or(Refusal::OtherKind)?;
            shear.place(&sheared.traction, &sheared.slip);
            tolerance = tolerance.min(SHARE_OF_RESIDUAL * near.worst());
        }
        let mut last: Option<QuasistaticState> = None;
        for _ in 0..ROUNDS {
            let part = Budget {
                tolerance: tolerance.max(SHARE * budget.tolerance),
                max_iterations: budget.max_iterations.saturating_sub(effort.iterations),
            };
            let before = effort.iterations;
            let mut part_watch = |now: &Progress| watch.see(&Progress { iteration: before + now.iteration, ..*now });
            let warm = last.as_ref().or(near).or(self.start).map(|state| &state.normal);
            let mut pressed = self.press(solver, &part, warm, &mut part_watch)?;
            let Effort { iterations, transform_pairs } = std::mem::take(pressed.state.effort());
            effort.iterations += iterations;
            effort.transform_pairs += transform_pairs;
            let mut ending = match pressed.failed.take() {
                None => Ending::Converged,
                Some(SolveError::Interrupted { .. }) => Ending::Interrupted,
                // The next round may do better, from a pressure whose rounding errors differ.
                Some(SolveError::NotConverged { why: Why::NoDescent | Why::Rounding | Why::Certificate, .. }) => {
                    Ending::Converged
                }
                Some(SolveError::NotConverged { why, .. }) => Ending::GaveUp(why),
                Some(SolveError::Refused(refusal)) => return Err(refusal.into()),
                Some(error @ SolveError::Detached { .. }) => {
                    let reached = self.certify(pressed)?;
                    let state = self.contact.end(&self, reached)?;
                    return Err(error.map(|()| state));
                }
            };
            if ending == Ending::Converged {
                let before = effort.iterations;
                let mut part_watch =
                    |now: &Progress| watch.see(&Progress { iteration: before + now.iteration, ..*now });
                let length = self.length(&pressed.state);
                if let Some(shear) = &mut self.shear {
                    let slid = shear.slide(&pressed.state, length, &part, &mut part_watch);
                    effort.iterations += slid.steps;
                    if slid.ending == Ending::Interrupted {
                        ending = Ending::Interrupted;
                    }
                }
            }
            let reached = self.certify(pressed)?;
            let length = self.length(&reached.normal);
            effort.transform_pairs += reached.normal.clone().effort().transform_pairs;
            let mut state = self.contact.end(&self, reached)?;
            let of_shear = self.shear.as_ref().map_or(0.0, ShearStep::pairs);
            *state.normal.effort() = Effort { transform_pairs: effort.transform_pairs + of_shear, ..effort };
            if ending != Ending::Converged {
                return judge(state, ending, budget.tolerance);
            }
            let worst = state.worst();
            if worst <= budget.tolerance {
                self.check_shear(budget.tolerance)?;
                return Ok(state);
            }
            tolerance = self.coarsest(length).min(SHARE_OF_RESIDUAL * worst);
            last = Some(state);
        }
        judge(last.ok_or(Refusal::OtherKind)?, Ending::GaveUp(Why::Circles), budget.tolerance)
    }

    /// Returns the tolerance of a first round, for residuals relative to `length`. A surface moved by a prescribed
    /// approach must not count as solved without pressure.
    fn coarsest(&self, length: f64) -> f64 {
        match self.drive.load {
            Load::Approach(approach) if approach > 0.0 => {
                FIRST_ROUND_TOLERANCE.min(OF_THE_APPROACH * approach / length)
            }
            _ => FIRST_ROUND_TOLERANCE,
        }
    }

    /// Checks that the displacement caused by the shear can be resolved. On a thin plate it may be much larger than the
    /// roughness.
    fn check_shear(&self, tolerance: f64) -> Result<(), Refusal> {
        let Some(shear) = &self.shear else { return Ok(()) };
        let surface = self.contact.normal.surface();
        surface.check_traction("shear traction", shear.largest(), shear.softest, tolerance)
    }
}
