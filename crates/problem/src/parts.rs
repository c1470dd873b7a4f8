//! Parts of states that only one kind of contact has.

use gfmd_contact::{FullSolution, Plastic, Solution, SqueezedSolution, SteepSolution};
use gfmd_interface::{QuasistaticState, State};
use ndarray::{Array2, ArrayView2};

use crate::AnyState;

impl AnyState {
    /// Returns the state at the end of an increment of a path.
    pub fn on_path(&self) -> Option<&QuasistaticState> {
        self.get()
    }

    /// Returns the state of a hard wall; the upper face if there are two.
    pub fn wall(&self) -> Option<&Solution> {
        let full = || self.get().map(|state: &FullSolution| &state.normal);
        let squeezed = || self.get().map(|state: &SqueezedSolution| &state.upper);
        self.get()
            .or_else(full)
            .or_else(|| self.steep().map(|state| &state.normal))
            .or_else(squeezed)
            .or_else(|| self.on_path().and_then(QuasistaticState::wall))
    }

    /// Returns the plastic points of a load with a hardness.
    pub fn plastic(&self) -> Option<&Plastic> {
        self.get::<Solution>()?.plastic.as_ref()
    }

    /// Returns the plastic depth `[x, y]` of a state with a hardness, length: of the load, or accumulated on a path.
    pub fn plastic_depth(&self) -> Option<&Array2<f64>> {
        let so_far = || self.on_path().and_then(QuasistaticState::plastic_depth);
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

    /// Returns the shear traction on the elastic surface along x (0) or y (1), stress, of surfaces that shear each other
    /// on a path.
    pub fn shear(&self, axis: usize) -> Option<ArrayView2<'_, f64>> {
        self.on_path()?.shear(axis)
    }

    /// Returns the state with finite slopes.
    pub fn steep(&self) -> Option<&SteepSolution> {
        self.get()
    }

    /// Returns the state with a law across the gap.
    pub fn law(&self) -> Option<&State> {
        self.get().or_else(|| self.on_path().and_then(QuasistaticState::law))
    }
}
