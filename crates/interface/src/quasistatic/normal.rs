//! Elastic contact along the normal, which each step solves with other moduli and another clearance.

use std::sync::Arc;

use gfmd_contact::{
    Boundary, Contact, Drive, Effort, Equilibrium as _, Fields, Hardness, Heights, Load, Refusal, RigidSurface,
    Solution, SolveError, Solver, Springs, Variables as _, Visit,
};
use gfmd_field::{Grid, Share};
use gfmd_green::Body;
use gfmd_law::Law;
use gfmd_medium::Stiffening;
use gfmd_relax::{Budget, Watch};
use gfmd_response::NormalResponse;
use ndarray::{Array2, Axis, CowArray, Ix2};

use super::parts::Parts;
use super::response::Response;
use crate::{Interface, State, StoredFields};

/// Hard wall, solved for the pressure, or law, solved for the displacement.
#[derive(Clone, Debug)]
pub(super) enum Normal {
    Wall(Contact),
    Law(Interface),
}

/// State of a [`Normal`] contact.
#[derive(Clone, Debug)]
pub(super) enum NormalState {
    Wall(Solution),
    Law(State),
}

impl Normal {
    /// Creates the normal contact of these parts, with body, grid, heights and law in any units, and with the hardness
    /// in the same ones; `response` is the response of all components, with shear.
    pub(super) fn of(
        parts: &Parts,
        share: &Share,
        (body, grid, heights): (&Body, &Grid, Heights),
        law: Option<Arc<dyn Law>>,
        response: Option<&Response>,
        hardness: Option<&Hardness>,
    ) -> Result<Self, Refusal> {
        let Parts { boundary, all_components, held, .. } = parts;
        let of_all = |full| NormalResponse::of_all_components(full);
        let Some(law) = law else {
            let contact = match response {
                Some(Response::Periodic(full)) => Contact::with_response(of_all(full), heights)?,
                _ if *all_components => {
                    parts.check_moving_wall(share)?;
                    Contact::in_all_components(body, grid, heights)?
                }
                _ if *held => Contact::held_sideways_over(share, body, grid, heights)?,
                _ => Contact::with_boundary_over(share, *boundary, body, grid, heights)?,
            };
            let contact = contact.with_dynamics(parts.dynamics);
            return Ok(Self::Wall(match hardness {
                Some(hardness) => contact.with_hardness(hardness.clone())?,
                None => contact,
            }));
        };
        let interface = match response {
            _ if *all_components => {
                Interface::in_all_components_with_boundary_over(share, *boundary, body, grid, heights, law)?
            }
            _ if *held => Interface::held_sideways_over(share, body, grid, heights, law)?,
            Some(Response::Periodic(full)) => Interface::with_response(of_all(full), heights, law)?,
            _ => Interface::with_boundary_over(share, *boundary, body, grid, heights, law)?,
        };
        Ok(Self::Law(match hardness {
            Some(hardness) => interface.with_hardness(hardness.clone())?,
            None => interface,
        }))
    }

    /// Returns the rigid surface as given.
    pub(super) fn surface(&self) -> &Arc<RigidSurface> {
        match self {
            Self::Wall(contact) => contact.surface(),
            Self::Law(interface) => interface.surface(),
        }
    }

    pub(super) fn boundary(&self) -> Boundary {
        match self {
            Self::Wall(contact) => contact.boundary(),
            Self::Law(interface) => interface.boundary(),
        }
    }

