use gfmd_response::{FreeTransforms, NormalTransforms};

use crate::Contact;

/// The compliance of the body of one solve, with the memory of its transforms.
pub(crate) enum Compliance {
    /// By a table for the modes of the periodic cell.
    Periodic(NormalTransforms),
    /// With free boundaries.
    Free(FreeTransforms),
}

impl Compliance {
    pub(crate) fn of(contact: &Contact) -> Self {
        match &contact.free {
            Some(free) => Self::Free(FreeTransforms::of(free)),
            None => Self::Periodic(NormalTransforms::of(&contact.response)),
        }
    }

    /// `out` ← G `pressure`, the displacement downwards. The `table` has the compliances of the periodic modes.
    pub(crate) fn apply(&mut self, table: &[f64], pressure: &[f64], out: &mut [f64]) {
        match self {
            Self::Periodic(transforms) => transforms.convolve(table, pressure, out),
            Self::Free(transforms) => transforms.apply(pressure, out),
        }
    }

    /// ⟨p, G p⟩, summed over the points.
    pub(crate) fn quadratic_form(&mut self, table: &[f64], pressure: &[f64]) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.quadratic_form(table, pressure) * pressure.len() as f64,
            Self::Free(transforms) => transforms.quadratic_form(pressure),
        }
    }

    /// `out` ← K u for the displacement u, downwards, whose rows `source(i, row)` fills. The `table` has the stiffnesses of the
    /// periodic modes. With free boundaries K is approximate, and a `floating` surface may move as a whole.
    pub(crate) fn stiffness(
        &mut self,
        table: &[f64],
        floating: bool,
        source: impl Fn(usize, &mut [f64]) + Sync,
        out: &mut [f64],
    ) {
        match self {
            Self::Periodic(transforms) => transforms.convolve_rows(table, source, out),
            Self::Free(transforms) => transforms.stiffness(floating, source, out),
        }
    }

    /// Transforms so far, in pairs.
    pub(crate) fn pairs(&self) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.pairs(),
            Self::Free(transforms) => transforms.pairs(),
        }
    }

    /// The counter of transforms, for a solve that continues an earlier one.
    pub(crate) fn counter(&mut self) -> &mut u64 {
        match self {
            Self::Periodic(transforms) => transforms.counter(),
            Self::Free(transforms) => transforms.counter(),
        }
    }
}
