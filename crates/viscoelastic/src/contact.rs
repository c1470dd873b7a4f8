use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use gfmd_contact::{
    Boundary, Budget, Contact, Drive, Equilibrium, Load, Refusal, Resumable, Solution, SolveError, Solver, Visit, Watch,
};
use gfmd_field::{Transform, Workspace};
use gfmd_green::Body;
use gfmd_relax::Variables as _;
use gfmd_vector::{contiguous, for_each, lower, reduce, with_contiguous};
use ndarray::Array2;
use num_complex::Complex64;

use crate::history::{History, PointStep};
use crate::spectrum::{Spectrum, stiffness};
use crate::{Prony, Relaxes, ViscoelasticState};

/// A rigid rough surface above a viscoelastic body, with a hard wall and without friction (theory.md, section 7.7).
///
/// A state follows from the one before, from which the displacement of the surface is linear in time. The step is exact
/// for such a displacement, whatever its length, and its contact is an ordinary one, with larger moduli and another
/// clearance. The first step begins at first touch of the undeformed surfaces, at time 0; a step of no time is a jump.
#[derive(Clone)]
pub struct ViscoelasticContact {
    /// The contact with the long-term moduli.
    contact: Contact,
    spectrum: Arc<Spectrum>,
    /// The transforms of a body each of whose waves has its own branches.
    transform: Option<Arc<(Transform, Mutex<Workspace>)>>,
}

/// A step that begins.
struct Begun {
    /// The contact of the step.
    contact: Contact,
    /// H, by which the surface would stay indented without a pressure, row by row.
    hollow: Vec<f64>,
    /// Its first touch, the approach from which that of `contact` counts.
    touch: f64,
    /// The pressure over that of `contact`.
    factor: f64,
    /// The length of the step.
    duration: f64,
}

