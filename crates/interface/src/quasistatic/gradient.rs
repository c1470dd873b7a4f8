//! Derivatives along a path: each increment is one linear problem, and the histories pass the derivatives back to the
//! increments before (theory.md, section 7.9).

use gfmd_contact::{ClearanceGradient, Cotangents, Drive, Effort, Fields as _, GradientError, Load, Refusal, Springs};
use gfmd_medium::MemoryDerivatives;
use gfmd_relax::Anderson;
use gfmd_vector::total;
use ndarray::{Array2, ArrayRef2, Zip};

use super::normal::{Normal, NormalState};
use super::shear::Effect;
use super::shear::adjoint::{ByShear, ShearAdjoint, ShearGradient};
use super::step::Step;
use super::{QuasistaticContact, QuasistaticState, Wear};
use crate::gradient::EXACT;

/// Largest change of the last round of pressure and shear, relative to the derivatives by the pressure.
const TOLERANCE: f64 = 1e-10;
/// Maximum number of rounds of pressure and shear, and number of rounds that are mixed.
const ROUNDS: u64 = 100;
const DEPTH: usize = 5;
/// Largest relative residual of a round.
const LOOSEST: f64 = 0.1;
/// Largest error of a result.
const ERROR: f64 = 1e-8;

const NO_WEAR: Wear = Wear { by_distance: 0.0, by_slip: 0.0 };

/// An increment of a path, with the derivatives of a number L with respect to the state at its end.
#[derive(Clone, Copy, Debug)]
pub struct Increment<'a> {
    /// Load of the increment; only its kind matters.
    pub load: Load,
    /// State at the end.
    pub state: &'a QuasistaticState,
    /// Derivatives of L with respect to this state; `None` if L does not depend on it.
    pub of: Option<&'a Cotangents>,
}

/// Derivatives of a number L with respect to the input of a path, with the points in contact, at the hardness, sticking
/// and slipping in each increment kept, at the same times and sliding distances.
#[derive(Clone, Debug, PartialEq)]
pub struct PathGradient {
    /// Derivative with respect to the height of each point, peaks towards the body.
    pub heights: Array2<f64>,
    /// Derivative with respect to the load of each increment, its prescribed mean pressure or approach.
    pub loads: Vec<f64>,
    /// Derivative with respect to the lateral displacement at the end of each increment, along x and y; 0 without
    /// shear.
    pub lateral: Vec<[f64; 2]>,
    /// Derivative with respect to E*, with all moduli of the body in proportion, for the same loads, law, limit of the
    /// shear, hardness and wear.
    pub modulus: f64,
    /// Derivative with respect to the friction coefficient; 0 if it limits no shear.
    pub friction: f64,
    /// Derivative with respect to the shear strength; 0 if it limits no shear.
    pub shear_strength: f64,
    /// Derivative with respect to the hardness of each point; `None` without a hardness.
    pub hardness: Option<Array2<f64>>,
    /// Derivatives with respect to the wear coefficients; 0 without wear.
    pub wear: Wear,
    /// Largest relative error of the linear problems, from their residuals with fresh transforms.
    pub error: f64,
    /// Effort of all linear problems.
    pub effort: Effort,
}

impl PathGradient {
    /// Returns the derivatives with respect to the loads and lateral displacements of steps made of this many equal
    /// `increments` each, all loads of one kind; the first step begins without a load, at rest.
    #[must_use]
    pub fn of_steps(self, increments: &[u64]) -> Self {
        let loads = by_steps(&self.loads, increments);
        let [x, y] =
            [0, 1].map(|axis| by_steps(&self.lateral.iter().map(|by| by[axis]).collect::<Vec<f64>>(), increments));
        Self { loads, lateral: x.into_iter().zip(y).map(Into::into).collect(), ..self }
    }
}

/// Returns the derivatives with respect to the ends of steps made of this many equal `increments` each.
fn by_steps(by_increments: &[f64], increments: &[u64]) -> Vec<f64> {
    let (mut by_step, mut of_increments) = (vec![0.0; increments.len()], by_increments.iter());
    for (step, count) in increments.iter().map(|count| (*count).max(1)).enumerate() {
        for (increment, by) in (1..=count).zip(&mut of_increments) {
            let share = increment as f64 / count as f64;
            by_step[step] += share * by;
            if step > 0 {
                by_step[step - 1] += (1.0 - share) * by;
            }
        }
    }
    by_step
}

