//! A steady state, with its temperature.

use std::borrow::Cow;

use gfmd_files::contiguous;
use gfmd_heat::Heated;
use gfmd_medium::SlidingState;
use ndarray::Array2;

/// A state, and its temperature if it is asked for.
pub(super) struct SteadyState {
    pub(super) state: SlidingState,
    pub(super) heated: Option<Heated>,
}

impl SteadyState {
    /// The values of a field.
    pub(super) fn field(&self, name: &str) -> Cow<'_, [f64]> {
        let solution = &self.state.solution;
        let heated = |of: fn(&Heated) -> &Array2<f64>| self.heated.as_ref().map(of);
        let field = match name {
            "pressure" => Some(&solution.pressure),
            "displacement_z" => Some(&solution.displacement),
            "gap" => Some(&solution.gap),
            "plastic_depth" => solution.plastic.as_ref().map(|plastic| &plastic.depth),
            "temperature" => heated(|heated| &heated.temperature),
            _ => heated(|heated| &heated.into_body),
        };
        field.map_or(Cow::default(), |field| contiguous(field))
    }
}
