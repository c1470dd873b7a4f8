//! Friction behind a hard wall, solved in the tractions: the normal contact under the shear of the last round, then the
//! shear under the limits that its pressure sets (Panagiotopoulos 1975), until both fit.

mod certify;
mod increment;
mod normal;
mod state;
mod tangential;

use gfmd_law::{LawError, Limit};
use gfmd_relax::{Ending, Minimum};
use gfmd_response::FullResponse;
use ndarray::ArrayView2;

use crate::numbers::mean;
use crate::problem::heights_to_clearance;
use crate::{Drive, InterfaceError, Normal, Progress, Settings, Watch};
use certify::certify;
use increment::Increment;
pub use state::{FrictionResidual, FrictionState};

/// A rigid rough surface pressed on an elastic one and moved sideways, with a hard wall and friction.
///
/// Friction remembers: a drive is one increment, from the state before it. Where |shear| is below its limit the surfaces
/// stick, that is, move together during the increment; where it is at the limit they may slip against it. A surface that
/// comes into contact counts its slip from where it was before.
///
/// With [`Limit::Tresca`] the limit jumps at the edge of the contact. On a body whose shear moves the surface up and down
/// (all but ν = ½) a point of the edge may then have no state at all: in contact, its shear lifts it off. That shows as
/// [`InterfaceError::FrictionNotConverged`].
pub struct FrictionalContact<'a> {
    response: &'a FullResponse,
    clearance: Vec<f64>,
    rms_height: f64,
    limit: Limit,
}

/// The lengths are those of the grid, by construction: a transform cannot refuse them.
const FITS: &str = "every field of a contact has the size of its grid";

/// Rounds of normal and tangential problem.
const ROUNDS: usize = 150;
/// After so many rounds they may go in circles: each then answers to a part of what the other changed.
const WHOLE_ROUNDS: usize = 20;
const PART: f64 = 0.3;
/// Each part is solved this much better than asked, so that the whole can be.
const SHARE: f64 = 0.1;

impl<'a> FrictionalContact<'a> {
    /// `heights` is the rigid profile, peaks pointing at the body, length; only differences matter.
    ///
    /// # Errors
    /// Heights of another shape than the grid, not finite, or all equal; a negative limit.
    pub fn new(response: &'a FullResponse, heights: ArrayView2<f64>, limit: Limit) -> Result<Self, InterfaceError> {
        let limit = limit.check()?;
        let (clearance, rms_height) = heights_to_clearance(heights, response.grid())?;
        if rms_height == 0.0 {
            return Err(InterfaceError::Flat);
        }
        Ok(Self { response, clearance, rms_height, limit })
    }

    /// Brings the contact to rest at the end of an increment that begins with `start`, or with the undeformed surface.
    ///
    /// # Errors
    /// Unusable drive, settings or start; or an error that carries the state reached.
    pub fn solve(
        &self,
        drive: Drive,
        settings: &Settings,
        start: Option<&FrictionState>,
        watch: Watch,
    ) -> Result<FrictionState, InterfaceError> {
        settings.check()?;
        self.check(drive)?;
        let expected = self.response.components().len() * self.clearance.len();
        if let Some(found) = start.map(|state| state.displacement.len()).filter(|found| *found != expected) {
            return Err(InterfaceError::Start { found, expected });
        }
        let mut increment = Increment::new(self, drive, start);
        let mut iterations = 0;
        let mut reason = "normal and tangential problem do not settle";
        for round in 0..ROUNDS {
            // The first rounds only have to be as good as the next one can use.
            let tolerance = SHARE * settings.tolerance.max(1e-2 * 0.1_f64.powi(2 * round as i32));
            let limit = settings.max_iterations.saturating_sub(iterations);
            let pressed = increment.press(tolerance, limit, &mut |now: &gfmd_relax::Progress| {
                watch(&Progress { iteration: iterations + now.iteration, residual: now.residual })
            });
            let interrupted = match pressed {
                Ok(Minimum { reached, ending: Ending::Converged }) => {
                    iterations += reached.iteration;
                    false
                }
                Ok(Minimum { ending: Ending::Interrupted, .. }) => true,
                Ok(Minimum { ending: Ending::GaveUp(_), .. }) | Err(_) => {
                    reason = "the normal problem does not converge";
                    break;
                }
            };
            let sheared = increment.shear(tolerance, limit, &mut |steps, residual| {
                watch(&Progress { iteration: iterations + steps, residual })
            });
            increment.lift(if round < WHOLE_ROUNDS { 1.0 } else { PART });
            iterations += sheared.steps;
            let mut state = certify(&mut increment);
            state.iterations = iterations;
            if interrupted || sheared.interrupted {
                return Err(InterfaceError::FrictionInterrupted { state: Box::new(state) });
            }
            if state.residual.worst() <= settings.tolerance {
                return Ok(state);
            }
        }
        let mut state = Box::new(certify(&mut increment));
        state.iterations = iterations;
        Err(InterfaceError::FrictionNotConverged { state, asked: settings.tolerance, reason })
    }

    fn lateral_components(&self) -> usize {
        self.response.components().len() - 1
    }

    /// Whether a drive can be posed.
    ///
    /// # Errors
    /// Numbers that are not finite, a drive without contact, or an approach beyond full contact.
    pub fn check(&self, drive: Drive) -> Result<(), InterfaceError> {
        drive.check()?;
        match drive.normal {
            Normal::MeanPressure(found) if found <= 0.0 => {
                return Err(InterfaceError::NotPressed { what: "mean pressure", found });
            }
            Normal::Approach(found) if found <= 0.0 => {
                return Err(InterfaceError::NotPressed { what: "approach", found });
            }
            Normal::Approach(found) => {
                let limit = mean(&self.clearance);
                if self.response.uniform_compliance()[2] == 0.0 && found >= limit {
                    return Err(InterfaceError::Approach { found, limit });
                }
            }
            Normal::MeanPressure(_) => {}
        }
        Ok(())
    }
}

impl From<LawError> for InterfaceError {
    fn from(error: LawError) -> Self {
        Self::Law(error)
    }
}
