//! Friction at a hard wall, solved for the tractions. The normal contact with the last shear, and the shear with the
//! limits set by the pressure, are solved alternately until both agree (Panagiotopoulos 1975).

mod certify;
mod division;
mod increment;
mod normal;
mod response;
mod state;
mod tangential;

use std::sync::Arc;

use gfmd_contact::{Boundary, Drive, Equilibrium, Load, Refusal, RigidSurface, SolveError, Solver, Units, judge};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_law::Limit;
use gfmd_relax::{Budget, Ending, Progress, Watch, Why};
use gfmd_response::{FreeFullCompliance, FullResponse};
use ndarray::ArrayRef2;

use certify::certify;
use increment::Increment;
use response::Response;
pub use state::{FrictionResidual, FrictionState};

/// A rigid rough surface pressed on an elastic one and moved laterally, with a hard wall and friction.
///
/// Friction depends on history: a drive is one increment from the previous state. At points where |shear| is below its
/// limit the surfaces stick, that is, move together during the increment; at the limit they may slip against the shear.
/// The slip of a point that comes into contact counts from its position at the start of the increment.
///
/// With [`Limit::Tresca`] the limit is discontinuous at the contact edge. If shear moves the surface up and down (for
/// all bodies except ν = ½), a point at the edge may have no solution, because its shear lifts it out of contact. The
/// solver then returns [`SolveError::NotConverged`]. A clone shares the data.
#[derive(Clone, Debug)]
pub struct FrictionalContact {
    /// Response of the body, rigid surface and shear limit, in `units`.
    response: Response,
    surface: Arc<RigidSurface>,
    limit: Limit,
    /// Rigid surface as given.
    given: Arc<RigidSurface>,
    /// E* as given.
    contact_modulus: f64,
    units: Units,
}

/// Reason why transforming or reshaping a field cannot fail.
const FITS: &str = "every field of a contact has the size of its grid";

/// Maximum number of rounds of normal and tangential problem.
const ROUNDS: usize = 150;
/// Number of rounds after which the alternation may be cyclic. From then on, only the fraction [`PART`] of the shear
/// change is passed to the normal problem.
const WHOLE_ROUNDS: usize = 20;
const PART: f64 = 0.3;
/// Final tolerance of either problem divided by the tolerance of the contact.
const SHARE: f64 = 0.1;
/// Tolerance of either problem divided by the previous residual of the contact. A round reduces the residual to about a
/// fifth, so that the next round would change more accurate results; with larger values slabs take more rounds.
const SHARE_OF_RESIDUAL: f64 = 0.075;
/// Tolerance of both problems in the first round, and upper limit for the later ones.
const FIRST_ROUND_TOLERANCE: f64 = 1e-3;
/// Largest fraction of a prescribed approach that lies within the tolerance of a round.
const OF_THE_APPROACH: f64 = 0.1;

/// The only solver; it alternates between projected conjugate gradients and spectral projected gradients.
const SOLVERS: [Solver; 1] = [Solver::Auto];

impl FrictionalContact {
    /// Creates a contact. `heights` is the rigid profile on `grid`, peaks towards the body, in length; only differences
    /// matter.
    ///
    /// # Errors
    /// Returns an error for heights that do not match the grid, are not finite or are all equal, or a negative limit.
    pub fn new(body: &Body, grid: &Grid, heights: &ArrayRef2<f64>, limit: Limit) -> Result<Self, Refusal> {
        Self::with_boundary(Boundary::Periodic, body, grid, heights, limit)
    }