/// The approach below which nothing touches, over the largest of the lengths of which it is a difference.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl ViscoelasticContact {
    /// The contact of a `body`, whose long-term moduli are those of `contact`, and which relaxes by a Prony series.
    ///
    /// # Errors
    /// A hardness; a body, or a boundary, for which the relaxation of the shear modulus alone is not known.
    pub fn new(contact: Contact, body: &Body, prony: &Prony, relaxes: Relaxes) -> Result<Self, Refusal> {
        if contact.hardness().is_some() {
            return Err(Refusal::ViscoelasticHardness);
        }
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

    /// The contact with the long-term moduli, in which all ends under a constant load.
    pub fn contact(&self) -> &Contact {
        &self.contact
    }

    /// The number of branches of a wave, at most.
    pub fn branches(&self) -> usize {
        match &*self.spectrum {
            Spectrum::Common(branches) => branches.len(),
            Spectrum::Waves(waves) => waves.count,
        }
    }

    /// A number that is zero for a state whose pressure is that of its [`memory`](ViscoelasticState::memory): the
    /// largest difference between the displacement by the pressure, on a body with the long-term moduli, and d + Σ c x,
    /// over the largest displacement.
    ///
    /// # Errors
    /// Fields of another size than the grid, or of another number than the branches.
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
        let scale = largest(&mut expected.iter().copied());
        Ok(if apart == 0.0 { 0.0 } else { apart / scale })
    }

    /// The energy stored in all springs, per area, by the [`memory`](ViscoelasticState::memory) of a state, with the `body`
    /// of the contact: `None` with free boundaries, where it takes the pressure of each spring.
    ///
    /// # Errors
    /// Fields of another size than the grid, or of another number than the branches.
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

    /// The memory before a step from `start`, which begins with a body that is undeformed.
    fn history(&self, start: Option<&ViscoelasticState>) -> History {
        match (start, &*self.spectrum) {
            (Some(state), _) => state.history.clone(),
            (None, Spectrum::Common(branches)) => {
                History::at_rest(self.contact.surface().clearance().len(), branches.len())
            }
            (None, Spectrum::Waves(waves)) => History::of_waves(waves.stiffness.len(), waves.count),
        }
    }

    /// Begins a step of this `duration`.
    fn begin(&self, history: &History, duration: f64) -> Result<Begun, Refusal> {
        let surface = self.contact.surface();
        let (contact, hollow, factor) = match (history, &*self.spectrum) {
            (History::Points { lengths, .. }, Spectrum::Common(branches)) => {
                let step = PointStep::new(branches, duration);
                let mut hollow = vec![0.0; surface.clearance().len()];
                step.fill(lengths, &mut hollow);
                (self.contact.clone(), hollow, step.stiffening)
            }
            (History::Waves(fields), Spectrum::Waves(waves)) => {
                let (factors, spectrum) = waves.hollow(fields, duration);
                (self.contact.stiffened(&factors), self.inverse(&spectrum), 1.0)
            }
            _ => return Err(Refusal::OtherKind),
        };
        let lowest = |range: std::ops::Range<usize>| {
            range.fold(f64::INFINITY, |least, i| lower(least, surface.clearance()[i] + hollow[i]))
        };
        let touch = reduce(hollow.len(), &lowest, &lower);
        let depth = self.field(hollow.iter().map(|hollow| hollow - touch).collect());
        Ok(Begun { contact: contact.indented(&depth)?, hollow, touch, factor, duration })
    }

    /// The state after a step, of the `solution` of its contact.
    fn end(
        &self,
        begun: Begun,
        mut solution: Solution,
        (start, history): (Option<&ViscoelasticState>, &History),
        time: f64,
    ) -> Result<ViscoelasticState, Refusal> {
        let Begun { hollow, touch, factor, duration, .. } = begun;
        let mut indentation = hollow;
        let displacement = contiguous(&solution.displacement);
        for_each((&mut indentation[..], &displacement[..]), &|_, (d, u)| {
            d.iter_mut().zip(u).for_each(|(d, u)| *d -= u);
        });
        drop(displacement);
        solution.displacement = self.field(indentation.iter().map(|d| -d).collect());
        let (history, energies) = match (history, &*self.spectrum) {
            (History::Points { lengths, stresses }, Spectrum::Common(branches)) => {
                let pressure = contiguous(&solution.pressure);
                PointStep::new(branches, duration).advance((lengths, stresses), (indentation, &pressure))
            }
            (History::Waves(fields), Spectrum::Waves(waves)) => {
                let grid = self.contact.surface().grid();
                let weight = |mode: usize| grid.mode_at(mode).weight;
                waves.advance(fields, self.forward(&indentation), duration, weight)
            }
            _ => return Err(Refusal::OtherKind),
        };
        if factor != 1.0 {
            with_contiguous(&mut solution.pressure, |pressure| {
                for_each([pressure], &|_, [pressure]| pressure.iter_mut().for_each(|p| *p *= factor));
            });
            solution.mean_pressure *= factor;
        }
        solution.approach += touch;
        let before = start
            .map_or([0.0; 3], |start| [start.solution.mean_pressure, start.solution.approach, start.elastic_energy]);
        let work = 0.5 * (before[0] + solution.mean_pressure) * (solution.approach - before[1]);
        let missing = work - (energies.stored - before[2]) - energies.lost;
        Ok(ViscoelasticState {
            solution,
            time,
            elastic_energy: energies.stored,
            dissipated: energies.lost,
            dissipated_error: if duration == 0.0 { 0.0 } else { missing.abs() },
            history,
        })
    }

    fn field(&self, values: Vec<f64>) -> Array2<f64> {
        let shape = self.contact.surface().grid().points();
        Array2::from_shape_vec(shape, values).expect("every field has the size of the grid")
    }

    /// The spectrum of a field of a body of waves.
    fn forward(&self, field: &[f64]) -> Vec<Complex64> {
        let Some((transform, workspace)) = self.transform.as_deref() else { return Vec::new() };
        let mut spectrum = vec![Complex64::ZERO; transform.grid().spectrum_len()];
        let workspace = &mut *workspace.lock().unwrap_or_else(PoisonError::into_inner);
        transform.forward(field, &mut spectrum, workspace).expect("the field has the size of the grid");
        spectrum
    }

    /// The field of a spectrum of a body of waves.
    fn inverse(&self, spectrum: &[Complex64]) -> Vec<f64> {
        let Some((transform, workspace)) = self.transform.as_deref() else { return Vec::new() };
        let mut field = vec![0.0; transform.grid().len()];
        let workspace = &mut *workspace.lock().unwrap_or_else(PoisonError::into_inner);
        transform.inverse(spectrum, &mut field, workspace).expect("the spectrum has the size of the grid");
        field
    }

    fn check_time(time: f64, start: Option<&ViscoelasticState>) -> Result<f64, Refusal> {
        let least = start.map_or(0.0, |start| start.time);
        if time >= least { Ok(time - least) } else { Err(Refusal::Time { found: time, least }) }
    }
}

