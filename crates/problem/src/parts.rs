//! Parts of states that only one kind of contact has.

use gfmd_contact::{FullSolution, Plastic, Solution, SqueezedSolution, SteepSolution};
use gfmd_interface::{FrictionState, PlasticState, State};
use gfmd_viscoelastic::ViscoelasticState;
use gfmd_wear::WearState;
use ndarray::{Array2, Array3};

use crate::AnyState;

impl AnyState {
    /// Returns the state of a hard wall; the upper face if there are two.
    pub fn wall(&self) -> Option<&Solution> {
        let full = || self.get().map(|state: &FullSolution| &state.normal);
        let squeezed = || self.get().map(|state: &SqueezedSolution| &state.upper);
        let on_path = || self.on_path().map(|state| &state.solution);
        let relaxing = || self.get().map(|state: &ViscoelasticState| &state.solution);
        self.get()
            .or_else(full)
            .or_else(|| self.steep().map(|state| &state.normal))
            .or_else(squeezed)
            .or_else(on_path)
            .or_else(relaxing)
            .or_else(|| self.worn().map(|state| &state.solution))
    }

    /// Returns the plastic points of a load with a hardness.
    pub fn plastic(&self) -> Option<&Plastic> {
        self.get::<Solution>()?.plastic.as_ref()
    }

    /// Returns the plastic depth `[x, y]` of a state with a hardness, length: of the load, or accumulated on a path.
    pub fn plastic_depth(&self) -> Option<&Array2<f64>> {
        let so_far = || self.on_path().filter(|state| state.solution.plastic.is_some()).map(|state| &state.depth);
        self.plastic().map(|plastic| &plastic.depth).or_else(so_far)
    }

    /// Returns the lateral displacement u_x, u_y (u_x of a profile), `[x, y]`, length, if it was also unknown.
    pub fn lateral(&self) -> &[Array2<f64>] {
        let full = self.get().map(|state: &FullSolution| &state.lateral[..]);
        full.or_else(|| self.steep().map(|state| &state.lateral[..])).unwrap_or_default()
    }

    /// Returns the contact of the lower face of a slab between two surfaces, as seen from that face.
    pub fn lower(&self) -> Option<&Solution> {
        self.get::<SqueezedSolution>().map(|state| &state.lower)
    }

    /// Returns the traction on the elastic surface `[component, x, y]`, stress, of a state with a law or with friction.
    pub fn traction(&self) -> Option<&Array3<f64>> {
        self.law().map(|state| &state.traction).or_else(|| self.friction().map(|state| &state.traction))
    }

    /// Returns the state with finite slopes.
    pub fn steep(&self) -> Option<&SteepSolution> {
        self.get()
    }

    /// Returns the state with a law across the gap.
    pub fn law(&self) -> Option<&State> {
        self.get().or_else(|| self.get().map(|state: &ViscoelasticState<State>| &state.solution))
    }

    /// Returns the state with friction.
    pub fn friction(&self) -> Option<&FrictionState> {
        self.get()
    }

    /// Returns the [memory](ViscoelasticState::memory) of a viscoelastic body.
    pub fn memory(&self) -> Option<Vec<Array2<f64>>> {
        let wall = self.get::<ViscoelasticState>().map(ViscoelasticState::memory);
        wall.or_else(|| self.get::<ViscoelasticState<State>>().map(ViscoelasticState::memory))
    }

    /// Returns the state of surfaces that wear.
    pub fn worn(&self) -> Option<&WearState> {
        self.get()
    }

    /// Returns the state of a hard wall on a path.
    pub fn on_path(&self) -> Option<&PlasticState> {
        self.get()
    }
}
