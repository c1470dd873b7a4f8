//! Derivatives along a path: each increment is one linear problem, and the histories pass the derivatives back to the
//! increments before (theory.md, section 7.9).

use gfmd_contact::{ClearanceGradient, Cotangents, Drive, Effort, Fields as _, GradientError, Load, Refusal, Springs};
use gfmd_medium::MemoryDerivatives;
use gfmd_vector::{contiguous, total};
use ndarray::Array2;

use super::normal::{Normal, NormalState};
use super::shear::Effect;
use super::step::Step;
use super::{QuasistaticContact, QuasistaticState};

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

/// Derivatives of a number L with respect to the input of a path, at fixed points in contact in each increment, times,
/// and sliding distances.
#[derive(Clone, Debug, PartialEq)]
pub struct PathGradient {
    /// Derivative with respect to the height of each point, peaks towards the body.
    pub heights: Array2<f64>,
    /// Derivative with respect to the load of each increment, its prescribed mean pressure or approach.
    pub loads: Vec<f64>,
    /// Derivative with respect to E*, with all moduli of the body in proportion, for the same loads, law and wear.
    pub modulus: f64,
    /// Largest relative error of the linear problems, from their residuals with fresh transforms.
    pub error: f64,
    /// Effort of all linear problems.
    pub effort: Effort,
}

impl PathGradient {
    /// Returns the derivatives with respect to the loads of steps made of this many equal `increments` each, all of one
    /// kind; the first step begins without a load.
    pub fn loads_of_steps(&self, increments: &[u64]) -> Vec<f64> {
        let (mut by_load, mut of_increments) = (vec![0.0; increments.len()], self.loads.iter());
        for (step, count) in increments.iter().map(|count| (*count).max(1)).enumerate() {
            for (increment, by) in (1..=count).zip(&mut of_increments) {
                let share = increment as f64 / count as f64;
                by_load[step] += share * by;
                if step > 0 {
                    by_load[step - 1] += (1.0 - share) * by;
                }
            }
        }
        by_load
    }
}

/// Reasons why a path has no derivative.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PathGradientError {
    /// The surfaces shear each other.
    #[error("the surfaces shear each other; they must not, since the derivative of friction is not implemented")]
    Sheared,
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
}

/// Derivatives of one increment, in the units of the solve.
struct OfIncrement {
    clearance: Array2<f64>,
    load: f64,
    /// With respect to the logarithm of E*.
    modulus: f64,
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

impl QuasistaticContact {
    /// Computes the derivatives of a number along a path, from its derivatives with respect to the states at the ends
    /// of all `increments`, which begin with the undeformed surfaces. Each increment follows from the one before; if a
    /// [`Path`](crate::Path) divides its steps, all increments of the division are needed. Points in contact are kept,
    /// as they are for almost all heights and loads. A body that relaxes and surfaces that wear by a distance pass the
    /// derivatives back from increment to increment.
    ///
    /// # Errors
    /// Returns an error for surfaces that shear each other or have a hardness, for a law that moves all components, for
    /// derivatives that differ in shape or are not finite, and for an increment without derivatives (as
    /// [`Contact::gradient`](gfmd_contact::Contact::gradient) and [`Interface::gradient`](crate::Interface::gradient)).
    pub fn gradient_along(&self, increments: &[Increment<'_>]) -> Result<PathGradient, PathGradientError> {
        self.check_gradient(increments)?;
        let (length, stress, energy) = (self.units.length(), self.units.stress(), self.units.energy());
        let shape = self.normal.surface().grid().points();
        let (mut clearance, mut histories) = (Array2::zeros(shape), Histories::default());
        let (mut loads, mut modulus) = (vec![0.0; increments.len()], 0.0);
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
            modulus += found.modulus;
            error = error.max(found.error);
            effort.iterations += found.effort.iterations;
            effort.transform_pairs += found.effort.transform_pairs;
        }
        let heights = self.scaled.by_heights(&clearance) / length;
        Ok(PathGradient { heights, loads, modulus: modulus / self.contact_modulus, error, effort })
    }

