use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use gfmd_contact::{
    Boundary, Budget, Contact, Drive, Equilibrium, Fields as _, Load, Progress, Refusal, Resumable, SolveError, Solver,
    Visit, Watch,
};
use gfmd_field::{Transform, Workspace};
use gfmd_green::Body;
use gfmd_vector::{contiguous, lower, reduce};
use ndarray::Array2;
use num_complex::Complex64;

use crate::history::{History, PointStep};
use crate::spectrum::{Spectrum, stiffness};
use crate::{ElasticContact, Prony, Relaxes, StepFrame, Stiffening, ViscoelasticState};

/// A rigid rough surface above a viscoelastic body, with a hard wall or a law across the gap, and without friction
/// (theory.md, section 7.7).
///
/// Each state follows from the previous one, with a surface displacement linear in time between them. A step is exact
/// for this displacement, whatever its duration; it is solved as an elastic contact with larger moduli and another
/// clearance. The first step begins at time 0 and zero load or approach: with the undeformed surfaces at first touch
/// or, with a law, the state into which the law draws them instantly. A step of zero duration is a jump.
#[derive(Clone)]
pub struct ViscoelasticContact<C = Contact> {
    /// Contact with the long-term moduli.
    contact: C,
    spectrum: Arc<Spectrum>,
    /// Transforms, if each wave of the body has its own branches.
    transform: Option<Arc<(Transform, Mutex<Workspace>)>>,
}

/// A prepared step.
struct Begun<C> {
    /// Elastic contact of the step.
    contact: C,
    frame: StepFrame,
    /// Duration of the step.
    duration: f64,
}

/// Relative rounding error below which an approach counts as zero.
const ROUNDING_OF_APPROACH: f64 = 8.0 * f64::EPSILON;

impl<C: ElasticContact> ViscoelasticContact<C> {
    /// Creates the contact of `body`, relaxing by a Prony series. `contact` has its long-term moduli.
    ///
    /// # Errors
    /// Returns an error for a hardness, for all displacement components, or if only the shear modulus relaxes and this
    /// relaxation is not known for the body or boundary.
    pub fn new(contact: C, body: &Body, prony: &Prony, relaxes: Relaxes) -> Result<Self, Refusal> {
        contact.check_relaxing()?;
        let grid = contact.surface().grid();
        let spectrum = Spectrum::new(body, grid, contact.boundary() == Boundary::Free, prony, relaxes)?;
        let transform = match &spectrum {
            Spectrum::Common(_) => None,
            Spectrum::Waves(_) => {
                let transform = Transform::new(*grid);
                let workspace = Mutex::new(transform.workspace());
                Some(Arc::new((transform, workspace)))
            }
        };
        Ok(Self { contact, spectrum: spectrum.into(), transform })
    }

    /// Returns the contact with the long-term moduli, the final state under a constant load.
    pub fn contact(&self) -> &C {
        &self.contact
    }

    /// Returns the largest number of branches of a wave.
    pub fn branches(&self) -> usize {
        match &*self.spectrum {
            Spectrum::Common(branches) => branches.len(),
            Spectrum::Waves(waves) => waves.count,
        }
    }

    /// Computes the energy stored in all springs, per area, from the [`memory`](ViscoelasticState::memory) of a state;
    /// `body` is the body of the contact. `None` with free boundaries, where the pressure of each spring is needed.
    ///
    /// # Errors
    /// Returns an error if the size of the fields or their number does not match the grid or the branches.
    pub fn elastic_energy(&self, body: &Body, memory: &[Array2<f64>]) -> Result<Option<f64>, Refusal> {
        if memory.len() != 1 + self.branches() {
            return Err(Refusal::Basis { found: memory.len(), expected: 1 + self.branches() });
        }
        let grid = *self.contact.surface().grid();
        if let Some(field) = memory.iter().find(|field| field.len() != grid.len()) {
            return Err(Refusal::Start { found: field.len(), expected: grid.len() });
        }
        if self.contact.boundary() == Boundary::Free {
            return Ok(None);
        }
        let (transform, stiffness) = (Transform::new(grid), stiffness(body, &grid));
        let mut workspace = transform.workspace();
        let mut spectra = Vec::new();
        for field in memory {
            let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
            transform.forward(&contiguous(field), &mut spectrum, &mut workspace)?;
            spectra.push(spectrum);
        }
        let weights = |mode: usize| -> Vec<f64> {
            match &*self.spectrum {
                Spectrum::Common(branches) => branches.iter().map(|branch| branch.weight).collect(),
                Spectrum::Waves(waves) => waves.of(mode).map(|branch| branch.weight).collect(),
            }
        };
        let of = |mode: usize| {
            let branches = weights(mode).into_iter().zip(&spectra[1..]).map(|(weight, x)| weight * x[mode].norm_sqr());
            0.5 * grid.mode_at(mode).weight * stiffness[mode] * (spectra[0][mode].norm_sqr() + branches.sum::<f64>())
        };
        // The mean level of a half-space does not move.
        let modes = (0..grid.spectrum_len()).filter(|mode| stiffness[*mode].is_finite());
        Ok(Some(modes.map(of).sum()))
    }

