use std::any::Any;
use std::borrow::Cow;

use gfmd_contact::{
    Budget, Cotangents, Drive, Effort, Equilibrium, Fields, Gradient, Load, Quasistatic, Reading, Refusal, Resumable,
    RigidSurface, SolveError, Solver, Stiffness, Visit, Watch,
};
use gfmd_interface::{PathGradient, StoredFields, Trapping};
use gfmd_measure::{Scales, Summary};
use ndarray::{Array2, ArrayRef2, ArrayView2, CowArray, Ix2};

use crate::Unusable;
use crate::sideways::Sideways;

/// Kind of contact, with all that solvers, paths and files need. A new kind implements this trait, once.
pub trait ContactKind: Quasistatic + Resumable<State: Send + Sync + 'static> + Send + Sync + 'static {
    /// Returns the rigid surface; the upper one of two.
    fn surface(&self) -> &RigidSurface;

    /// Returns the names of the fields that [`certify`](Self::certify) needs for a state; empty if it cannot make one.
    fn basis(&self) -> &'static [&'static str] {
        &["pressure"]
    }

    /// Computes the state of the [`basis`](Self::basis) fields under a drive, with fresh transforms.
    ///
    /// # Errors
    /// Returns an error if the fields do not fit the grid, or if the drive is invalid.
    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<Self::State, Refusal>;

    /// Restores a state from stored fields, and from the fields of the lower face if there is one, as a start. The
    /// fields of the upper face have the approach of the two surfaces.
    ///
    /// # Errors
    /// Returns an error if fields are missing or do not fit the grid.
    fn recall(&self, stored: StoredFields<'_>, _lower: Option<StoredFields<'_>>) -> Result<Self::State, Refusal> {
        self.certify(&[stored.pressure], Load::Approach(stored.approach).into())
    }

    /// Computes the stiffness of a state at rest, d(mean pressure)/d(approach), stress/length, to this relative error.
    ///
    /// # Errors
    /// Returns the reason why there is no stiffness, or why it is less exact than requested.
    fn stiffness(&self, state: &Self::State, tolerance: f64) -> Result<Stiffness, NoStiffness>;

    /// Computes the stiffness of the state with this pressure and gap of each face, the upper one first, also where
    /// they do not determine the state.
    ///
    /// # Errors
    /// Returns an error as [`stiffness`](Self::stiffness), and for all kinds but those along a path.
    fn stiffness_of_fields(&self, _faces: &[[&ArrayRef2<f64>; 2]], _tolerance: f64) -> Result<Stiffness, NoStiffness> {
        Err(other_fields())
    }

    /// Computes the derivatives of a scalar under a load of this kind, from its derivatives with respect to a state.
    ///
    /// # Errors
    /// Returns the reason why there are none.
    fn gradient(&self, _state: &Self::State, _load: Load, _of: &Cotangents) -> Result<Gradient, Unusable> {
        Err(Unusable::of(
            "a load has derivatives if its contact is made of parts: one surface without finite slopes or yielding",
        ))
    }

    /// Computes the derivatives of a scalar along a path, from its derivatives with respect to the states at the ends
    /// of all increments, under loads of these kinds.
    ///
    /// # Errors
    /// Returns the reason why there are none.
    fn gradient_along(&self, _increments: &[OfState<Self::State>]) -> Result<PathGradient, Unusable> {
        Err(Unusable::of(
            "a path has derivatives if its contact is made of parts: one surface on a body that does not yield",
        ))
    }

    /// Returns a warning if the law is too steep for the grid.
    fn trapping(&self) -> Option<Trapping> {
        None
    }
}

/// Load of an increment, the state at its end, and derivatives with respect to this state, if there are some.
pub type OfState<'a, S> = (Load, &'a S, Option<&'a Cotangents>);

/// Returns the reason why the fields of another kind of contact give no stiffness.
pub(crate) fn other_fields() -> NoStiffness {
    NoStiffness::Undefined("the fields do not determine the state".into())
}

/// Returns the reason why the state of another kind of contact has no derivatives.
fn other_kind() -> Unusable {
    Unusable::of("the state is of another kind of contact")
}

