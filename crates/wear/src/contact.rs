use gfmd_contact::{
    Boundary, Budget, Contact, Drive, Effort, Equilibrium, Fields as _, Load, Refusal, Resumable, SolveError, Solver,
    Variables as _, Visit, Watch, judge,
};
use gfmd_relax::Ending;
use gfmd_vector::{contiguous, lower, reduce, total, with_contiguous};
use ndarray::{Array2, ArrayRef2};

use crate::WearState;

/// Rigid rough surface that slides on an elastic one, with a hard wall, while either or both wear (theory.md, section
/// 7.10).
///
/// The depth w lost so far is added to the clearance. Over a sliding distance s it grows by ∂w/∂s = k p. The
/// coefficient k, in 1/stress, is Archard's divided by the hardness. With the pressure at its end, a step of length Δs
/// is an ordinary contact: its compliance is G(q) + k Δs for every wave and for the uniform mode, its clearance
/// contains the depth before. The error of a step falls with the square of its length, and no step is unstable.
#[derive(Clone, Debug)]
pub struct WearContact {
    contact: Contact,
    coefficient: f64,
}

/// Contact of worn surfaces.
struct Worn {
    /// Contact with the approach measured from `touch`.
    contact: Contact,
    /// Approach at first touch.
    touch: f64,
}

/// Relative rounding error below which an approach counts as zero.
const ROUNDING_OF_APPROACH: f64 = 8.0 * f64::EPSILON;

/// Returns the approach beyond first touch, or `None` if the surfaces are apart.
fn beyond(approach: f64, touch: f64) -> Option<f64> {
    let beyond = approach - touch;
    (beyond > ROUNDING_OF_APPROACH * approach.max(touch)).then_some(beyond)
}

impl WearContact {
    /// Makes a wearing `contact` of surfaces that are unworn at first. They lose the depth `coefficient` × pressure ×
    /// distance; the coefficient, in 1/stress, covers both surfaces together.
    ///
    /// # Errors
    /// A coefficient that is not positive and finite; a contact with a hardness.
    pub fn new(contact: Contact, coefficient: f64) -> Result<Self, Refusal> {
        if contact.hardness().is_some() {
            return Err(Refusal::WearHardness);
        }
        if !(coefficient > 0.0 && coefficient.is_finite()) {
            return Err(Refusal::WearCoefficient { found: coefficient });
        }
        Ok(Self { contact, coefficient })
    }

    /// Returns the contact of the unworn surfaces.
    pub fn contact(&self) -> &Contact {
        &self.contact
    }

    /// Returns the wear coefficient, in 1/stress.
    pub fn coefficient(&self) -> f64 {
        self.coefficient
    }

    /// Computes the state of `pressure` under `drive` on surfaces that have lost `depth`, with its residuals from fresh
    /// transforms. The energies of the step to this state are unknown: `dissipated` and `work_imbalance` are NaN.
    ///
    /// # Errors
    /// Fields that differ in shape from the grid; a depth that is not finite.
    pub fn certify(
        &self,
        pressure: &ArrayRef2<f64>,
        depth: &ArrayRef2<f64>,
        drive: Drive,
    ) -> Result<WearState, Refusal> {
        let Worn { contact, touch } = self.after_wear(depth)?;
        let load = match drive.load {
            Load::Approach(approach) => {
                Load::Approach(beyond(approach, touch).unwrap_or_else(|| (approach - touch).min(0.0)))
            }
            pressure => pressure,
        };
        let mut solution = contact.certify(pressure, load)?;
        solution.approach = match drive.load {
            Load::Approach(approach) => approach,
            Load::MeanPressure(_) => solution.approach + touch,
        };
        let values = &*contiguous(depth);
        let largest = |range: std::ops::Range<usize>| values[range].iter().fold(0.0, |most: f64, w| most.max(*w));
        Ok(WearState {
            distance: drive.distance,
            volume: total(values) / values.len() as f64,
            deepest: reduce(values.len(), &largest, &f64::max),
            depth: depth.to_owned(),
            elastic_energy: solution.summary_in(&solution.scales()).elastic_energy,
            dissipated: f64::NAN,
            work_imbalance: f64::NAN,
            solution,
        })
    }

    /// Returns the contact after the loss of `depth`.
    fn after_wear(&self, depth: &ArrayRef2<f64>) -> Result<Worn, Refusal> {
        let (clearance, values) = (self.contact.surface().clearance(), &*contiguous(depth));
        if clearance.len() != values.len() {
            return Err(Refusal::Start { found: values.len(), expected: clearance.len() });
        }
        let lowest = |range: std::ops::Range<usize>| {
            range.fold(f64::INFINITY, |least, i| lower(least, clearance[i] + values[i]))
        };
        let touch = reduce(values.len(), &lowest, &lower);
        // Without the subtraction, endless wear would leave no digits of the roughness.
        Ok(Worn { contact: self.contact.with_wear_depth(&depth.mapv(|w| w - touch))?, touch })
    }

