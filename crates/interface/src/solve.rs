use gfmd_law::HardWall;

use crate::certify::certify;
use crate::ended::End;
use crate::{Drive, Interface, InterfaceError, Method, Normal, Settings, State, Watch, dynamics, newton};

impl Interface<'_> {
    /// Whether a drive can be posed.
    ///
    /// # Errors
    /// Numbers that are not finite, or an approach beyond full contact.
    pub fn check(&self, drive: Drive) -> Result<(), InterfaceError> {
        self.frame(drive).map(drop)
    }

    /// Goes downhill from `start` to a stable state. Without one, from the contact with a hard wall alone if the drive
    /// presses, else from the undeformed surface.
    ///
    /// # Errors
    /// Unusable drive, settings or start; or an error that carries the state reached.
    pub fn solve(
        &self,
        drive: Drive,
        settings: &Settings,
        start: Option<&State>,
        watch: Watch,
    ) -> Result<State, InterfaceError> {
        settings.check()?;
        let frame = self.frame(drive)?;
        let expected = frame.components() * frame.points();
        if let Some(found) = start.map(|state| state.displacement.len()).filter(|found| *found != expected) {
            return Err(InterfaceError::Start { found, expected });
        }
        let pressed = match drive.normal {
            Normal::MeanPressure(found) | Normal::Approach(found) => found > 0.0,
        };
        let on_wall = match start {
            None if pressed && !self.is_wall_alone() => Some(self.without_attraction(drive, settings, watch)?),
            _ => None,
        };
        let start = start.or(on_wall.as_ref());
        let has_energy = self.has_energy();
        let ended = match settings.method {
            Method::Newton if !has_energy => return Err(InterfaceError::NoEnergy),
            Method::Dynamics if self.law.has_wall() && frame.held[frame.z()] => {
                return Err(InterfaceError::NoDynamics);
            }
            Method::Dynamics => dynamics::relax_to_rest(self, &frame, settings, start, watch),
            Method::Auto if !has_energy => dynamics::relax_to_rest(self, &frame, settings, start, watch),
            Method::Auto | Method::Newton => newton::descend(self, &frame, settings, start, watch),
        };
        let mut state = Box::new(certify(self, &frame, &ended.position));
        state.iterations = ended.iterations;
        state.transform_pairs += ended.transform_pairs;
        state.passed_instability = ended.passed_instability;
        state.lowest_curvature = ended.lowest_curvature;
        let not_converged = |state, reason| InterfaceError::NotConverged { state, asked: settings.tolerance, reason };
        match (ended.end, drive.normal) {
            (End::Interrupted, _) => Err(InterfaceError::Interrupted { state }),
            (End::Detached, Normal::MeanPressure(mean_pressure)) => {
                Err(InterfaceError::Detached { mean_pressure, state })
            }
            _ if state.residual.worst() <= settings.tolerance => Ok(*state),
            (End::GaveUp(reason), _) => Err(not_converged(state, reason)),
            _ => Err(not_converged(state, "the recomputed residuals are larger than the solver's")),
        }
    }

    fn is_wall_alone(&self) -> bool {
        self.law.has_wall() && self.law.stiffness_bound(0.0) == 0.0 && self.law.steepness() == 0.0
    }

    /// The contact before the law acts.
    fn without_attraction(&self, drive: Drive, settings: &Settings, watch: Watch) -> Result<State, InterfaceError> {
        let wall = Interface { law: &HardWall, clearance: self.clearance.clone(), ..*self };
        let rough = Settings { method: Method::Newton, tolerance: settings.tolerance.max(1e-3), ..*settings };
        wall.solve(drive, &rough, None, watch)
    }
}
