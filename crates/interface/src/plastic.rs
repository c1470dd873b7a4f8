//! Hard wall with permanent plastic depth, along a path.

use gfmd_contact::{
    Contact, Drive, Equilibrium, Fields as _, Hardness, Load, Refusal, Resumable, Solution, SolveError, Solved, Solver,
    Visit,
};
use gfmd_relax::{Budget, Watch};
use gfmd_vector::with_contiguous;
use ndarray::{Array2, ArrayRef2};

use crate::path::{Loss, Quasistatic, Reading};

/// A contact with a hard wall, a hardness and permanent plastic depth: each state begins at the plastic depth of the
/// previous state (theory.md, section 7.2).
///
/// The depth so far is added to the clearance. Where the pressure equals the hardness, the depth grows until the gap is
/// closed; elsewhere it is constant. A step is implicit: all of its growth takes place under the final pressure. The
/// plastic work is lost, the mean of hardness times growth. Unloading and reloading up to the previous load are
/// elastic. Without a hardness no energy is lost.
#[derive(Clone, Debug)]
pub struct PlasticContact {
    contact: Contact,
}

/// State of a [`PlasticContact`].
#[derive(Clone, Debug)]
pub struct PlasticState {
    /// Fields and residuals for the surface at the start of the step; the plastic part is the growth in the step.
    pub solution: Solution,
    /// Plastic depth so far, in length.
    pub depth: Array2<f64>,
    /// Mean of `depth` over the whole surface, in length.
    pub volume: f64,
    /// Elastic energy per area, in stress × length.
    pub elastic_energy: f64,
    /// Energy lost in the step, per area, in stress × length.
    pub dissipated: f64,
    /// Fraction of points with a pressure equal to the hardness. A pressure counts as equal if it is lower by at most
    /// ten times the pressure that would close the largest gap left in contact, or by a thousandth of the hardness,
    /// whichever is less. Reloaded to its largest load, a contact then has the hardness at all points that it had
    /// flattened, within the residuals of both states.
    pub fraction: f64,
    /// Depth at the start of the step.
    before: Array2<f64>,
}

impl PlasticContact {
    /// Creates the plastic contact; the surfaces of `contact` are undeformed at the start.
    pub fn new(contact: Contact) -> Self {
        Self { contact }
    }

    /// Returns the contact of the undeformed surfaces.
    pub fn contact(&self) -> &Contact {
        &self.contact
    }

    /// Computes the state of `pressure` under `load` on surfaces with the plastic `depth`, with residuals from fresh
    /// transforms.
    ///
    /// # Errors
    /// Returns an error if the shape of the fields differs from the grid or the depth is not finite.
    pub fn certify(
        &self,
        pressure: &ArrayRef2<f64>,
        depth: &ArrayRef2<f64>,
        load: Load,
    ) -> Result<PlasticState, Refusal> {
        let contact = self.contact.with_indentation(depth)?;
        let solution = match gap_at(&contact, load) {
            None => contact.certify(pressure, load)?,
            // Measured from the first touch of the flattened surfaces.
            Some((approach, gap)) => {
                let touch = approach + gap;
                let contact = self.contact.with_indentation(&depth.mapv(|depth| depth - touch))?;
                let mut solution = contact.certify(pressure, Load::Approach(-gap))?;
                solution.approach = approach;
                solution
            }
        };
        Ok(PlasticState::new(&self.contact, solution, depth.to_owned()))
    }

    /// Returns the contact and the depth at the start of the step after `state`.
    fn after(&self, state: Option<&PlasticState>) -> Result<(Contact, Array2<f64>), Refusal> {
        let depth =
            state.map_or_else(|| Array2::zeros(self.contact.surface().grid().points()), |state| state.depth.clone());
        Ok((self.contact.with_indentation(&depth)?, depth))
    }
}

/// Returns a prescribed approach at which flattened surfaces are apart, and their smallest gap; otherwise `None`.
fn gap_at(contact: &Contact, load: Load) -> Option<(f64, f64)> {
    let touch = contact.surface().clearance().iter().copied().fold(f64::INFINITY, f64::min);
    match load {
        // Undeformed surfaces touch at 0.
        Load::Approach(approach) if touch > 0.0 && approach <= touch => Some((approach, touch - approach)),
        _ => None,
    }
}