    /// Returns the names of the fields that determine a state.
    pub(super) fn basis(&self) -> &'static [&'static str] {
        match self {
            Self::Wall(_) => &["pressure"],
            Self::Law(interface) => interface.basis(),
        }
    }

    pub(super) fn solvers(&self) -> &'static [Solver] {
        match self {
            Self::Wall(contact) => contact.solvers(),
            Self::Law(interface) => interface.solvers(),
        }
    }

    pub(super) fn check(&self, drive: Drive) -> Result<(), Refusal> {
        match self {
            Self::Wall(contact) => contact.check(drive),
            Self::Law(interface) => interface.check(drive),
        }
    }

    pub(super) fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        match self {
            Self::Wall(contact) => contact.check_resolution(drive, tolerance),
            Self::Law(interface) => interface.check_resolution(drive, tolerance),
        }
    }

    /// Returns the smallest and largest stiffness of a wave, stress/length.
    pub(super) fn stiffness_range(&self) -> [f64; 2] {
        match self {
            Self::Wall(contact) => contact.stiffness_range(),
            Self::Law(interface) => interface.elastic().stiffness_range(),
        }
    }

    /// Returns the contact on a body with other moduli, in tractions divided by the common factor of the stiffening.
    pub(super) fn stiffened(&self, stiffening: &Stiffening) -> Result<Self, Refusal> {
        Ok(match (self, stiffening) {
            (_, Stiffening::All(1.0)) => self.clone(),
            // A wall has no scale, but its hardness has one.
            (Self::Wall(contact), Stiffening::All(factor)) => Self::Wall(match contact.hardness() {
                Some(hardness) => contact.clone().with_hardness(hardness.times(1.0 / factor))?,
                None => contact.clone(),
            }),
            (Self::Wall(contact), Stiffening::Waves(factors)) => Self::Wall(contact.stiffened(factors)),
            (Self::Law(interface), Stiffening::All(factor)) => Self::Law(interface.weakened(*factor)),
            (Self::Law(interface), Stiffening::Waves(factors)) => Self::Law(interface.stiffened(factors)?),
        })
    }

    /// Returns the contact with point springs in series.
    pub(super) fn softened(&self, springs: Springs) -> Result<Self, Refusal> {
        Ok(match self {
            Self::Wall(contact) => Self::Wall(contact.softened(springs)?),
            Self::Law(interface) => Self::Law(interface.clone().with_springs(springs)?),
        })
    }

    /// Returns the contact with `depth` added to the clearance; `is_worn` if part of it is worn off.
    pub(super) fn with_depth(&self, depth: &Array2<f64>, is_worn: bool) -> Result<Self, Refusal> {
        Ok(match self {
            Self::Wall(contact) if is_worn => Self::Wall(contact.with_wear_depth(depth)?),
            Self::Wall(contact) => Self::Wall(contact.with_indentation(depth)?),
            Self::Law(interface) => Self::Law(interface.with_indentation(depth)?),
        })
    }

    /// Returns the contact above a surface displaced sideways without traction
    /// ([`Interface::displaced_sideways`]).
    pub(super) fn displaced_sideways(&self, displacement: &[f64]) -> Result<Self, Refusal> {
        match self {
            Self::Law(interface) => interface.displaced_sideways(displacement).map(Self::Law),
            Self::Wall(_) => Err(Refusal::AllComponents),
        }
    }

    pub(super) fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&NormalState>,
        watch: &mut dyn Watch,
    ) -> Result<NormalState, SolveError<NormalState>> {
        match self {
            Self::Wall(contact) => {
                let start = start.map(|start| start.wall().ok_or(Refusal::OtherKind)).transpose()?;
                let start = start.filter(|start| start.mean_pressure > 0.0);
                let solved = contact.equilibrate(drive, solver, budget, start, watch);
                solved.map(NormalState::Wall).map_err(|error| error.map(NormalState::Wall))
            }
            Self::Law(interface) => {
                let start = start.map(|start| start.law().ok_or(Refusal::OtherKind)).transpose()?;
                let solved = interface.equilibrate(drive, solver, budget, start, watch);
                solved.map(NormalState::Law).map_err(|error| error.map(NormalState::Law))
            }
        }
    }

    /// Computes the state of the pressure of `state` at a wall, or of its gap below a law, from fresh transforms.
    pub(super) fn certify(&self, state: &NormalState, drive: Drive) -> Result<NormalState, Refusal> {
        match (self, state) {
            (Self::Wall(contact), NormalState::Wall(solution)) => {
                contact.certify(&solution.pressure, drive.load).map(NormalState::Wall)
            }
            (Self::Law(interface), NormalState::Law(state)) => {
                let certified = interface.certify(&state.gap, &state.pressure(), drive)?;
                let (passed_instability, lowest_curvature) = (state.passed_instability, state.lowest_curvature);
                Ok(NormalState::Law(State { passed_instability, lowest_curvature, ..certified }))
            }
            _ => Err(Refusal::OtherKind),
        }
    }

    /// Computes the state of a pressure at a wall, or of a gap below a law, from fresh transforms.
    pub(super) fn certify_fields(
        &self,
        (gap, pressure): (&Array2<f64>, &Array2<f64>),
        drive: Drive,
    ) -> Result<NormalState, Refusal> {
        match self {
            Self::Wall(contact) => contact.certify(pressure, drive.load).map(NormalState::Wall),
            Self::Law(interface) => interface.certify(gap, pressure, drive).map(NormalState::Law),
        }
    }

    /// Restores a state from stored fields.
    pub(super) fn recall(&self, stored: StoredFields<'_>) -> Result<NormalState, Refusal> {
        match self {
            Self::Wall(contact) => {
                contact.certify(stored.pressure, Load::Approach(stored.approach)).map(NormalState::Wall)
            }
            Self::Law(interface) => interface.recall(stored).map(NormalState::Law),
        }
    }

    /// Returns the state without pressure under `load` of surfaces that are apart.
    pub(super) fn unloaded(&self, load: Load) -> Result<NormalState, Refusal> {
        let none = Array2::zeros(self.surface().shape());
        match self {
            Self::Wall(contact) => contact.certify(&none, load).map(NormalState::Wall),
            Self::Law(interface) => interface.blank(load.into()).map(NormalState::Law),
        }
    }

    /// Returns a state without forces, to be filled in.
    pub(super) fn blank(&self) -> Result<NormalState, Refusal> {
        match self {
            Self::Wall(_) => self.unloaded(Load::Approach(0.0)),
            Self::Law(_) => self.unloaded(Load::MeanPressure(0.0)),
        }
    }
}