    fn check_distance(distance: f64, start: Option<&WearState>) -> Result<f64, Refusal> {
        let least = start.map_or(0.0, |start| start.distance);
        if distance >= least { Ok(distance - least) } else { Err(Refusal::Distance { found: distance, least }) }
    }

    fn zeros(&self) -> Array2<f64> {
        Array2::zeros(self.contact.surface().grid().points())
    }

    /// Returns the state after a step of length `moved` from the depth `before`, with `pressure` at its end.
    fn end(
        &self,
        pressure: &Array2<f64>,
        before: Array2<f64>,
        (start, moved): (Option<&WearState>, f64),
        drive: Drive,
    ) -> Result<WearState, Refusal> {
        let growth = self.coefficient * moved;
        let mut depth = before;
        depth.zip_mut_with(pressure, |w, p| *w += growth * p);
        let mut state = self.certify(pressure, &depth, drive)?;
        let values = &*contiguous(pressure);
        state.dissipated = growth * (gfmd_vector::dot(values, values) / values.len() as f64);
        let [pressed, approach, stored] = start
            .map_or([0.0; 3], |start| [start.solution.mean_pressure, start.solution.approach, start.elastic_energy]);
        let work = 0.5 * (pressed + state.solution.mean_pressure) * (state.solution.approach - approach);
        let missing = work - (state.elastic_energy - stored) - state.dissipated;
        state.work_imbalance = if moved == 0.0 { 0.0 } else { missing.abs() };
        Ok(state)
    }
}

impl Equilibrium for WearContact {
    type State = WearState;

    fn solvers(&self) -> &'static [Solver] {
        self.contact.solvers()
    }

    /// Accepts approaches beyond the mean clearance, which worn surfaces can reach.
    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        drive.check()?;
        Self::check_distance(drive.distance, None)?;
        match drive.load {
            Load::Approach(approach) if approach > 0.0 && self.contact.boundary() == Boundary::Periodic => Ok(()),
            _ => self.contact.check(drive),
        }
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        self.contact.check_resolution(drive, tolerance)
    }

    /// Makes the step from `start`, or from first touch at distance 0, by one solve.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&WearState>,
        watch: &mut dyn Watch,
    ) -> Result<WearState, SolveError<WearState>> {
        budget.check().map_err(Refusal::from)?;
        self.check(drive)?;
        let moved = Self::check_distance(drive.distance, start)?;
        let before = start.map_or_else(|| self.zeros(), |start| start.depth.clone());
        let Worn { contact, touch } = self.after_wear(&before)?;
        let load = match drive.load {
            Load::Approach(approach) => match beyond(approach, touch) {
                Some(beyond) => Load::Approach(beyond),
                None => return Ok(self.end(&self.zeros(), before, (start, moved), drive)?),
            },
            pressure => pressure,
        };
        let contact = if moved == 0.0 { contact } else { contact.softened(self.coefficient * moved)? };
        let warm = start.filter(|start| start.solution.mean_pressure > 0.0).map(|start| &start.solution);
        let (solution, ending) = match contact.equilibrate(load.into(), solver, budget, warm, watch) {
            Ok(solution) => (solution, Ending::Converged),
            Err(SolveError::NotConverged { state, why, .. }) => (*state, Ending::GaveUp(why)),
            Err(SolveError::Interrupted { state }) => (*state, Ending::Interrupted),
            Err(SolveError::Refused(refusal)) => return Err(refusal.into()),
            Err(SolveError::Detached { .. }) => return Err(Refusal::OtherKind.into()),
        };
        let mut state = self.end(&solution.pressure, before, (start, moved), drive)?;
        let Effort { iterations, transform_pairs } = solution.effort;
        state.solution.effort.iterations += iterations;
        state.solution.effort.transform_pairs += transform_pairs;
        judge(state, ending, budget.tolerance)
    }
}

impl Resumable for WearContact {
    fn keep(&self, state: &mut WearState, visitor: &mut dyn Visit) {
        let WearState { solution, distance, depth, dissipated, work_imbalance, .. } = state;
        for field in [&mut solution.pressure, depth] {
            with_contiguous(field, |field| visitor.field(field));
        }
        visitor.numbers(&mut [distance, dissipated, work_imbalance]);
        solution.effort.visit(visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<WearState, Refusal> {
        self.check(drive)?;
        let [mut pressure, mut depth] = [self.zeros(), self.zeros()];
        for field in [&mut pressure, &mut depth] {
            with_contiguous(field, |field| visitor.field(field));
        }
        let (mut distance, mut dissipated, mut work_imbalance) = (0.0, 0.0, 0.0);
        visitor.numbers(&mut [&mut distance, &mut dissipated, &mut work_imbalance]);
        let mut state = self.certify(&pressure, &depth, Drive { distance, ..drive })?;
        (state.dissipated, state.work_imbalance) = (dissipated, work_imbalance);
        state.solution.effort.visit(visitor);
        Ok(state)
    }
}
