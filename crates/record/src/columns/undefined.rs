//! Columns that may have no value, with the reason.

use gfmd_interface::Loss;
use gfmd_problem::Facts;

use crate::when::of_a_law;
use crate::{Cell, StateContext};

pub(super) fn without_law(facts: &Facts) -> Option<&'static str> {
    (!of_a_law(facts)).then_some("no law acts across the gap")
}

/// Returns a number in units of reduced pressure, or the reason why there is none.
pub(super) fn reduced(at: &StateContext, value: f64) -> Cell {
    if at.scales.rms_gradient == 0.0 {
        return Cell::undefined("the surface is flat: its rms gradient, by which a load is reduced, is zero");
    }
    value.into()
}

pub(super) fn flag(flags: Option<[bool; 2]>, axis: usize) -> Cell {
    flags.map_or(Cell::Real(f64::NAN), |flags| flags[axis].into())
}

/// Returns the energy lost in a step, or its error, or the reason why it is unknown.
pub(super) fn lost(at: &StateContext, error: bool) -> Cell {
    let Some((step, reading)) = &at.step else { return f64::NAN.into() };
    let found = if error { step.dissipated_error } else { step.dissipated };
    if let Some(found) = found {
        return found.into();
    }
    Cell::undefined(match reading.loss {
        Loss::Unknown => "the tractions have no energy",
        _ if step.dissipated.is_none() => "the step did not reach a state at rest",
        _ if step.change.is_some_and(f64::is_nan) => "--energy-solves did not suffice to halve the increment",
        Loss::Certified { .. } => NOT_BESIDE,
        _ if at.facts.hardness && at.facts.friction.is_none() => {
            "a step with a hardness is not halved: double --steps and compare the losses"
        }
        _ => {
            "the step was not halved: limits and directions of the shear change too little in it; a smaller \
             --energy-tolerance halves it"
        }
    })
}

/// Reason why a path without a coarser one beside it has no errors.
const NOT_BESIDE: &str = "the path was not followed in half as many increments: --energy-solves 3 or more does so";

/// Returns the error of the mean depth worn off at a face, 0 for the upper one, or the reason why it is unknown.
pub(super) fn worn_error(at: &StateContext, face: usize) -> Cell {
    let Some((step, reading)) = &at.step else { return f64::NAN.into() };
    match step.worn_error {
        Some(errors) => errors[face].into(),
        None if matches!(reading.loss, Loss::Unknown) => Cell::undefined(
            "the tractions have no energy, whose balance decides how far a path is divided: double --steps and compare",
        ),
        None => Cell::undefined(NOT_BESIDE),
    }
}

/// Returns the imbalance of work and energy of a step, or the reason why it is unknown.
pub(super) fn imbalance(at: &StateContext) -> Cell {
    let Some((step, _)) = &at.step else { return f64::NAN.into() };
    match step.work_imbalance {
        Some(found) => found.into(),
        None if step.dissipated.is_none() => Cell::undefined("the step did not reach a state at rest"),
        None => Cell::undefined("in a step of no time the balance of work and energy gives the loss of a law"),
    }
}
