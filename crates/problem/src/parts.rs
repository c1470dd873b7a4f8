//! Parts of states that only one kind of contact has.

use gfmd_contact::{Fields, Lateral, Plastic, Solution, SqueezedSolution, SteepSolution};
use gfmd_interface::{QuasistaticState, SqueezedState, State};
use gfmd_plasticity::PlasticState;
use ndarray::{Array2, ArrayView2};

use crate::AnyState;

impl AnyState {
    /// Returns the state of a contact made of parts; the upper face if there are two. `None` for finite slopes, a body
    /// that yields, and two hard walls under loads.
    pub fn of_parts(&self) -> Option<&QuasistaticState> {
        self.get().or_else(|| self.get().map(|state: &SqueezedState| &state.upper))
    }

    /// Returns the state of a body that yields below its surface.
    pub fn yielding(&self) -> Option<&PlasticState> {
        self.get()
    }

    /// Returns the state of a hard wall; the upper face if there are two.
    pub fn wall(&self) -> Option<&Solution> {
        let yielding = || self.yielding().map(|state| &state.solution);
        self.special_wall().or_else(yielding).or_else(|| self.of_parts().and_then(QuasistaticState::wall))
    }

    /// Returns the state of a hard wall with finite slopes, or of the upper one of two under loads.
    fn special_wall(&self) -> Option<&Solution> {
        let squeezed = || self.get().map(|state: &SqueezedSolution| &state.upper);
        self.steep().map(|state| &state.normal).or_else(squeezed)
    }

    /// Returns the fraction of points with a pressure equal to the hardness, and the mean plastic depth over the whole
    /// surface, length; of a state with a hardness, on the upper face if there are two.
    pub fn plastic_fraction_and_volume(&self) -> Option<(f64, f64)> {
        self.of_parts().map_or_else(|| of_wall(self.special_wall()), of_state)
    }

    /// Returns the plastic depth `[x, y]` of a state with a hardness, length: of the load, or accumulated on a path; on
    /// the upper face if there are two.
    pub fn plastic_depth(&self) -> Option<&Array2<f64>> {
        let of_wall = || self.special_wall()?.plastic.as_ref().map(|plastic| &plastic.depth);
        self.of_parts().map_or_else(of_wall, QuasistaticState::plastic_depth)
    }

    /// Returns the lateral displacement u_x, u_y (u_x of a profile), `[x, y]`, length, if it was also unknown.
    pub fn lateral(&self) -> &[Array2<f64>] {
        let moved = self.of_parts().and_then(|state| state.wall()?.lateral.as_ref());
        let moved = moved.map(|Lateral { displacement, .. }| &displacement[..]);
        moved.or_else(|| self.steep().map(|state| &state.lateral[..])).unwrap_or_else(|| self.sideways())
    }

    /// Returns the contact of the lower face of a slab between two surfaces, as seen from that face.
    pub fn lower(&self) -> Option<&dyn Fields> {
        let wall = self.lower_wall().map(|face| face as &dyn Fields);
        wall.or_else(|| self.lower_of_parts().map(|face| face as &dyn Fields))
    }

    /// Returns the state of the hard wall at the lower face, unless it is solved as a law.
    pub fn lower_wall(&self) -> Option<&Solution> {
        self.get::<SqueezedSolution>().map(|state| &state.lower)
    }

    /// Returns the state of a contact made of parts at the lower face.
    pub fn lower_of_parts(&self) -> Option<&QuasistaticState> {
        self.get().map(|state: &SqueezedState| &state.lower)
    }

    /// Returns the state of the law at the lower face.
    pub fn lower_law(&self) -> Option<&State> {
        self.lower_of_parts().and_then(QuasistaticState::law)
    }

    /// Returns fraction and volume as [`plastic_fraction_and_volume`](Self::plastic_fraction_and_volume), of the lower
    /// face.
    pub fn lower_plastic_fraction_and_volume(&self) -> Option<(f64, f64)> {
        self.lower_of_parts().map_or_else(|| of_wall(self.lower_wall()), of_state)
    }

    /// Returns the plastic depth as [`plastic_depth`](Self::plastic_depth), of the lower face.
    pub fn lower_plastic_depth(&self) -> Option<&Array2<f64>> {
        let of_wall = || self.lower_wall()?.plastic.as_ref().map(|plastic| &plastic.depth);
        self.lower_of_parts().map_or_else(of_wall, QuasistaticState::plastic_depth)
    }

    /// Returns the shear traction on the elastic surface along x (0) or y (1), stress, on a path of surfaces that shear
    /// each other.
    pub fn shear(&self, axis: usize) -> Option<ArrayView2<'_, f64>> {
        self.of_parts()?.shear(axis)
    }

    /// Returns the state with finite slopes.
    pub fn steep(&self) -> Option<&SteepSolution> {
        self.get()
    }

    /// Returns the state with a law across the gap; the upper face if there are two.
    pub fn law(&self) -> Option<&State> {
        self.of_parts().and_then(QuasistaticState::law)
    }
}

/// Returns plastic fraction and volume of a state made of parts with a hardness.
fn of_state(state: &QuasistaticState) -> Option<(f64, f64)> {
    state.plastic_volume().map(|volume| (state.plastic_fraction, volume))
}

/// Returns plastic fraction and volume of a wall with a hardness.
fn of_wall(wall: Option<&Solution>) -> Option<(f64, f64)> {
    wall?.plastic.as_ref().map(|Plastic { fraction, volume, .. }| (*fraction, *volume))
}