    /// Checks that the contact, the states and the derivatives have what a gradient needs.
    fn check_gradient(&self, increments: &[Increment<'_>]) -> Result<(), PathGradientError> {
        if self.hardness.is_some() {
            return Err(PathGradientError::Contact(GradientError::Hardness));
        }
        if self.shear.is_some() {
            return Err(PathGradientError::Sheared);
        }
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
                of.check(shape).map_err(|reason| PathGradientError::Increment { increment: index + 1, reason })?;
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
    /// computes those with respect to clearance, load and modulus, and replaces the `histories` by those at the start.
    fn transposed(
        &self,
        load: Load,
        (start, end): (Option<&QuasistaticState>, &QuasistaticState),
        mut of: Cotangents,
        histories: &mut Histories,
    ) -> Result<OfIncrement, Reason> {
        let load = match load {
            Load::MeanPressure(_) => Load::MeanPressure(end.mean_pressure()),
            Load::Approach(_) => Load::Approach(end.approach()),
        };
        let drive = Drive { distance: end.distance, ..Drive::from(load).at(end.time) };
        let step = Step::new(self, drive, start)?;
        let (factor, duration) = (step.affine.factor(), step.affine.duration);
        let shape = self.normal.surface().grid().points();
        let zeros = || Array2::<f64>::zeros(shape);
        let (mut clearance, mut modulus) = (zeros(), 0.0);
        let mut worn = histories.worn.take();
        let mut memory = None;
        if let Some(medium) = &self.medium {
            let at_end = end.memory.as_ref().ok_or(Refusal::OtherKind)?;
            let mut by_memory = medium.energy_derivatives(at_end, of.elastic_energy)?;
            modulus += of.elastic_energy * end.elastic_energy;
            of.elastic_energy = 0.0;
            if histories.memory.take().is_some_and(|later| !by_memory.add(&later)) {
                return Err(Refusal::OtherKind.into());
            }
            let (by_indentation, at_start) = medium.end_transposed(&by_memory, duration)?;
            memory = Some(at_start);
            // The indentation reached is the gap plus the approach, less the clearance and the depth worn off.
            of.approach += total(&by_indentation);
            let by_indentation = self.field(by_indentation);
            clearance -= &by_indentation;
            if self.wear.is_some() {
                *worn.get_or_insert_with(zeros) -= &by_indentation;
            }
            *of.gap.get_or_insert_with(zeros) += &by_indentation;
        }
        if let (Some(worn), Some(Springs::Uniform(compliance))) = (&worn, step.springs(&[])) {
            // The depth worn off in the increment is the pressure in contact times this compliance.
            let compliance = compliance / factor;
            let by_pressure = of.pressure.get_or_insert_with(zeros);
            let repulsion = end.repulsion();
            let points = ndarray::Zip::from(by_pressure).and(worn).and(&repulsion);
            points.for_each(|by, worn, repulsion| *by += if *repulsion > 0.0 { compliance * worn } else { 0.0 });
        }
        of.pressure = of.pressure.map(|by| by * factor);
        of.mean_pressure *= factor;
        let (contact, touch) = step.normal()?;
        let unpressed = step.unpressed(Effect::Present);
        let found = match (&contact, end.normal.to_step(factor, (unpressed.as_ref(), &[]), touch)) {
            (Normal::Wall(contact), NormalState::Wall(state)) => {
                let displacement =
                    unpressed.map_or_else(|| state.displacement.clone(), |depth| &state.displacement + &depth);
                contact.gradient_by_clearance((&state.pressure, &displacement), load, &of)?
            }
            (Normal::Law(interface), NormalState::Law(state)) => interface.gradient_by_clearance(&state, load, &of)?,
            _ => return Err(Refusal::OtherKind.into()),
        };
        let ClearanceGradient { clearance: by_step, load: by_load, modulus: by_modulus, error, effort } = found;
        clearance += &by_step;
        modulus += by_modulus * self.contact_modulus / self.units.modulus();
        // Residual indentation and depth worn off before are parts of the clearance.
        if let (Some(medium), Some(at_start)) = (&self.medium, &mut memory) {
            medium.begin_transposed(&contiguous(&by_step), duration, at_start)?;
        }
        if self.wear.is_some() {
            *worn.get_or_insert_with(zeros) += &by_step;
        }
        *histories = Histories { memory, worn };
        let by_load = if let Load::MeanPressure(_) = load { by_load / factor } else { by_load };
        Ok(OfIncrement { clearance, load: by_load, modulus, error, effort })
    }
}