    /// Returns the memory before a step from `start`, or of an undeformed body.
    fn history(&self, start: Option<&ViscoelasticState<C::State>>) -> History {
        match (start, &*self.spectrum) {
            (Some(state), _) => state.history.clone(),
            (None, Spectrum::Common(branches)) => {
                History::at_rest(self.contact.surface().clearance().len(), branches.len())
            }
            (None, Spectrum::Waves(waves)) => History::of_waves(waves.stiffness.len(), waves.count),
        }
    }

    /// Prepares a step of the given `duration`.
    fn begin(&self, history: &History, duration: f64) -> Result<Begun<C>, Refusal> {
        let surface = self.contact.surface();
        let (stiffening, residual_indentation, factor) = match (history, &*self.spectrum) {
            (History::Points { lengths, .. }, Spectrum::Common(branches)) => {
                let step = PointStep::new(branches, duration);
                let mut residual_indentation = vec![0.0; surface.clearance().len()];
                step.fill(lengths, &mut residual_indentation);
                (Stiffening::All(step.stiffening), residual_indentation, step.stiffening)
            }
            (History::Waves(fields), Spectrum::Waves(waves)) => {
                let (factors, spectrum) = waves.residual_indentation(fields, duration);
                (Stiffening::Waves(factors), self.inverse(&spectrum), 1.0)
            }
            _ => return Err(Refusal::OtherKind),
        };
        let lowest = |range: std::ops::Range<usize>| {
            range.fold(f64::INFINITY, |least, i| lower(least, surface.clearance()[i] + residual_indentation[i]))
        };
        let touch = reduce(residual_indentation.len(), &lowest, &lower);
        let depth =
            self.field(residual_indentation.iter().map(|residual_indentation| residual_indentation - touch).collect());
        let frame = StepFrame { residual_indentation: self.field(residual_indentation), touch, factor };
        Ok(Begun { contact: self.contact.of_step(&stiffening, &depth)?, frame, duration })
    }

    /// Computes the state after a step from the `solution` of its elastic contact.
    fn end(
        &self,
        begun: &Begun<C>,
        solution: C::State,
        (start, history): (Option<&ViscoelasticState<C::State>>, &History),
        time: f64,
    ) -> Result<ViscoelasticState<C::State>, Refusal> {
        let Begun { frame, duration, .. } = begun;
        let displacement = solution.displacement_z();
        let indentation: Vec<f64> = frame
            .residual_indentation
            .iter()
            .zip(displacement)
            .map(|(residual_indentation, u)| residual_indentation - u)
            .collect();
        let (history, energies) = match (history, &*self.spectrum) {
            (History::Points { lengths, stresses }, Spectrum::Common(branches)) => {
                let pressure = solution.pressure();
                let step = PointStep::new(branches, *duration);
                step.advance((lengths, stresses), (indentation, &contiguous(&pressure)))
            }
            (History::Waves(fields), Spectrum::Waves(waves)) => {
                let grid = self.contact.surface().grid();
                let weight = |mode: usize| grid.mode_at(mode).weight;
                waves.advance(fields, self.forward(&indentation), *duration, weight)
            }
            _ => return Err(Refusal::OtherKind),
        };
        let solution = C::from_step_frame(solution, frame);
        let [mean_pressure, approach] = [solution.mean_pressure(), solution.approach()];
        let numbers = |state: &ViscoelasticState<C::State>| {
            let solution = &state.solution;
            let energy = state.elastic_energy + C::interface_energy(solution);
            [solution.mean_pressure(), solution.approach(), energy]
        };
        let [pressure_before, approach_before, energy_before] = start.map_or([0.0; 3], numbers);
        let moved = approach - approach_before;
        let work = 0.5 * (pressure_before + mean_pressure) * moved;
        let gained = energies.stored + C::interface_energy(&solution) - energy_before;
        let missing = work - gained - energies.lost;
        // Largest error of the work if the forces change monotonically, jumps included.
        let spread = 0.5 * ((mean_pressure - pressure_before) * moved).abs();
        let (dissipated, work_imbalance) = match start {
            // The path on which attracting surfaces came together is unknown.
            None if !C::RESTS_AT_FIRST_TOUCH => (energies.lost, 0.0),
            // The energy balance gives the loss of a jump, whatever the curvature: a law may end in a step.
            Some(start)
                if C::interface_energy(&start.solution).abs() + C::interface_energy(&solution).abs() > 0.0
                    && (missing > spread || C::may_have_jumped(&solution)) =>
            {
                (energies.lost + missing, spread)
            }
            _ if *duration == 0.0 => (energies.lost, 0.0),
            _ => (energies.lost, missing.abs()),
        };
        Ok(ViscoelasticState { solution, time, elastic_energy: energies.stored, dissipated, work_imbalance, history })
    }

