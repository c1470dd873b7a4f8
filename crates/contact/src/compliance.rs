use gfmd_response::{FreeRounded, FreeTransforms, NormalTransforms, RoundedTransforms};
use gfmd_vector::Split;

use crate::Contact;

/// The compliance of the body of one solve, with the memory of its transforms.
pub(crate) enum Compliance {
    /// By a table for the modes of the periodic cell.
    Periodic(NormalTransforms),
    /// With free boundaries.
    Free(FreeTransforms),
}

impl Compliance {
    /// For the rows of this process.
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

    /// As [`apply`](Self::apply), row by row: `source` makes the pressure from the rows of `input`, and `sink` gets the
    /// displacement with the rows of `output`.
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

    /// ⟨p, G p⟩, summed over the points of all processes.
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

/// Compliance and stiffness in single precision.
pub(crate) enum Rounded {
    Periodic(RoundedTransforms),
    /// With free boundaries, where the stiffness is approximate.
    Free(FreeRounded),
}

impl Rounded {
    /// `uniform` are compliance and stiffness of the uniform mode of the periodic cell, if they are not zero.
    pub(crate) fn of(contact: &Contact, uniform: Option<[f64; 2]>) -> Self {
        match &contact.free {
            Some(free) => Self::Free(FreeRounded::of(free)),
            None => Self::Periodic(RoundedTransforms::of(&contact.response, uniform)),
        }
    }

    /// The unit of compliances.
    pub(crate) fn unit(&self) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.unit(),
            Self::Free(transforms) => transforms.unit(),
        }
    }

    /// Computes G v over the unit, of the field v whose rows `source` makes from the rows of `input`.
    pub(crate) fn compliance<I: Split>(&mut self, input: I, source: impl Fn(usize, I, &mut [f32]) + Sync) {
        match self {
            Self::Periodic(transforms) => transforms.compliance(input, source),
            Self::Free(transforms) => transforms.compliance(input, source),
        }
    }

    /// Hands on the rows of what [`compliance`](Self::compliance) has computed.
    pub(crate) fn rows<O: Split>(&mut self, output: O, sink: impl Fn(usize, &mut [f32], O) + Sync) {
        match self {
            Self::Periodic(transforms) => transforms.rows(output, sink),
            Self::Free(transforms) => transforms.rows(output, sink),
        }
    }

    /// `out` ← K u times the unit, of the field u whose rows `source(i, row)` fills. With free boundaries a `floating`
    /// surface may move as a whole.
    pub(crate) fn stiffness(&mut self, floating: bool, source: impl Fn(usize, &mut [f32]) + Sync, out: &mut [f32]) {
        match self {
            Self::Periodic(transforms) => transforms.stiffness(source, out),
            Self::Free(transforms) => transforms.stiffness(floating, source, out),
        }
    }

    /// ⟨v, G v⟩ over the unit, summed over the points.
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