/// Reasons why a contact has no stiffness, or an inexact one.
#[derive(Clone, Debug, PartialEq)]
pub enum NoStiffness {
    /// Not computed.
    Undefined(Cow<'static, str>),
    /// Less exact than requested: the stiffness reached, and a remark.
    Inexact(Stiffness, String),
}

/// State of any kind.
pub trait State: Fields + Any + Send + Sync {
    /// Returns the state for a downcast to its type.
    fn as_any(&self) -> &dyn Any;

    /// Returns the state for a mutable downcast to its type.
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

impl<S: Fields + Any + Send + Sync> State for S {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}

/// State at rest of a [`Posed`] problem, or the state reached by a solve that failed.
pub struct AnyState {
    state: Box<dyn State>,
    /// Lateral displacement by the pressure, if it is requested.
    sideways: Vec<Array2<f64>>,
}

impl AnyState {
    /// Wraps a state.
    pub fn new(state: impl State) -> Self {
        Self { state: Box::new(state), sideways: Vec::new() }
    }

    /// Returns the lateral displacement by the pressure, if it is requested.
    pub(crate) fn sideways(&self) -> &[Array2<f64>] {
        &self.sideways
    }

    /// Returns the state as its own type, for data that only one kind of contact has; `None` if it is of another kind.
    pub fn get<S: 'static>(&self) -> Option<&S> {
        (*self.state).as_any().downcast_ref()
    }

    fn get_mut<S: 'static>(&mut self) -> Option<&mut S> {
        (*self.state).as_any_mut().downcast_mut()
    }
}

impl Fields for AnyState {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.state.pressure()
    }

    fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        self.state.repulsion()
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.state.displacement_z()
    }

    fn gap(&self) -> ArrayView2<'_, f64> {
        self.state.gap()
    }

    fn mean_pressure(&self) -> f64 {
        self.state.mean_pressure()
    }

    fn approach(&self) -> f64 {
        self.state.approach()
    }

    fn effort(&self) -> Effort {
        self.state.effort()
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        let mut residuals = self.state.residuals();
        // The pressure alone acts on the surface that the lateral displacement follows from.
        residuals.extend((!self.sideways.is_empty()).then_some(("lateral_traction", 0.0)));
        residuals
    }

    fn worst(&self) -> f64 {
        self.state.worst()
    }

    fn scales(&self) -> Scales {
        self.state.scales()
    }

    fn summary_in(&self, scales: &Scales) -> Summary {
        self.state.summary_in(scales)
    }
}

/// Returns a state as its own type.
fn own<S: 'static>(state: &AnyState) -> Result<&S, Refusal> {
    state.get().ok_or(Refusal::OtherKind)
}

/// Problem of any kind, ready to be solved. Everything that takes an [`Equilibrium`] takes it, such as
/// [`Press`](gfmd_contact::Press) and [`Path`](gfmd_interface::Path).
pub type Posed = Box<dyn ContactKind<State = AnyState>>;

/// Poses a contact; `sideways` completes its states by the lateral displacement.
pub(crate) fn posed(kind: impl ContactKind, sideways: Option<Sideways>) -> Posed {
    Box::new(OfAnyState { kind, sideways })
}

/// Contact of one kind that takes and gives states of any kind.
struct OfAnyState<K> {
    kind: K,
    /// Response of the lateral displacement, if it is requested beside a contact in u_z.
    sideways: Option<Sideways>,
}

impl<K: ContactKind> OfAnyState<K> {
    /// Returns a state of this kind, completed by its lateral displacement if that is requested.
    fn any(&self, state: K::State) -> AnyState {
        let state = AnyState::new(state);
        match &self.sideways {
            Some(sideways) => AnyState { sideways: sideways.displacement(&state), ..state },
            None => state,
        }
    }

    /// Returns the result of a solve with a state of any kind.
    fn solved(&self, solved: Result<K::State, SolveError<K::State>>) -> Result<AnyState, SolveError<AnyState>> {
        solved.map(|state| self.any(state)).map_err(|error| error.map(|state| self.any(state)))
    }
}

impl<K: ContactKind> Equilibrium for OfAnyState<K> {
    type State = AnyState;