    fn field(&self, values: Vec<f64>) -> Array2<f64> {
        let shape = self.contact.surface().grid().points();
        Array2::from_shape_vec(shape, values).expect("every field has the size of the grid")
    }

    /// Transforms a field; only for a body with wave-dependent branches.
    fn forward(&self, field: &[f64]) -> Vec<Complex64> {
        let Some((transform, workspace)) = self.transform.as_deref() else { return Vec::new() };
        let mut spectrum = vec![Complex64::ZERO; transform.grid().spectrum_len()];
        let workspace = &mut *workspace.lock().unwrap_or_else(PoisonError::into_inner);
        transform.forward(field, &mut spectrum, workspace).expect("the field has the size of the grid");
        spectrum
    }

    /// Transforms a spectrum back; only for a body with wave-dependent branches.
    fn inverse(&self, spectrum: &[Complex64]) -> Vec<f64> {
        let Some((transform, workspace)) = self.transform.as_deref() else { return Vec::new() };
        let mut field = vec![0.0; transform.grid().len()];
        let workspace = &mut *workspace.lock().unwrap_or_else(PoisonError::into_inner);
        transform.inverse(spectrum, &mut field, workspace).expect("the spectrum has the size of the grid");
        field
    }

    fn check_time(time: f64, start: Option<&ViscoelasticState<C::State>>) -> Result<f64, Refusal> {
        let least = start.map_or(0.0, |start| start.time);
        if time >= least { Ok(time - least) } else { Err(Refusal::Time { found: time, least }) }
    }
}

impl ViscoelasticContact {
    /// Returns the mismatch between `pressure` and [`memory`](ViscoelasticState::memory), zero if they belong together:
    /// the largest difference between the displacement by the pressure, with the long-term moduli, and d + Σ c x,
    /// divided by the largest displacement or elongation.
    ///
    /// # Errors
    /// Returns an error if the size of the fields or their number does not match the grid or the branches.
    pub fn consistency(&self, pressure: &Array2<f64>, memory: &[Array2<f64>]) -> Result<f64, Refusal> {
        if memory.len() != 1 + self.branches() {
            return Err(Refusal::Basis { found: memory.len(), expected: 1 + self.branches() });
        }
        let expected = self.contact.certify(pressure, Load::Approach(0.0))?;
        let expected: Vec<f64> = expected.displacement.iter().map(|u| -u).collect();
        if let Some(field) = memory.iter().find(|field| field.len() != expected.len()) {
            return Err(Refusal::Start { found: field.len(), expected: expected.len() });
        }
        let memory: Vec<_> = memory.iter().map(|field| contiguous(field)).collect();
        // Without pressure the body may not have recovered yet.
        let remembered = memory.iter().flat_map(|field| field.iter().copied());
        let total = match &*self.spectrum {
            Spectrum::Common(branches) => (0..expected.len())
                .map(|i| memory[0][i] + branches.iter().zip(&memory[1..]).map(|(b, x)| b.weight * x[i]).sum::<f64>())
                .collect(),
            Spectrum::Waves(waves) => {
                let mut spectra: Vec<Vec<Complex64>> = memory.iter().map(|field| self.forward(field)).collect();
                let mut total = spectra.remove(0);
                for (mode, total) in total.iter_mut().enumerate() {
                    *total += waves.of(mode).zip(&spectra).map(|(b, x)| b.weight * x[mode]).sum::<Complex64>();
                }
                self.inverse(&total)
            }
        };
        let largest = |values: &mut dyn Iterator<Item = f64>| {
            values.fold(0.0, |most: f64, x| if x.abs() > most || x.is_nan() { x.abs() } else { most })
        };
        let apart = largest(&mut total.iter().zip(&expected).map(|(a, b)| a - b));
        let scale = largest(&mut expected.iter().copied().chain(remembered));
        Ok(if apart == 0.0 { 0.0 } else { apart / scale })
    }
}

impl<C: ElasticContact> Equilibrium for ViscoelasticContact<C> {
    type State = ViscoelasticState<C::State>;