/// Reasons why a path has no derivative.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PathGradientError {
    /// The path begins with a state that is not among the increments.
    #[error(
        "the first increment ends at the time {found}; it must end at time 0, since a law draws the surfaces together \
         there on a body that relaxes"
    )]
    Drawn {
        /// Time of the first state.
        found: f64,
    },
    /// An increment has no derivative.
    #[error("increment {increment}: {reason}")]
    Increment {
        /// Number of the increment, from 1.
        increment: usize,
        /// Reason.
        reason: GradientError,
    },
    /// The contact has no derivative.
    #[error(transparent)]
    Contact(GradientError),
    /// A state does not belong to the contact, or does not follow the one before.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// Derivatives with respect to the histories at the start of an increment, in the units of the solve.
#[derive(Default)]
struct Histories {
    memory: Option<MemoryDerivatives>,
    /// With respect to the depth worn off; `None` if nothing depends on it.
    worn: Option<Array2<f64>>,
    /// With respect to the depth pressed in; `None` if nothing depends on it.
    pressed_in: Option<Array2<f64>>,
    /// With respect to the lateral displacement of the elastic surface; empty if nothing depends on it.
    sideways: Vec<f64>,
}

/// Derivatives of one increment, in the units of the solve.
struct OfIncrement {
    clearance: Array2<f64>,
    load: f64,
    /// With respect to the lateral displacement in the increment.
    moved: [f64; 2],
    /// With respect to the logarithm of E*.
    modulus: f64,
    /// With respect to the friction coefficient and the shear strength.
    limit: [f64; 2],
    hardness: Option<Array2<f64>>,
    wear: Wear,
    error: f64,
    effort: Effort,
}

/// Reason why an increment has no derivative.
enum Reason {
    Refused(Refusal),
    None(GradientError),
}

impl From<Refusal> for Reason {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl From<GradientError> for Reason {
    fn from(error: GradientError) -> Self {
        Self::None(error)
    }
}

/// Solved increment: its step, its normal contact, and the state of this contact, in divided tractions.
struct Solved<'a> {
    step: Step<'a>,
    end: &'a QuasistaticState,
    contact: Normal,
    normal: NormalState,
    /// Depth of the elastic surface at zero pressure.
    unpressed: Option<Array2<f64>>,
    /// Compliance that stands for the wear.
    springs: Option<Springs>,
    /// Length of the slip of each point; empty unless the surfaces wear by slip.
    slipped: Vec<f64>,
    /// Repulsion, not divided.
    repulsion: Array2<f64>,
}

/// Derivatives of a number with respect to the state at the end of an increment, and what they contribute to the
/// derivatives with respect to its input. Tractions are divided.
struct AtEnd {
    /// With respect to the state of the normal contact.
    normal: Cotangents,
    /// With respect to the shear traction, and to the lateral displacement of the elastic surface.
    shear: Vec<f64>,
    sideways: Vec<f64>,
    /// With respect to the depths worn off and pressed in; `None` if nothing depends on them.
    worn: Option<Array2<f64>>,
    pressed_in: Option<Array2<f64>>,
    /// With respect to the memory at the start, for a fixed indentation at the end.
    memory: Option<MemoryDerivatives>,
    clearance: Array2<f64>,
    modulus: f64,
}

