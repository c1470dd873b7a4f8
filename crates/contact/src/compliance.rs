use gfmd_response::{FreeRounded, FreeTransforms, NormalTransforms, RoundedTransforms};
use gfmd_vector::Split;

use crate::Contact;

/// Compliance of the body in one solve, with the memory of its transforms.
pub(crate) enum Compliance {
    /// Table for the modes of the periodic cell.
    Periodic(NormalTransforms),
    /// Free boundaries.
    Free(FreeTransforms),
}

impl Compliance {
    /// Makes the compliance for the rows of this process.
    pub(crate) fn of(contact: &Contact) -> Self {
        match &contact.free {
            Some(free) => Self::Free(FreeTransforms::of(free)),
            None => Self::Periodic(NormalTransforms::of(&contact.response)),
        }
    }

    /// Computes the downward displacement `out` = G `pressure`. `table` has the compliances of the periodic modes.
    pub(crate) fn apply(&mut self, table: &[f64], pressure: &[f64], out: &mut [f64]) {
        match self {
            Self::Periodic(transforms) => transforms.convolve(table, pressure, out),
            Self::Free(transforms) => transforms.apply(pressure, out),
        }
    }

    /// Applies the compliance as [`apply`](Self::apply), row by row: `source` makes the pressure from the rows of
    /// `input`, and `sink` receives the displacement with the rows of `output`.
    pub(crate) fn apply_rows<I: Split, O: Split>(
        &mut self,
        table: &[f64],
        (input, source): (I, impl Fn(usize, I, &mut [f64]) + Sync),
        (output, sink): (O, impl Fn(usize, &mut [f64], O) + Sync),
    ) {
        match self {
            Self::Periodic(transforms) => transforms.convolve_rows(table, input, source, output, sink),
            Self::Free(transforms) => transforms.apply_rows(input, source, output, sink),
        }
    }

    /// Returns ⟨p, G p⟩, summed over the points of all processes.
    pub(crate) fn quadratic_form(&mut self, table: &[f64], pressure: &[f64]) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.quadratic_form(table, pressure) * transforms.points() as f64,
            Self::Free(transforms) => transforms.quadratic_form(pressure),
        }
    }

    /// Frees the memory of a periodic cell until the next transform.
    pub(crate) fn release(&mut self) {
        if let Self::Periodic(transforms) = self {
            transforms.release();
        }
    }

    /// Returns the number of transforms so far, in pairs.
    pub(crate) fn pairs(&self) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.pairs(),
            Self::Free(transforms) => transforms.pairs(),
        }
    }

    /// Returns the counter of transforms, for a solve that continues an earlier one.
    pub(crate) fn counter(&mut self) -> &mut u64 {
        match self {
            Self::Periodic(transforms) => transforms.counter(),
            Self::Free(transforms) => transforms.counter(),
        }
    }
}

/// Compliance and stiffness in single precision.
pub(crate) enum Rounded {
    Periodic(RoundedTransforms),
    /// Free boundaries; the stiffness is approximate.
    Free(FreeRounded),
}

impl Rounded {
    /// Makes compliance and stiffness; `uniform` has both values of the periodic uniform mode, unless they are zero.
    pub(crate) fn of(contact: &Contact, uniform: Option<[f64; 2]>) -> Self {
        match &contact.free {
            Some(free) => Self::Free(FreeRounded::of(free)),
            None => Self::Periodic(RoundedTransforms::of(&contact.response, uniform)),
        }
    }

    /// Returns the unit of compliances.
    pub(crate) fn unit(&self) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.unit(),
            Self::Free(transforms) => transforms.unit(),
        }
    }

    /// Computes G v divided by the unit, for the field v with rows that `source` makes from the rows of `input`.
    pub(crate) fn compliance<I: Split>(&mut self, input: I, source: impl Fn(usize, I, &mut [f32]) + Sync) {
        match self {
            Self::Periodic(transforms) => transforms.compliance(input, source),
            Self::Free(transforms) => transforms.compliance(input, source),
        }
    }

    /// Passes the rows of the result of [`compliance`](Self::compliance) to `sink`.
    pub(crate) fn rows<O: Split>(&mut self, output: O, sink: impl Fn(usize, &mut [f32], O) + Sync) {
        match self {
            Self::Periodic(transforms) => transforms.rows(output, sink),
            Self::Free(transforms) => transforms.rows(output, sink),
        }
    }

    /// Computes `out` = K u times the unit, for the field u with rows filled by `source(i, row)`. With free boundaries
    /// a `floating` surface may move as a whole.
    pub(crate) fn stiffness(&mut self, floating: bool, source: impl Fn(usize, &mut [f32]) + Sync, out: &mut [f32]) {
        match self {
            Self::Periodic(transforms) => transforms.stiffness(source, out),
            Self::Free(transforms) => transforms.stiffness(floating, source, out),
        }
    }

    /// Returns ⟨v, G v⟩ divided by the unit, summed over the points.
    pub(crate) fn quadratic_form(&mut self, field: &[f32]) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.quadratic_form(field),
            Self::Free(transforms) => transforms.quadratic_form(field),
        }
    }

    /// Frees the memory of a periodic cell until the next transform.
    pub(crate) fn release(&mut self) {
        if let Self::Periodic(transforms) = self {
            transforms.release();
        }
    }

    /// Returns the number of transforms so far, in pairs.
    pub(crate) fn pairs(&self) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.pairs(),
            Self::Free(transforms) => transforms.pairs(),
        }
    }

    /// Returns the counter of transforms, for a solve that continues an earlier one.
    pub(crate) fn counter(&mut self) -> &mut u64 {
        match self {
            Self::Periodic(transforms) => transforms.counter(),
            Self::Free(transforms) => transforms.counter(),
        }
    }
}
