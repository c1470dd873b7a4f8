//! Parts of states that one kind of contact alone has.

use gfmd_contact::{FullSolution, Plastic, Solution, SqueezedSolution, SteepSolution};
use gfmd_interface::{FrictionState, PlasticState, State};
use gfmd_viscoelastic::ViscoelasticState;
use gfmd_wear::WearState;
use ndarray::{Array2, Array3};

use crate::Rest;

impl Rest {
    /// The state of a hard wall, of the upper face if there are two.
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

    /// The plastic points of a load with a hardness.
    pub fn plastic(&self) -> Option<&Plastic> {
        self.get::<Solution>()?.plastic.as_ref()
    }

    /// The plastic depth `[x, y]` of a state with a hardness, length: that of a load, or that of a path so far.
    pub fn plastic_depth(&self) -> Option<&Array2<f64>> {
        let so_far = || self.on_path().filter(|state| state.solution.plastic.is_some()).map(|state| &state.depth);
        self.plastic().map(|plastic| &plastic.depth).or_else(so_far)
    }

    /// The lateral displacement u_x, u_y (u_x of a profile), `[x, y]`, length, if it was unknown, too.
    pub fn lateral(&self) -> &[Array2<f64>] {
        let full = self.get().map(|state: &FullSolution| &state.lateral[..]);
        full.or_else(|| self.steep().map(|state| &state.lateral[..])).unwrap_or_default()
    }

    /// The contact of the lower face of a slab between two surfaces, as seen from there.
    pub fn lower(&self) -> Option<&Solution> {
        self.get::<SqueezedSolution>().map(|state| &state.lower)
    }

    /// The traction on the elastic surface `[component, x, y]`, stress, of a state with a law or with friction.
    pub fn traction(&self) -> Option<&Array3<f64>> {
        self.law().map(|state| &state.traction).or_else(|| self.friction().map(|state| &state.traction))
    }

    /// The state with finite slopes.
    pub fn steep(&self) -> Option<&SteepSolution> {
        self.get()
    }

    /// The state with a law across the gap.
    pub fn law(&self) -> Option<&State> {
        self.get().or_else(|| self.get().map(|state: &ViscoelasticState<State>| &state.solution))
    }

    /// The state with friction.
    pub fn friction(&self) -> Option<&FrictionState> {
        self.get()
    }

    /// All that a viscoelastic body [remembers](ViscoelasticState::memory).
    pub fn memory(&self) -> Option<Vec<Array2<f64>>> {
        let wall = self.get::<ViscoelasticState>().map(ViscoelasticState::memory);
        wall.or_else(|| self.get::<ViscoelasticState<State>>().map(ViscoelasticState::memory))
    }

    /// The state of surfaces that wear.
    pub fn worn(&self) -> Option<&WearState> {
        self.get()
    }

    /// The state of a hard wall on a path.
    pub fn on_path(&self) -> Option<&PlasticState> {
        self.get()
    }
}