    /// Creates a contact as [`new`](Self::new), with the given boundary. With [`Boundary::Free`] displacements are
    /// relative to points far away, and a mean pressure is the force divided by Lx Ly.
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new) and, with free boundaries, for a profile, for a body without lateral
    /// support, or for layers that are too thin.
    pub fn with_boundary(
        boundary: Boundary,
        body: &Body,
        grid: &Grid,
        heights: &ArrayRef2<f64>,
        limit: Limit,
    ) -> Result<Self, Refusal> {
        let limit = limit.check()?;
        let given = Self::rough(grid, heights, boundary)?;
        let units = Units::of(body, &given)?;
        let limit = match limit {
            Limit::Coulomb(coefficient) => Limit::Coulomb(coefficient),
            Limit::Tresca(strength) => Limit::Tresca(strength / units.stress()),
        };
        let contact_modulus = body.contact_modulus();
        let (grid, body) = (units.grid(grid), units.body(body));
        let response = match boundary {
            Boundary::Periodic => Response::Periodic(FullResponse::new(grid, &body).into()),
            Boundary::Free => Response::Free(FreeFullCompliance::new(grid, &body)?.into()),
        };
        let surface = units.surface(&given);
        Ok(Self { response, surface, limit, given, contact_modulus, units })
    }

    /// Creates a contact as [`new`](Self::new), on an existing response, for example one shared by many surfaces on one
    /// body. The problem is solved in the units of the response, whatever its size.
    ///
    /// # Errors
    /// Returns an error for heights that do not match the grid, are not finite or are all equal, or a negative limit.
    pub fn with_response(
        response: impl Into<Arc<FullResponse>>,
        heights: &ArrayRef2<f64>,
        limit: Limit,
    ) -> Result<Self, Refusal> {
        let response = response.into();
        let limit = limit.check()?;
        let surface = Self::rough(response.grid(), heights, Boundary::Periodic)?;
        let (given, contact_modulus) = (Arc::clone(&surface), response.contact_modulus());
        let response = Response::Periodic(response);
        Ok(Self { response, surface, limit, given, contact_modulus, units: Units::ONE })
    }

    fn rough(grid: &Grid, heights: &ArrayRef2<f64>, boundary: Boundary) -> Result<Arc<RigidSurface>, Refusal> {
        let surface = RigidSurface::new(grid, heights)?;
        let surface = if boundary == Boundary::Free { surface.alone() } else { surface };
        if surface.rms_height() > 0.0 { Ok(surface.into()) } else { Err(Refusal::Flat) }
    }

    /// Returns the rigid surface.
    #[allow(clippy::misnamed_getters, reason = "`surface` is the one in the units of the solve")]
    pub fn surface(&self) -> &RigidSurface {
        &self.given
    }

    /// Returns the state of `drive` before its solution, with the initial guess of all tractions.
    pub(crate) fn at_start(&self, drive: Drive) -> FrictionState {
        certify(&mut Increment::new(self, self.units.drive(drive), None))
    }

    /// Returns the boundary of the surface.
    pub fn boundary(&self) -> Boundary {
        self.response.boundary()
    }

    /// Returns the number of lateral components.
    fn lateral_components(&self) -> usize {
        self.response.components().len() - 1
    }
}

impl Equilibrium for FrictionalContact {
    type State = FrictionState;

