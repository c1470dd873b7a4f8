//! Loads, each a problem of its own: the normal contact alone, in its own units and with its own methods.

use gfmd_contact::{
    Cotangents, Drive, Gradient, GradientError, Load, Losses, Refusal, Resumable as _, SolveError, Solver, Stiffness,
    Units, Visit,
};
use gfmd_relax::{Budget, Watch};
use ndarray::ArrayRef2;

use super::normal::{Normal, NormalState};
use super::{Parts, QuasistaticContact, QuasistaticState, Sequence, StiffnessError};

impl QuasistaticContact {
    /// Creates the contact of these parts under loads.
    pub(super) fn of_loads(parts: &Parts) -> Result<Self, Refusal> {
        parts.check_of_loads()?;
        if parts.held {
            parts.check_held()?;
        }
        let Parts { body, grid, heights, law, hardness, .. } = parts;
        let normal = Normal::of(parts, &parts.share(), (body, grid, *heights), law.clone(), None, hardness.as_ref())?;
        Ok(Self::of_normal(normal, body.contact_modulus()))
    }

    /// Creates the contact under loads of this normal contact.
    pub(super) fn of_normal(normal: Normal, contact_modulus: f64) -> Self {
        let (given, scaled) = (normal.surface().clone(), normal.surface().clone());
        Self {
            sequence: Sequence::Loads,
            normal,
            medium: None,
            hardness: None,
            shear: None,
            response: None,
            wear: None,
            all_components: false,
            sideways: Vec::new(),
            given,
            scaled,
            contact_modulus,
            units: Units::ONE,
        }
    }

    /// Solves a load; the search begins at `start`.
    pub(super) fn load(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&QuasistaticState>,
        watch: &mut dyn Watch,
    ) -> Result<QuasistaticState, SolveError<QuasistaticState>> {
        let solved = self.normal.equilibrate(drive, solver, budget, start.map(|start| &start.normal), watch);
        let state = |normal| self.loaded(normal, drive);
        solved.map(state).map_err(|error| error.map(state))
    }

    /// Returns the state of a load.
    fn loaded(&self, normal: NormalState, drive: Drive) -> QuasistaticState {
        QuasistaticState {
            mean_shear: normal.law().map_or([0.0; 2], |state| state.mean_shear),
            plastic_fraction: normal.plastic_fraction(),
            normal,
            sheared: None,
            lateral: drive.lateral,
            time: drive.time,
            distance: drive.distance,
            memory: None,
            worn: None,
            pressed_in: None,
            stored: None,
            losses: Losses::default(),
            work_imbalance: 0.0,
        }
    }

    /// Computes the state of basis fields under a load.
    pub(super) fn certify_load(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<QuasistaticState, Refusal> {
        let normal = match (&self.normal, fields) {
            (Normal::Wall(contact), [pressure]) => contact.certify(pressure, drive.load).map(NormalState::Wall)?,
            (Normal::Wall(_), _) => return Err(Refusal::Basis { found: fields.len(), expected: 1 }),
            (Normal::Law(interface), _) => interface.certify_fields(fields, drive).map(NormalState::Law)?,
        };
        Ok(self.loaded(normal, drive))
    }

    /// Restores the state of a load from stored fields.
    pub(super) fn recall_load(&self, stored: crate::StoredFields<'_>) -> Result<QuasistaticState, Refusal> {
        let load = Load::Approach(stored.approach);
        Ok(self.loaded(self.normal.recall(stored)?, load.into()))
    }

    /// Computes the stiffness of a load.
    pub(super) fn stiffness_of_load(
        &self,
        state: &QuasistaticState,
        tolerance: f64,
    ) -> Result<Stiffness, StiffnessError> {
        match (&self.normal, &state.normal) {
            (Normal::Wall(contact), NormalState::Wall(solution)) => contact
                .stiffness(solution, tolerance)
                .map_err(|(reached, why)| StiffnessError::Inexact { reached, why }),
            // The linear problem of one load is short beside its search, and is solved as well as it can be.
            (Normal::Law(interface), NormalState::Law(state)) => Ok(interface.stiffness(state, 0.0)?),
            _ => Err(Refusal::OtherKind.into()),
        }
    }

    /// Computes the derivatives of a number with respect to the input of a load, from its derivatives with respect to
    /// the state, as [`Contact::gradient`](gfmd_contact::Contact::gradient) at a wall and as
    /// [`Interface::gradient`](crate::Interface::gradient) below a law.
    ///
    /// # Errors
    /// Returns the errors of either, and an error along a path, whose derivatives are
    /// [`gradient_along`](Self::gradient_along).
    pub fn gradient(&self, state: &QuasistaticState, load: Load, of: &Cotangents) -> Result<Gradient, GradientError> {
        match (self.sequence, &self.normal, &state.normal) {
            (Sequence::Loads, Normal::Wall(contact), NormalState::Wall(solution)) => {
                contact.gradient(solution, load, of)
            }
            (Sequence::Loads, Normal::Law(interface), NormalState::Law(state)) => interface.gradient(state, load, of),
            _ => Err(GradientError::Undetermined("the state is not the state of a load of this contact")),
        }
    }

    pub(super) fn keep_load(&self, state: &mut QuasistaticState, visitor: &mut dyn Visit) {
        match (&self.normal, &mut state.normal) {
            (Normal::Wall(contact), NormalState::Wall(solution)) => contact.keep(solution, visitor),
            (_, normal) => normal.visit(visitor),
        }
    }

    pub(super) fn restore_load(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<QuasistaticState, Refusal> {
        let normal = match &self.normal {
            Normal::Wall(contact) => contact.restore(drive, visitor).map(NormalState::Wall)?,
            Normal::Law(interface) => interface.restore(drive, visitor).map(NormalState::Law)?,
        };
        Ok(self.loaded(normal, drive))
    }
}

impl NormalState {
    /// Returns the fraction of points of all processes that the hardness holds; 0 without a hardness. Below a law these
    /// are the points that are pressed in.
    pub(super) fn plastic_fraction(&self) -> f64 {
        match self {
            Self::Wall(solution) => solution.plastic.as_ref().map_or(0.0, |plastic| plastic.fraction),
            Self::Law(state) => state.pressed_in.as_ref().map_or(0.0, |depth| {
                let (share, own) = (state.surface.share(), depth.iter().filter(|depth| **depth > 0.0).count());
                let points = if share.is_whole() { depth.len() } else { share.total() };
                share.each(own).into_iter().sum::<usize>() as f64 / points as f64
            }),
        }
    }
}