impl Equilibrium for ViscoelasticContact {
    type State = ViscoelasticState;

    fn solvers(&self) -> &'static [Solver] {
        self.contact.solvers()
    }

    /// The approach may be of any sign: surfaces may part, and touch again when the body has recovered.
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

    /// Makes the step from `start`, or from first touch at time 0, by one solve.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&ViscoelasticState>,
        watch: &mut dyn Watch,
    ) -> Result<ViscoelasticState, SolveError<ViscoelasticState>> {
        budget.check().map_err(Refusal::from)?;
        self.check(drive)?;
        let duration = Self::check_time(drive.time, start)?;
        let history = self.history(start);
        let begun = self.begin(&history, duration)?;
        let (touch, factor) = (begun.touch, begun.factor);
        let load = match drive.load {
            Load::MeanPressure(mean) => Load::MeanPressure(mean / factor),
            Load::Approach(approach) => {
                let size = approach.abs().max(touch.abs()).max(self.contact.surface().rms_height());
                if approach - touch <= ROUNDING * size {
                    let none = self.field(vec![0.0; history.points(self)]);
                    let solution = begun.contact.certify(&none, Load::Approach((approach - touch).min(0.0)))?;
                    let mut state = self.end(begun, solution, (start, &history), drive.time)?;
                    state.solution.approach = approach;
                    return Ok(state);
                }
                Load::Approach(approach - touch)
            }
        };
        let warm = start.filter(|start| start.solution.mean_pressure > 0.0).map(|start| {
            let mut solution = start.solution.clone();
            solution.pressure.mapv_inplace(|p| p / factor);
            solution
        });
        let solved = begun.contact.equilibrate(load.into(), solver, budget, warm.as_ref(), watch);
        let (mut reached, mut failed) = (None, None);
        match solved {
            Ok(solution) => reached = Some(solution),
            Err(SolveError::Refused(refusal)) => return Err(refusal.into()),
            Err(error) => failed = Some(error.map(|solution| reached = Some(solution))),
        }
        let solution = reached.ok_or(Refusal::OtherKind)?;
        let mut state = self.end(begun, solution, (start, &history), drive.time)?;
        if let Load::Approach(approach) = drive.load {
            state.solution.approach = approach;
        }
        match failed {
            None => Ok(state),
            Some(error) => Err(error.map(|()| state)),
        }
    }
}

impl History {
    fn points(&self, contact: &ViscoelasticContact) -> usize {
        match self {
            Self::Points { lengths, .. } => lengths[0].len(),
            Self::Waves(_) => contact.contact.surface().clearance().len(),
        }
    }
}

impl Resumable for ViscoelasticContact {
    fn keep(&self, state: &mut ViscoelasticState, visitor: &mut dyn Visit) {
        state.visit(visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<ViscoelasticState, Refusal> {
        self.check(drive)?;
        let none = self.field(vec![0.0; self.contact.surface().clearance().len()]);
        let solution = self.contact.certify(&none, Load::Approach(0.0))?;
        let mut state = ViscoelasticState {
            solution,
            time: 0.0,
            elastic_energy: 0.0,
            dissipated: 0.0,
            dissipated_error: 0.0,
            history: self.history(None),
        };
        state.visit(visitor);
        Ok(state)
    }
}

impl ViscoelasticState {
    /// Visits all that the state consists of, but for the surface.
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self { solution, time, elastic_energy, dissipated, dissipated_error, history } = self;
        let Solution { pressure, displacement, gap, mean_pressure, approach, residual, effort, .. } = solution;
        for field in [pressure, displacement, gap] {
            with_contiguous(field, |field| visitor.field(field));
        }
        visitor.numbers(&mut [mean_pressure, approach, time, elastic_energy, dissipated, dissipated_error]);
        let gfmd_contact::Residual { complementarity, penetration, negative_pressure, load } = residual;
        visitor.numbers(&mut [complementarity, penetration, negative_pressure, load]);
        effort.visit(visitor);
        history.visit(visitor);
    }
}

impl fmt::Debug for ViscoelasticContact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ViscoelasticContact").field("branches", &self.branches()).finish_non_exhaustive()
    }
}