    fn solvers(&self) -> &'static [Solver] {
        self.kind.solvers()
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        self.kind.check(drive)
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        self.kind.check_resolution(drive, tolerance)
    }

    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&AnyState>,
        watch: &mut dyn Watch,
    ) -> Result<AnyState, SolveError<AnyState>> {
        let start = start.map(own).transpose()?;
        self.solved(self.kind.equilibrate(drive, solver, budget, start, watch))
    }
}

impl<K: ContactKind> Resumable for OfAnyState<K> {
    fn keep(&self, state: &mut AnyState, visitor: &mut dyn Visit) {
        if let Some(state) = state.get_mut() {
            self.kind.keep(state, visitor);
        }
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<AnyState, Refusal> {
        self.kind.restore(drive, visitor).map(|state| self.any(state))
    }
}

impl<K: ContactKind> Quasistatic for OfAnyState<K> {
    fn reading(&self, state: &AnyState) -> Reading {
        state.get().map_or_else(|| Reading::of(state), |state| self.kind.reading(state))
    }

    fn depends_on_division(&self, start: Option<&AnyState>, end: &AnyState, tolerance: f64) -> bool {
        end.get().is_some_and(|end| self.kind.depends_on_division(start.and_then(AnyState::get), end, tolerance))
    }

    fn change(&self, start: Option<&AnyState>, from: &AnyState, to: &AnyState) -> f64 {
        let both = from.get().zip(to.get());
        both.map_or(f64::NAN, |(from, to)| self.kind.change(start.and_then(AnyState::get), from, to))
    }

    fn change_of_stick(&self, from: &AnyState, to: &AnyState) -> f64 {
        from.get().zip(to.get()).map_or(f64::NAN, |(from, to)| self.kind.change_of_stick(from, to))
    }

    fn slips(&self) -> bool {
        self.kind.slips()
    }

    fn polish(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        (start, near): (Option<&AnyState>, &AnyState),
        watch: &mut dyn Watch,
    ) -> Result<AnyState, SolveError<AnyState>> {
        let from = (start.map(own).transpose()?, own(near)?);
        self.solved(self.kind.polish(drive, solver, budget, from, watch))
    }
}

impl<K: ContactKind> ContactKind for OfAnyState<K> {
    fn surface(&self) -> &RigidSurface {
        self.kind.surface()
    }

    fn basis(&self) -> &'static [&'static str] {
        self.kind.basis()
    }

    fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<AnyState, Refusal> {
        self.kind.certify(fields, drive).map(|state| self.any(state))
    }

    fn recall(&self, stored: StoredFields<'_>, lower: Option<StoredFields<'_>>) -> Result<AnyState, Refusal> {
        self.kind.recall(stored, lower).map(|state| self.any(state))
    }

    fn stiffness(&self, state: &AnyState, tolerance: f64) -> Result<Stiffness, NoStiffness> {
        match state.get() {
            Some(state) => self.kind.stiffness(state, tolerance),
            None => Err(NoStiffness::Undefined("the state is of another kind of contact".into())),
        }
    }

    fn stiffness_of_fields(&self, faces: &[[&ArrayRef2<f64>; 2]], tolerance: f64) -> Result<Stiffness, NoStiffness> {
        self.kind.stiffness_of_fields(faces, tolerance)
    }

    fn gradient(&self, state: &AnyState, load: Load, of: &Cotangents) -> Result<Gradient, Unusable> {
        self.kind.gradient(state.get().ok_or_else(other_kind)?, load, of)
    }

    fn gradient_along(&self, increments: &[OfState<AnyState>]) -> Result<PathGradient, Unusable> {
        let own = increments.iter().map(|(load, state, of)| Ok((*load, state.get().ok_or_else(other_kind)?, *of)));
        self.kind.gradient_along(&own.collect::<Result<Vec<_>, Unusable>>()?)
    }

    fn trapping(&self) -> Option<Trapping> {
        self.kind.trapping()
    }
}

const _: () = {
    const fn shared<T: Send + Sync>() {}
    shared::<Posed>();
    shared::<AnyState>();
};