impl NormalState {
    pub(super) fn wall(&self) -> Option<&Solution> {
        if let Self::Wall(solution) = self { Some(solution) } else { None }
    }

    pub(super) fn law(&self) -> Option<&State> {
        if let Self::Law(state) = self { Some(state) } else { None }
    }

    pub(super) fn effort(&mut self) -> &mut Effort {
        match self {
            Self::Wall(solution) => &mut solution.effort,
            Self::Law(state) => &mut state.effort,
        }
    }

    pub(super) fn approach(&mut self) -> &mut f64 {
        match self {
            Self::Wall(solution) => &mut solution.approach,
            Self::Law(state) => &mut state.approach,
        }
    }

    /// Returns the elastic energy per area, stress × length.
    pub(super) fn elastic_energy(&self) -> f64 {
        match self {
            Self::Wall(solution) => solution.summary().elastic_energy,
            Self::Law(state) => state.elastic_energy,
        }
    }

    /// Returns the energy of the law per area, stress × length; 0 without one.
    pub(super) fn interface_energy(&self) -> f64 {
        self.law().map_or(0.0, |state| state.interface_energy)
    }

    /// Returns the depth by which the surfaces were pressed into each other in the step.
    pub(super) fn pressed_in(&self) -> Option<&Array2<f64>> {
        match self {
            Self::Wall(solution) => solution.plastic.as_ref().map(|plastic| &plastic.depth),
            Self::Law(state) => state.pressed_in.as_ref(),
        }
    }

    /// Converts the state of the contact of a step, which divides tractions by `factor`, does not know the `depth` and
    /// the lateral displacement of the elastic surface without traction, and measures its approach from `touch`.
    pub(super) fn of_step(self, factor: f64, (depth, sideways): (Option<&Array2<f64>>, &[f64]), touch: f64) -> Self {
        match self {
            Self::Wall(mut state) => {
                if let Some(depth) = depth {
                    state.displacement -= depth;
                }
                if factor != 1.0 {
                    state.pressure.mapv_inplace(|p| p * factor);
                    state.mean_pressure *= factor;
                }
                state.approach += touch;
                Self::Wall(state)
            }
            Self::Law(state) => {
                let mut state = if factor == 1.0 { state } else { state.times(1.0, factor) };
                if let Some(depth) = depth {
                    let z = state.displacement.len_of(Axis(0)) - 1;
                    let mut displacement = state.displacement.index_axis_mut(Axis(0), z);
                    displacement -= depth;
                }
                state.displacement.iter_mut().zip(sideways).for_each(|(displacement, own)| *displacement += own);
                state.approach += touch;
                Self::Law(state)
            }
        }
    }

    /// Converts the state to the contact of a step, to start its search there: the inverse of
    /// [`of_step`](Self::of_step). At a wall the pressure alone is a start.
    pub(super) fn to_step(&self, factor: f64, (depth, sideways): (Option<&Array2<f64>>, &[f64]), touch: f64) -> Self {
        match self.clone() {
            Self::Wall(mut state) => {
                state.pressure.mapv_inplace(|p| p / factor);
                Self::Wall(state)
            }
            Self::Law(state) => {
                let mut state = state.times(1.0, 1.0 / factor);
                if let Some(depth) = depth {
                    let z = state.displacement.len_of(Axis(0)) - 1;
                    let mut displacement = state.displacement.index_axis_mut(Axis(0), z);
                    displacement += depth;
                }
                state.displacement.iter_mut().zip(sideways).for_each(|(displacement, own)| *displacement -= own);
                state.approach -= touch;
                Self::Law(state)
            }
        }
    }

    /// Converts the state to other units; `surface` and `contact_modulus` are in these.
    pub(super) fn times(self, length: f64, stress: f64, (surface, contact_modulus): (&Arc<RigidSurface>, f64)) -> Self {
        match self {
            Self::Wall(solution) => Self::Wall(solution.times(length, stress, surface, contact_modulus)),
            Self::Law(state) => {
                let surface = Arc::clone(surface);
                Self::Law(State { surface, contact_modulus, ..state.times(length, stress) })
            }
        }
    }

    pub(super) fn visit(&mut self, visitor: &mut dyn Visit) {
        match self {
            Self::Wall(solution) => solution.visit(visitor),
            Self::Law(state) => state.visit(visitor),
        }
    }

    /// Returns the fields that all states have.
    pub(super) fn fields(&self) -> &dyn Fields {
        match self {
            Self::Wall(solution) => solution,
            Self::Law(state) => state,
        }
    }

    pub(super) fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.fields().pressure()
    }

    pub(super) fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        self.fields().repulsion()
    }
}
