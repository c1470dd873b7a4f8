//! Parts of states that only one kind of contact has.

use gfmd_contact::{Fields, Lateral, Plastic, Solution, SqueezedSolution, SteepSolution};
use gfmd_interface::{QuasistaticState, SqueezedState, State};
use gfmd_plasticity::PlasticState;
use ndarray::{Array2, ArrayView2};

use crate::AnyState;

impl AnyState {
    /// Returns the state at the end of an increment of a path; the upper face if there are two.
    pub fn on_path(&self) -> Option<&QuasistaticState> {
        self.get().or_else(|| self.get().map(|state: &SqueezedState<QuasistaticState>| &state.upper))
    }

    /// Returns the state of a body that yields below its surface.
    pub fn yielding(&self) -> Option<&PlasticState> {
        self.get()
    }

    /// Returns the state of a hard wall; the upper face if there are two.
    pub fn wall(&self) -> Option<&Solution> {
        let squeezed = || self.get().map(|state: &SqueezedSolution| &state.upper);
        self.get()
            .or_else(|| self.steep().map(|state| &state.normal))
            .or_else(squeezed)
            .or_else(|| self.yielding().map(|state| &state.solution))
            .or_else(|| self.on_path().and_then(QuasistaticState::wall))
    }

    /// Returns the plastic points of a load with a hardness and a hard wall alone; on the upper face if there are two.
    fn plastic(&self) -> Option<&Plastic> {
        let squeezed = || self.get().map(|state: &SqueezedSolution| &state.upper);
        let wall = self.get::<Solution>().or_else(|| self.steep().map(|state| &state.normal)).or_else(squeezed);
        wall?.plastic.as_ref()
    }

    /// Returns the fraction of points with a pressure equal to the hardness, and the mean plastic depth over the whole
    /// surface, length; of a state with a hardness, on the upper face if there are two.
    pub fn plastic_fraction_and_volume(&self) -> Option<(f64, f64)> {
        if let Some(state) = self.on_path() {
            return volume_on_path(state);
        }
        let of_wall = self.plastic().map(|plastic| (plastic.fraction, plastic.volume));
        of_wall.or_else(|| volume_below_law(self.law()?))
    }

    /// Returns the plastic depth `[x, y]` of a state with a hardness, length: of the load, or accumulated on a path; on
    /// the upper face if there are two.
    pub fn plastic_depth(&self) -> Option<&Array2<f64>> {
        let so_far = || self.on_path().and_then(QuasistaticState::plastic_depth);
        let below_law = || self.law().and_then(|state| state.pressed_in.as_ref());
        self.plastic().map(|plastic| &plastic.depth).or_else(so_far).or_else(below_law)
    }

    /// Returns the lateral displacement u_x, u_y (u_x of a profile), `[x, y]`, length, if it was also unknown.
    pub fn lateral(&self) -> &[Array2<f64>] {
        let moved = self.get::<Solution>().and_then(|state| state.lateral.as_ref());
        let moved = moved.map(|Lateral { displacement, .. }| &displacement[..]);
        moved.or_else(|| self.steep().map(|state| &state.lateral[..])).unwrap_or_else(|| self.sideways())
    }

    /// Returns the contact of the lower face of a slab between two surfaces, as seen from that face.
    pub fn lower(&self) -> Option<&dyn Fields> {
        let wall = self.lower_wall().map(|face| face as &dyn Fields);
        wall.or_else(|| self.lower_on_path().map(|face| face as &dyn Fields))
            .or_else(|| self.lower_law().map(|face| face as &dyn Fields))
    }

    /// Returns the state of the hard wall at the lower face, unless it is solved as a law.
    pub fn lower_wall(&self) -> Option<&Solution> {
        self.get::<SqueezedSolution>().map(|state| &state.lower)
    }

    /// Returns the state of the lower face along a path.
    pub fn lower_on_path(&self) -> Option<&QuasistaticState> {
        self.get().map(|state: &SqueezedState<QuasistaticState>| &state.lower)
    }

    /// Returns the state of the law at the lower face.
    pub fn lower_law(&self) -> Option<&State> {
        let of_load = || self.get().map(|state: &SqueezedState<State>| &state.lower);
        self.lower_on_path().map_or_else(of_load, QuasistaticState::law)
    }

    /// Returns fraction and volume as [`plastic_fraction_and_volume`](Self::plastic_fraction_and_volume), of the lower
    /// face.
    pub fn lower_plastic_fraction_and_volume(&self) -> Option<(f64, f64)> {
        if let Some(state) = self.lower_on_path() {
            return volume_on_path(state);
        }
        let plastic = self.lower_wall().and_then(|face| face.plastic.as_ref());
        let of_wall = plastic.map(|plastic| (plastic.fraction, plastic.volume));
        of_wall.or_else(|| volume_below_law(self.lower_law()?))
    }

    /// Returns the plastic depth as [`plastic_depth`](Self::plastic_depth), of the lower face.
    pub fn lower_plastic_depth(&self) -> Option<&Array2<f64>> {
        if let Some(state) = self.lower_on_path() {
            return state.plastic_depth();
        }
        let of_wall = self.lower_wall().and_then(|face| face.plastic.as_ref()).map(|plastic| &plastic.depth);
        of_wall.or_else(|| self.lower_law()?.pressed_in.as_ref())
    }

    /// Returns the shear traction on the elastic surface along x (0) or y (1), stress, on a path of surfaces that shear
    /// each other.
    pub fn shear(&self, axis: usize) -> Option<ArrayView2<'_, f64>> {
        self.on_path()?.shear(axis)
    }

    /// Returns the state with finite slopes.
    pub fn steep(&self) -> Option<&SteepSolution> {
        self.get()
    }

    /// Returns the state with a law across the gap; the upper face if there are two.
    pub fn law(&self) -> Option<&State> {
        let squeezed = || self.get().map(|state: &SqueezedState<State>| &state.upper);
        self.get().or_else(|| self.on_path().and_then(QuasistaticState::law)).or_else(squeezed)
    }
}

/// Returns plastic fraction and volume of a state along a path with a hardness.
fn volume_on_path(state: &QuasistaticState) -> Option<(f64, f64)> {
    state.plastic_volume().map(|volume| (state.plastic_fraction, volume))
}

/// Returns plastic fraction and volume of a load with a hardness below a law: points carry the hardness where they are
/// pressed in.
fn volume_below_law(state: &State) -> Option<(f64, f64)> {
    let depth = state.pressed_in.as_ref()?;
    let count = depth.iter().filter(|depth| **depth > 0.0).count();
    Some((count as f64 / depth.len() as f64, depth.mean()?))
}