    fn solvers(&self) -> &'static [Solver] {
        self.contact.solvers()
    }

    /// Accepts any sign of the approach with periodic boundaries: surfaces may part, and touch again after recovery.
    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        drive.check()?;
        Self::check_time(drive.time, None)?;
        match drive.load {
            Load::Approach(approach) if approach <= 0.0 && self.contact.boundary() == Boundary::Periodic => Ok(()),
            _ => self.contact.check(drive),
        }
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        match drive.load {
            Load::Approach(approach) if approach <= 0.0 => Ok(()),
            _ => self.contact.check_resolution(drive, tolerance),
        }
    }

    /// Solves the step from `start`, or from zero load at time 0, by one solve; with a law, the state at zero load
    /// takes a second solve.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&Self::State>,
        watch: &mut dyn Watch,
    ) -> Result<Self::State, SolveError<Self::State>> {
        budget.check().map_err(Refusal::from)?;
        self.check(drive)?;
        let duration = Self::check_time(drive.time, start)?;
        if start.is_none() && duration > 0.0 && !C::RESTS_AT_FIRST_TOUCH {
            let load = match drive.load {
                Load::MeanPressure(_) => Load::MeanPressure(0.0),
                Load::Approach(_) => Load::Approach(0.0),
            };
            // The search is short and writes no checkpoint.
            let touched = self.equilibrate(load.into(), solver, budget, None, &mut |now: &Progress| watch.see(now))?;
            let mut state = self.equilibrate(drive, solver, budget, Some(&touched), watch)?;
            let (_, effort) = C::approach_and_effort(&mut state.solution);
            effort.iterations += touched.effort().iterations;
            effort.transform_pairs += touched.effort().transform_pairs;
            return Ok(state);
        }
        let history = self.history(start);
        let begun = self.begin(&history, duration)?;
        let StepFrame { touch, factor, .. } = begun.frame;
        let with_approach = |mut state: Self::State| {
            if let Load::Approach(asked) = drive.load {
                *C::approach_and_effort(&mut state.solution).0 = asked;
            }
            state
        };
        let load = match drive.load {
            Load::MeanPressure(mean) => Load::MeanPressure(mean / factor),
            Load::Approach(approach) => {
                let size = approach.abs().max(touch.abs()).max(self.contact.surface().rms_height());
                let separated = if approach - touch <= ROUNDING_OF_APPROACH * size {
                    begun.contact.separated_state(approach - touch)
                } else {
                    None
                };
                if let Some(solution) = separated {
                    return Ok(with_approach(self.end(&begun, solution?, (start, &history), drive.time)?));
                }
                Load::Approach(approach - touch)
            }
        };
        let warm = start.and_then(|start| C::to_step_frame(&start.solution, &begun.frame));
        let (mut reached, mut failed) = (None, None);
        match begun.contact.equilibrate(load.into(), solver, budget, warm.as_ref(), watch) {
            Ok(solution) => reached = Some(solution),
            Err(SolveError::Refused(refusal)) => return Err(refusal.into()),
            Err(error) => failed = Some(error.map(|solution| reached = Some(solution))),
        }
        let solution = reached.ok_or(Refusal::OtherKind)?;
        let state = with_approach(self.end(&begun, solution, (start, &history), drive.time)?);
        match failed {
            None => Ok(state),
            Some(error) => Err(error.map(|()| state)),
        }
    }
}

impl<C: ElasticContact> Resumable for ViscoelasticContact<C> {
    fn keep(&self, state: &mut Self::State, visitor: &mut dyn Visit) {
        Self::visit(state, visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<Self::State, Refusal> {
        self.check(drive)?;
        let mut state = ViscoelasticState {
            solution: self.contact.empty_state()?,
            time: 0.0,
            elastic_energy: 0.0,
            dissipated: 0.0,
            work_imbalance: 0.0,
            history: self.history(None),
        };
        Self::visit(&mut state, visitor);
        Ok(state)
    }
}

impl<C: ElasticContact> ViscoelasticContact<C> {
    /// Visits all variables of a state except the surface.
    fn visit(state: &mut ViscoelasticState<C::State>, visitor: &mut dyn Visit) {
        let ViscoelasticState { solution, time, elastic_energy, dissipated, work_imbalance, history } = state;
        C::visit(solution, visitor);
        visitor.numbers(&mut [time, elastic_energy, dissipated, work_imbalance]);
        history.visit(visitor);
    }
}

impl<C: ElasticContact> fmt::Debug for ViscoelasticContact<C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ViscoelasticContact").field("branches", &self.branches()).finish_non_exhaustive()
    }
}