impl PlasticState {
    /// Creates the state of `contact` after a step from the depth `before`.
    fn new(contact: &Contact, solution: Solution, before: Array2<f64>) -> Self {
        let (depth, dissipated) = match &solution.plastic {
            Some(plastic) => {
                // The depth grows where the pressure is the hardness. A field has points, and therefore a mean, here
                // and below.
                let works = &solution.pressure * &plastic.depth;
                (&before + &plastic.depth, works.mean().unwrap_or(0.0))
            }
            None => (before.clone(), 0.0),
        };
        let volume = depth.mean().unwrap_or(0.0);
        let elastic_energy = solution.summary_in(&solution.scales()).elastic_energy;
        let fraction = contact.hardness().map_or(0.0, |hardness| {
            let [_, stiffest] = contact.stiffness_range();
            saturated(&solution, &hardness, stiffest)
        });
        Self { solution, depth, volume, elastic_energy, dissipated, fraction, before }
    }
}

/// Error of a pressure divided by the pressure that would close the largest gap left in contact; the depth contains the
/// gaps of earlier states.
const OF_A_GAP: f64 = 10.0;
/// Largest relative difference between pressure and hardness at a point that counts as plastic.
const NEAR: f64 = 1e-3;

/// Returns the fraction of points with a pressure equal to the hardness, to the accuracy shown by the gaps in contact.
fn saturated(solution: &Solution, hardness: &Hardness, stiffest: f64) -> f64 {
    let Solution { pressure, gap, .. } = solution;
    let touching = pressure.iter().zip(gap).filter(|(p, _)| **p > 0.0);
    let accuracy = OF_A_GAP * stiffest * touching.fold(0.0, |most: f64, (_, gap)| most.max(gap.abs()));
    let has = |p: f64, hardness: f64| p >= hardness - accuracy.min(NEAR * hardness);
    let count = match hardness {
        Hardness::Uniform(hardness) => pressure.iter().filter(|p| has(**p, *hardness)).count(),
        Hardness::Field(field) => pressure.iter().zip(field).filter(|(p, hardness)| has(**p, **hardness)).count(),
    };
    count as f64 / pressure.len() as f64
}

impl Solved for PlasticState {
    type Inner = Solution;

    fn solution(&self) -> &Solution {
        &self.solution
    }
}

impl Equilibrium for PlasticContact {
    type State = PlasticState;

    fn solvers(&self) -> &'static [Solver] {
        self.contact.solvers()
    }

    /// Ignores lateral displacement, which has no effect without friction.
    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        self.contact.check(drive)
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        self.contact.check_resolution(drive, tolerance)
    }

    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&PlasticState>,
        watch: &mut dyn Watch,
    ) -> Result<PlasticState, SolveError<PlasticState>> {
        let (contact, depth) = self.after(start)?;
        if gap_at(&contact, drive.load).is_some() {
            budget.check().map_err(Refusal::from)?;
            self.check(drive)?;
            return Ok(self.certify(&Array2::zeros(depth.raw_dim()), &depth, drive.load)?);
        }
        let start = start.map(|state| &state.solution).filter(|solution| solution.mean_pressure > 0.0);
        match contact.equilibrate(drive, solver, budget, start, watch) {
            Ok(solution) => Ok(PlasticState::new(&self.contact, solution, depth)),
            Err(error) => Err(error.map(|solution| PlasticState::new(&self.contact, solution, depth))),
        }
    }
}

impl Quasistatic for PlasticContact {
    fn reading(&self, state: &PlasticState) -> Reading {
        Reading {
            mean_pressure: state.solution.mean_pressure,
            approach: state.solution.approach,
            mean_shear: [0.0; 2],
            lateral: [0.0; 2],
            time: 0.0,
            distance: 0.0,
            loss: Loss::Known(state.dissipated),
        }
    }
}

impl Resumable for PlasticContact {
    fn keep(&self, state: &mut PlasticState, visitor: &mut dyn Visit) {
        with_contiguous(&mut state.before, |depth| visitor.field(depth));
        self.contact.keep(&mut state.solution, visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<PlasticState, Refusal> {
        let mut before = Array2::zeros(self.contact.surface().grid().points());
        with_contiguous(&mut before, |depth| visitor.field(depth));
        let contact = self.contact.with_indentation(&before)?;
        let solution = contact.restore(drive, visitor)?;
        if gap_at(&contact, drive.load).is_some() {
            return self.certify(&solution.pressure, &before, drive.load);
        }
        Ok(PlasticState::new(&self.contact, solution, before))
    }
}