impl QuasistaticContact {
    /// Computes the derivatives of a number along a path, from its derivatives with respect to the states at the ends
    /// of all `increments`, which begin with the undeformed surfaces. Each increment follows from the one before; if a
    /// [`Path`](crate::Path) divides its steps, all increments of the division are needed. Points in contact, at the
    /// hardness, sticking and slipping are kept, as they are for almost all heights and loads. A body that relaxes,
    /// depths worn off and pressed in, and the places where points stick pass the derivatives back from increment to
    /// increment.
    ///
    /// # Errors
    /// Returns an error for a law that moves all components, for derivatives that differ in shape, are not finite or
    /// belong to fields that the contact does not have, and for an increment without derivatives (as
    /// [`Contact::gradient`](gfmd_contact::Contact::gradient) and [`Interface::gradient`](crate::Interface::gradient)).
    pub fn gradient_along(&self, increments: &[Increment<'_>]) -> Result<PathGradient, PathGradientError> {
        self.check_gradient(increments)?;
        let (length, stress, energy) = (self.units.length(), self.units.stress(), self.units.energy());
        let shape = self.normal.surface().grid().points();
        let (mut clearance, mut histories) = (Array2::zeros(shape), Histories::default());
        let mut hardness = self.hardness.as_ref().map(|_| Array2::zeros(shape));
        let (mut loads, mut lateral) = (vec![0.0; increments.len()], vec![[0.0; 2]; increments.len()]);
        let (mut modulus, mut limit, mut wear) = (0.0, [0.0; 2], NO_WEAR);
        let (mut error, mut effort) = (0.0_f64, Effort::default());
        for (index, increment) in increments.iter().enumerate().rev() {
            let start = index.checked_sub(1).map(|before| self.in_units(increments[before].state));
            let end = self.in_units(increment.state);
            let of = increment.of.cloned().unwrap_or_default();
            let of = Cotangents {
                pressure: of.pressure.map(|by| by * stress),
                gap: of.gap.map(|by| by * length),
                approach: of.approach * length,
                mean_pressure: of.mean_pressure * stress,
                mean_gap: of.mean_gap * length,
                elastic_energy: of.elastic_energy * energy,
                plastic_depth: of.plastic_depth.map(|by| by * length),
                shear: of.shear.map(|by| by * stress),
                mean_shear: of.mean_shear.map(|by| by * stress),
            };
            let found = self.transposed(increment.load, (start.as_ref(), &end), of, &mut histories);
            let found = found.map_err(|reason| match reason {
                Reason::Refused(refusal) => PathGradientError::Refused(refusal),
                Reason::None(reason) => PathGradientError::Increment { increment: index + 1, reason },
            })?;
            clearance += &found.clearance;
            loads[index] = match increment.load {
                Load::MeanPressure(_) => found.load / stress,
                Load::Approach(_) => found.load / length,
            };
            for (axis, by) in found.moved.into_iter().enumerate() {
                lateral[index][axis] += by / length;
                if let Some(before) = index.checked_sub(1) {
                    lateral[before][axis] -= by / length;
                }
            }
            modulus += found.modulus;
            limit.iter_mut().zip(found.limit).for_each(|(sum, by)| *sum += by);
            if let (Some(sum), Some(by)) = (&mut hardness, found.hardness) {
                sum.scaled_add(stress.recip(), &by);
            }
            wear.by_distance += found.wear.by_distance * stress;
            wear.by_slip += found.wear.by_slip * stress;
            error = error.max(found.error);
            effort.iterations += found.effort.iterations;
            effort.transform_pairs += found.effort.transform_pairs;
        }
        let heights = self.scaled.by_heights(&clearance) / length;
        let (modulus, [friction, strength]) = (modulus / self.contact_modulus, limit);
        let shear_strength = strength / stress;
        Ok(PathGradient { heights, loads, lateral, modulus, friction, shear_strength, hardness, wear, error, effort })
    }

    /// Returns the number of lateral components of the shear between the surfaces.
    fn sheared_components(&self) -> usize {
        self.response.as_ref().map_or(0, |response| response.components().len() - 1)
    }

    /// Checks that the contact, the states and the derivatives have what a gradient needs.
    fn check_gradient(&self, increments: &[Increment<'_>]) -> Result<(), PathGradientError> {
        if self.all_components {
            return Err(PathGradientError::Contact(GradientError::Components));
        }
        let shape = self.normal.surface().grid().points();
        for (index, Increment { state, of, .. }) in increments.iter().enumerate() {
            let found = state.gap().len();
            if found != self.points() {
                return Err(Refusal::Start { found, expected: self.points() }.into());
            }
            if let Some(of) = of {
                let checked = of.check(shape, self.hardness.is_some(), self.sheared_components());
                checked.map_err(|reason| PathGradientError::Increment { increment: index + 1, reason })?;
            }
        }
        match increments.first() {
            Some(first) if first.state.time > 0.0 && self.is_drawn() => {
                Err(PathGradientError::Drawn { found: first.state.time })
            }
            _ => Ok(()),
        }
    }

    /// Transposes the increment from `start` to `end`: from the derivatives `of` the state and `histories` at its end,
    /// computes those with respect to its input, and replaces the `histories` by those at the start.
    fn transposed(
        &self,
        load: Load,
        (start, end): (Option<&QuasistaticState>, &QuasistaticState),
        of: Cotangents,
        histories: &mut Histories,
    ) -> Result<OfIncrement, Reason> {
        let load = match load {
            Load::MeanPressure(_) => Load::MeanPressure(end.mean_pressure()),
            Load::Approach(_) => Load::Approach(end.approach()),
        };
        let drive = Drive { distance: end.distance, lateral: end.lateral, ..Drive::from(load).at(end.time) };
        let mut solved = Solved::new(Step::new(self, drive, start)?, end)?;
        let (factor, moved) = (solved.step.affine.factor(), solved.step.moved);
        let mut at_end = self.at_end(&solved, of, std::mem::take(histories))?;
        let (found, sheared) = solved.transpose(load, &at_end)?;
        let ClearanceGradient { clearance: by_step, load: by_load, modulus: by_modulus, hardness, error, effort } =
            found;
        let mut modulus = at_end.modulus + by_modulus * self.contact_modulus / self.units.modulus();
        let wear = match self.wear {
            Some(_) => {
                let by = solved.by_compliance(&by_step, at_end.worn.as_ref());
                let slipped = solved.slipped.iter().zip(&by).map(|(slipped, by)| slipped * by).sum();
                Wear { by_distance: moved * total(&by), by_slip: slipped }
            }
            None => NO_WEAR,
        };
        // Residual indentation and depths lost before are parts of the clearance.
        if let (Some(medium), Some(at_start)) = (&self.medium, &mut at_end.memory) {
            let lateral = sheared.as_ref().map_or(&[][..], |sheared| &sheared.base);
            let by_residual: Vec<f64> = lateral.iter().chain(&by_step).copied().collect();
            medium.begin_transposed(&by_residual, solved.step.affine.duration, at_start)?;
        }
        for (is_kept, by) in
            [(self.wear.is_some(), &mut at_end.worn), (self.hardness.is_some(), &mut at_end.pressed_in)]
        {
            if is_kept {
                *by.get_or_insert_with(|| Array2::zeros(by_step.raw_dim())) += &by_step;
            }
        }
        let (mut by_moved, mut limit, mut sideways) = ([0.0; 2], [0.0; 2], Vec::new());
        if let Some(sheared) = sheared {
            let fields = sheared.stuck.chunks_exact(self.points());
            by_moved.iter_mut().zip(fields).for_each(|(sum, by)| *sum = total(by));
            modulus += sheared.modulus;
            (limit, sideways) = (sheared.limit, sheared.stuck);
        }
        *histories = Histories { memory: at_end.memory, worn: at_end.worn, pressed_in: at_end.pressed_in, sideways };
        Ok(OfIncrement {
            clearance: at_end.clearance + by_step,
            load: if let Load::MeanPressure(_) = load { by_load / factor } else { by_load },
            moved: by_moved,
            modulus,
            limit,
            hardness: hardness.map(|by| by / factor),
            wear,
            error,
            effort,
        })
    }

    /// Returns the derivatives with respect to the state at the end of an increment, from those `of` its fields and
    /// numbers and of the `histories` there.
    fn at_end(&self, solved: &Solved, mut of: Cotangents, histories: Histories) -> Result<AtEnd, Reason> {
        let (points, components, end) = (self.points(), self.sheared_components(), solved.end);
        let affine = &solved.step.affine;
        let zeros = || Array2::<f64>::zeros(end.gap().raw_dim());
        let Histories { memory: later, mut worn, mut pressed_in, mut sideways } = histories;
        sideways.resize(components * points, 0.0);
        let mut shear = vec![0.0; components * points];
        shear.iter_mut().zip(of.shear.iter().flatten()).for_each(|(sum, by)| *sum += by);
        for (shear, by) in shear.chunks_exact_mut(points).zip(of.mean_shear) {
            shear.iter_mut().for_each(|sum| *sum += by / points as f64);
        }
        if let Some(by) = &of.plastic_depth {
            *pressed_in.get_or_insert_with(zeros) += by;
        }
        let (mut clearance, mut modulus, mut memory) = (zeros(), 0.0, None);
        if let Some(medium) = &self.medium {
            let mut by_memory =
                medium.energy_derivatives(end.memory.as_ref().ok_or(Refusal::OtherKind)?, of.elastic_energy)?;
            if later.is_some_and(|later| !by_memory.add(&later)) {
                return Err(Refusal::OtherKind.into());
            }
            let (by_indentation, at_start) = medium.end_transposed(&by_memory, affine.duration)?;
            memory = Some(at_start);
            let (lateral, by_depth) = by_indentation.split_at(components * points);
            sideways.iter_mut().zip(lateral).for_each(|(sum, by)| *sum -= by);
            // The indentation reached is the gap plus the approach, less the clearance and the depths lost.
            of.approach += total(by_depth);
            let by_depth = self.field(by_depth.to_vec());
            clearance -= &by_depth;
            for (is_kept, by) in [(self.wear.is_some(), &mut worn), (self.hardness.is_some(), &mut pressed_in)] {
                if is_kept {
                    *by.get_or_insert_with(zeros) -= &by_depth;
                }
            }
            *of.gap.get_or_insert_with(zeros) += &by_depth;
        } else if let Some(sheared) = &end.sheared {
            // The normal contact knows the energy of the pressure alone.
            let share = of.elastic_energy / points as f64;
            shear.iter_mut().zip(&sheared.displacement).for_each(|(by, u)| *by += share * u);
            let by_pressure = of.pressure.get_or_insert_with(zeros);
            Zip::from(by_pressure).and(end.displacement_z()).for_each(|by, u| *by -= share * u);
        }
        if self.medium.is_some() || end.sheared.is_some() {
            let sign = if self.medium.is_some() { 1.0 } else { -1.0 };
            modulus += sign * of.elastic_energy * end.elastic_energy();
            of.elastic_energy = 0.0;
        }
        let factor = affine.factor();
        if let (Some(worn), Some(springs)) = (&worn, &solved.springs) {
            // The depth worn off in the increment is the repulsion times this compliance.
            let by_pressure = of.pressure.get_or_insert_with(zeros);
            let points = by_pressure.iter_mut().zip(worn).zip(&solved.repulsion).enumerate();
            for (i, ((by, worn), _)) in points.filter(|(_, (_, repulsion))| **repulsion > 0.0) {
                *by += worn / factor
                    * match springs {
                        Springs::Uniform(compliance) => *compliance,
                        Springs::Field(compliance) => compliance.as_slice().map_or(0.0, |compliance| compliance[i]),
                    };
            }
        }
        shear.iter_mut().for_each(|by| *by *= factor);
        let normal = Cotangents {
            pressure: of.pressure.map(|by| by * factor),
            mean_pressure: of.mean_pressure * factor,
            plastic_depth: pressed_in.clone(),
            shear: None,
            mean_shear: [0.0; 2],
            ..of
        };
        Ok(AtEnd { normal, shear, sideways, worn, pressed_in, memory, clearance, modulus })
    }
}

impl<'a> Solved<'a> {
    /// Places the `step` at its `end`.
    fn new(mut step: Step<'a>, end: &'a QuasistaticState) -> Result<Self, Refusal> {
        if let Some(shear) = &mut step.shear {
            let ended = end.sheared.as_ref().ok_or(Refusal::OtherKind)?;
            shear.place(&ended.traction, &ended.slip);
        }
        let (contact, touch) = step.normal()?;
        let unpressed = step.unpressed(Effect::Present);
        let normal = end.normal.to_step(step.affine.factor(), (unpressed.as_ref(), &[]), touch);
        let slipped = step.shear.as_ref().map_or_else(Vec::new, |shear| shear.slipped.clone());
        let springs = step.springs(&slipped);
        Ok(Self { step, end, contact, normal, unpressed, springs, slipped, repulsion: end.repulsion().into_owned() })
    }

    /// Returns the derivatives with respect to the compliance that stands for the wear at each point, not divided, from
    /// those with respect to the clearance of the step and to the depth worn off.
    fn by_compliance(&self, by_step: &ArrayRef2<f64>, by_worn: Option<&Array2<f64>>) -> Vec<f64> {
        let mut by = by_step.to_owned();
        by_worn.iter().for_each(|worn| by += *worn);
        by *= &self.repulsion;
        by.into_iter().collect()
    }

    /// Returns the derivatives with respect to the slip vectors, by which the surfaces wear.
    fn by_slip(&self, by_step: &ArrayRef2<f64>, by_worn: Option<&Array2<f64>>) -> Vec<f64> {
        let slip = self.end.sheared.as_ref().map_or(&[][..], |sheared| &sheared.slip);
        let Some(wear) = self.step.contact.wear.filter(|_| !self.slipped.is_empty()) else {
            return vec![0.0; slip.len()];
        };
        let by_compliance = self.by_compliance(by_step, by_worn);
        let points = by_compliance.len();
        let of = |(k, slip): (usize, &f64)| match self.slipped[k % points] {
            0.0 => 0.0,
            size => wear.by_slip * by_compliance[k % points] * slip / size,
        };
        slip.iter().enumerate().map(of).collect()
    }

    /// Transposes the normal contact, to a relative residual of `tolerance`.
    fn transpose_normal(&self, load: Load, of: &Cotangents, tolerance: f64) -> Result<ClearanceGradient, Reason> {
        Ok(match (&self.contact, &self.normal) {
            (Normal::Wall(contact), NormalState::Wall(state)) => {
                let displacement = match &self.unpressed {
                    Some(depth) => &state.displacement + depth,
                    None => state.displacement.clone(),
                };
                contact.gradient_by_clearance((&state.pressure, &displacement), load, of, tolerance)?
            }
            (Normal::Law(interface), NormalState::Law(state)) => interface.derivatives(state, load, of, tolerance)?,
            _ => return Err(Refusal::OtherKind.into()),
        })
    }

    /// Transposes normal contact and shear in turn, until both agree. Both problems are linear: each round solves for
    /// the change of the last one alone, to the same absolute error.
    fn transpose(&mut self, load: Load, at_end: &AtEnd) -> Result<(ClearanceGradient, Option<ShearGradient>), Reason> {
        let Some((shear, ended)) = self.step.shear.take().zip(self.end.sheared.as_ref()) else {
            return Ok((self.transpose_normal(load, &at_end.normal, EXACT)?, None));
        };
        let mut adjoint = shear.adjoint(&self.normal, &ended.slip);
        let mut sheared = self.transpose_shear(&mut adjoint, &Array2::zeros(self.repulsion.raw_dim()), Some(at_end));
        let (mut by_pressure, mut mixing) = (sheared.pressure.clone(), Anderson::new(DEPTH));
        let mut sum = self.field(&by_pressure);
        at_end.normal.pressure.iter().for_each(|by| sum += by);
        let mut of = Cotangents { pressure: Some(sum.clone()), ..at_end.normal.clone() };
        let mut found: Option<ClearanceGradient> = None;
        let (mut tolerance, mut error, mut left) = (EXACT, 0.0_f64, f64::INFINITY);
        for _ in 0..ROUNDS {
            let change = self.transpose_normal(load, &of, tolerance)?;
            error = error.max(change.error * EXACT / tolerance);
            let by_change = self.transpose_shear(&mut adjoint, &change.clearance, None);
            sheared.add(&by_change);
            let found = match &mut found {
                Some(found) => {
                    found.add(&change);
                    found
                }
                None => found.insert(change),
            };
            let size = norm(sum.iter().copied());
            let apart = sheared.pressure.iter().zip(&by_pressure).map(|(new, by)| new - by);
            left = match norm(apart) {
                0.0 => 0.0,
                apart => apart / size,
            };
            if left <= TOLERANCE {
                let error = error.max(sheared.error).max(left);
                if error.is_nan() || error > ERROR {
                    break;
                }
                found.error = error;
                found.effort.iterations += adjoint.iterations;
                found.effort.transform_pairs += adjoint.pairs();
                return Ok((found.clone(), Some(sheared)));
            }
            let before = self.field(&by_pressure);
            mixing.advance(&mut by_pressure, &sheared.pressure);
            let moved = self.field(&by_pressure) - before;
            sum += &moved;
            tolerance = (EXACT * size / norm(moved.iter().copied())).clamp(EXACT, LOOSEST);
            of = Cotangents { pressure: Some(moved), ..Cotangents::default() };
        }
        let iterations = found.map_or(0, |found| found.effort.iterations);
        Err(GradientError::Inexact { error: left, iterations }.into())
    }

    /// Transposes the shear, from the derivatives with respect to the clearance of the normal contact and to the state
    /// `at_end`, if they are not zero. The clearance contains the displacement caused by the shear, with a minus sign.
    fn transpose_shear(
        &self,
        adjoint: &mut ShearAdjoint,
        by_step: &Array2<f64>,
        at_end: Option<&AtEnd>,
    ) -> ShearGradient {
        let lift: Vec<f64> = by_step.iter().map(|by| -by).collect();
        let slip = self.by_slip(by_step, at_end.and_then(|at_end| at_end.worn.as_ref()));
        let none = vec![0.0; slip.len()];
        let (traction, displacement) = at_end.map_or((&none, &none), |at_end| (&at_end.shear, &at_end.sideways));
        adjoint.solve(&ByShear { traction, displacement, slip: &slip, lift: &lift })
    }

    fn field(&self, values: &[f64]) -> Array2<f64> {
        self.step.contact.field(values.to_vec())
    }
}

/// Returns the Euclidean norm.
fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|value| value * value).sum::<f64>().sqrt()
}