    fn solvers(&self) -> &'static [Solver] {
        &SOLVERS
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        drive.check()?;
        match drive.load {
            Load::MeanPressure(found) if found <= 0.0 => Err(Refusal::NotPressed { what: "mean pressure", found }),
            Load::Approach(found) if found <= 0.0 => Err(Refusal::NotPressed { what: "approach", found }),
            Load::Approach(found) => {
                let limit = self.given.mean_clearance();
                if self.response.has_fixed_level() && found >= limit {
                    return Err(Refusal::Approach { found, limit: Some(limit) });
                }
                Ok(())
            }
            Load::MeanPressure(found) => Units::check_pressure(found),
        }
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        let [softest, _] = self.response.stiffness_range();
        self.given.check_resolution(drive.load, softest * self.units.stiffness(), tolerance)
    }

    /// Solves the contact at the end of an increment from `start`, or from the undeformed surface.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&FrictionState>,
        watch: &mut dyn Watch,
    ) -> Result<FrictionState, SolveError<FrictionState>> {
        budget.check()?;
        self.check(drive)?;
        self.check_resolution(drive, budget.tolerance)?;
        if !SOLVERS.contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: &SOLVERS }.into());
        }
        let expected = self.response.components().len() * self.surface.clearance().len();
        if let Some(found) = start.map(|state| state.displacement.len()).filter(|found| *found != expected) {
            return Err(Refusal::Start { found, expected }.into());
        }
        if self.units.are_one() {
            return self.slip(drive, budget, start, watch);
        }
        let (length, stress) = (self.units.length(), self.units.stress());
        let start = start.map(|state| state.clone().times(1.0 / length, 1.0 / stress));
        let given = |state: FrictionState| state.times(length, stress);
        let state =
            self.slip(self.units.drive(drive), budget, start.as_ref(), watch).map_err(|error| error.map(given))?;
        Units::check_pressure(state.mean_pressure * stress)?;
        Ok(given(state))
    }
}

impl FrictionalContact {
    /// Solves an increment in [`units`](Self::units).
    fn slip(
        &self,
        drive: Drive,
        budget: &Budget,
        start: Option<&FrictionState>,
        watch: &mut dyn Watch,
    ) -> Result<FrictionState, SolveError<FrictionState>> {
        let mut increment = Increment::new(self, drive, start);
        let mut iterations = 0;
        let mut ending = Ending::GaveUp(Why::Circles);
        // A surface moved by a prescribed approach must not count as solved without pressure.
        let coarsest = |increment: &Increment| match drive.load {
            Load::Approach(approach) => FIRST_ROUND_TOLERANCE.min(OF_THE_APPROACH * approach / increment.length_scale),
            Load::MeanPressure(_) => FIRST_ROUND_TOLERANCE,
        };
        let mut tolerance = coarsest(&increment);
        for round in 0..ROUNDS {
            let part = Budget {
                tolerance: tolerance.max(SHARE * budget.tolerance),
                max_iterations: budget.max_iterations.saturating_sub(iterations),
            };
            let mut part_watch =
                |now: &Progress| watch.see(&Progress { iteration: iterations + now.iteration, ..*now });
            let pressed = increment.press(&part, &mut part_watch)?;
            if let Ending::GaveUp(_) = pressed.ending {
                ending = pressed.ending;
                break;
            }
            if pressed.ending == Ending::Converged {
                iterations += pressed.reached.iteration;
            }
            let mut part_watch =
                |now: &Progress| watch.see(&Progress { iteration: iterations + now.iteration, ..*now });
            let sheared = increment.shear(&part, &mut part_watch);
            increment.lift(if round < WHOLE_ROUNDS { 1.0 } else { PART });
            iterations += sheared.steps;
            if pressed.ending == Ending::Interrupted || sheared.ending == Ending::Interrupted {
                ending = Ending::Interrupted;
                break;
            }
            let mut state = certify(&mut increment);
            state.effort.iterations = iterations;
            tolerance = coarsest(&increment).min(SHARE_OF_RESIDUAL * state.residual.worst());
            if state.residual.worst() <= budget.tolerance {
                self.check_shear(&state, budget.tolerance)?;
                return Ok(state);
            }
        }
        let mut state = certify(&mut increment);
        state.effort.iterations = iterations;
        judge(state, ending, budget.tolerance)
    }

    /// Checks that the displacement caused by the shear can be resolved. On a thin plate it may be much larger than the
    /// roughness.
    fn check_shear(&self, state: &FrictionState, tolerance: f64) -> Result<(), Refusal> {
        let lateral = state.traction.outer_iter().take(self.lateral_components());
        let largest = lateral.flatten().fold(0.0, |most: f64, shear| most.max(shear.abs()));
        let [softest, _] = self.response.stiffness_range();
        self.surface.check_traction("shear traction", largest, softest, tolerance)
    }
}
