//! Energies of a state, its stability and its stiffness.

use gfmd_interface::{Loss, Losses};

use super::{
    Column,
    special::yielding,
    undefined::{imbalance, lost, without_law},
};
use crate::column::{Form, Origin, Table};
use crate::when::{any, between, friction, hardness, law, level_near, path, relaxing, several_causes, wears, yields};
use crate::{Cell, StateContext};

/// Energies, losses, stability, stiffness.
pub(super) const COLUMNS: &[Column] = &[
    Column::new(
        "elastic_energy",
        "stress*length",
        &[
            (between, "elastic energy of the slab per area, from the pressures on both faces"),
            (relaxing, "elastic energy per area in the springs of all branches"),
            (yields, "elastic energy per area, including the energy of residual stress"),
            (level_near, "elastic energy per area, relative to points one profile length away"),
            (any, "elastic energy per area of the surface"),
        ],
        |at| at.summary.elastic_energy.into(),
    )
    .on(Table::Energy, "elastic", Form::Size)
    .detail(),
    Column::new(
        "interface_energy",
        "stress*length",
        &[
            (between, "energy of the law per area at both faces, zero at large gaps"),
            (path, "energy of the law per area, zero at large gaps; NaN if the law has no potential"),
            (any, "energy of the contact law per area, zero at large gaps"),
        ],
        |at| match at.rest.and_then(|rest| rest.law()).map(|law| law.interface_energy) {
            Some(energy) if energy.is_nan() => Cell::undefined("the tractions have no energy"),
            energy => energy.unwrap_or(f64::NAN).into(),
        },
    )
    .with(|facts| path(facts) || law(facts))
    .unless(without_law)
    .on(Table::Energy, "interface", Form::Size)
    .detail(),
    Column::new(
        "dissipated",
        "stress*length",
        &[
            (
                |facts| several_causes(facts) && (friction(facts) || wears(facts) || hardness(facts)),
                "energy lost in this step, per area: the sum of the columns lost_*",
            ),
            (
                |facts| relaxing(facts) && law(facts),
                "energy lost in dashpots and jumps in this step, per area; the first step counts no jumps",
            ),
            (relaxing, "energy lost in the dashpots in this step, per area"),
            (wears, "work of the pressure on the depth lost in this step, per area, excluding friction"),
            (yields, "energy dissipated by plastic strain in this step, per area, excluding hardening_energy"),
            (
                any,
                "energy lost in this step, per area; with a law, at least minus its error; NaN if the law has no \
                 potential",
            ),
        ],
        |at| lost(at, false),
    )
    .with(path)
    .by(Origin::Way)
    .on(Table::Energy, "dissipated", Form::Size),
    Column::new(
        "hardening_energy",
        "stress*length",
        &[(any, "energy stored by hardening, per area; not recoverable with isotropic hardening")],
        |at| yielding(at, |state| state.hardening_energy),
    )
    .with(yields)
    .on(Table::Energy, "hardening", Form::Size)
    .detail(),
    Column::new(
        "lost_relaxation",
        "stress*length",
        &[(any, "energy lost in the dashpots in this step, per area (part of dissipated)")],
        |at| by_cause(at, |losses| losses.relaxation),
    )
    .with(|facts| several_causes(facts) && relaxing(facts))
    .by(Origin::Way),
    Column::new(
        "lost_friction",
        "stress*length",
        &[(any, "energy lost by slip in this step, per area (part of dissipated)")],
        |at| by_cause(at, |losses| losses.friction),
    )
    .with(|facts| several_causes(facts) && friction(facts))
    .by(Origin::Way),
    Column::new(
        "lost_wear",
        "stress*length",
        &[(any, "work of the pressure on the depth worn off in this step, per area (part of dissipated)")],
        |at| by_cause(at, |losses| losses.wear),
    )
    .with(|facts| several_causes(facts) && wears(facts))
    .by(Origin::Way),
    Column::new(
        "lost_plastic",
        "stress*length",
        &[(any, "work of the pressure on the plastic depth gained in this step, per area (part of dissipated)")],
        |at| by_cause(at, |losses| losses.plastic),
    )
    .with(|facts| several_causes(facts) && hardness(facts))
    .by(Origin::Way),
    Column::new(
        "lost_jumps",
        "stress*length",
        &[(
            any,
            "energy lost in jumps in this step, per area (part of dissipated): the remainder of the balance of work \
             and energy, at least minus its error",
        )],
        |at| by_cause(at, |losses| losses.jumps),
    )
    .with(|facts| several_causes(facts) && law(facts))
    .by(Origin::Way),
    Column::new(
        "dissipated_error",
        "stress*length",
        &[
            (
                |facts| several_causes(facts) && (friction(facts) || wears(facts) || hardness(facts)),
                "estimated error of dissipated, from a path with half as many increments; 0 in a step that cannot lose \
                 energy; NaN if that path was not followed",
            ),
            (wears, "estimated error of dissipated: 0 in a step of zero distance, else NaN"),
            (
                relaxing,
                "estimated error of dissipated: twice its difference from a path with half as many increments; 0 in a \
                 step of zero duration without a law; NaN if that path was not followed",
            ),
            (any, "estimated error of dissipated; NaN if the step was not halved or dissipated is unknown"),
        ],
        |at| lost(at, true),
    )
    .with(path)
    .by(Origin::Way)
    .on(Table::Energy, "+-", Form::Rough)
    .detail(),
    Column::new(
        "work_imbalance",
        "stress*length",
        &[
            (
                |facts| relaxing(facts) && law(facts),
                "absolute difference between the work of the rigid surface (trapezoidal rule) and the energies gained \
                 and lost; in a step with a jump, the largest error of that rule; 0 in a first step of zero duration, \
                 which the sum of a path excludes",
            ),
            (
                any,
                "absolute difference between the work of the rigid surface (trapezoidal rule) and the energies gained \
                 and lost; the sum of a path excludes a first step of zero duration and distance",
            ),
        ],
        imbalance,
    )
    .with(|facts| {
        path(facts) && (relaxing(facts) || wears(facts) || yields(facts) || law(facts) && several_causes(facts))
    })
    .by(Origin::Way),
    Column::new(
        "passed_instability",
        "1",
        &[
            (path, "1 if a jump in this step lost more energy than its error; NaN if no energy balance reveals jumps"),
            (any, "1 if the search from the last load met negative curvature"),
        ],
        jumped,
    )
    .flag()
    .with(|facts| path(facts) || law(facts))
    .by(Origin::Way),
    Column::new(
        "lowest_curvature",
        "1",
        &[(any, "lowest curvature in the last search for a step, relative to the preconditioner")],
        |at| match at.rest.and_then(|rest| rest.law()).map(|law| law.lowest_curvature) {
            Some(curvature) if curvature.is_finite() => curvature.into(),
            _ => Cell::undefined(
                "no curvature was computed: by dynamics, or where the search ended before its first step",
            ),
        },
    )
    .with(|facts| path(facts) || law(facts))
    .unless(without_law)
    .by(Origin::Way),
    Column::new(
        "stiffness",
        "stress/length",
        &[
            (
                yields,
                "d(mean pressure)/d(approach) at the end of the step with fixed points in contact: elastic, as at the \
                 onset of unloading; NaN where infinite (full contact with a fixed mean level), with the reason in the \
                 attribute undefined",
            ),
            (
                path,
                "instantaneous d(mean pressure)/d(approach) at the end of the step: fixed points in contact, constant \
                 pressure at the hardness (under a growing load; on unloading the contact is stiffer), no wear, \
                 instantaneous moduli of a viscoelastic body, no lateral motion; with friction points in contact \
                 stick; NaN where infinite (full contact with a fixed mean level) or not computed, with the reason in \
                 the attribute undefined",
            ),
            (
                any,
                "d(mean pressure)/d(approach) with fixed points in contact and constant pressure at the hardness; NaN \
                 where infinite (full contact with a fixed mean level) or not computed, with the reason in the \
                 attribute undefined",
            ),
        ],
        |at| stiff(at, |found| found.value),
    )
    .head("stiffness", Form::Size),
    Column::new(
        "stiffness_error",
        "1",
        &[(any, "relative error of the stiffness, from the residual of its linear problem")],
        |at| stiff(at, |found| found.error),
    )
    .by(Origin::Residual),
];

/// Returns the energy lost in a step by one cause.
fn by_cause(at: &StateContext, of: fn(&Losses) -> f64) -> Cell {
    match &at.step {
        Some((step, _)) if step.dissipated.is_some() => of(&step.losses).into(),
        Some(_) => Cell::undefined("the step did not reach a state at rest"),
        None => f64::NAN.into(),
    }
}

/// Returns the stiffness or its error, selected by `of`, or the reason why there is none.
fn stiff(at: &StateContext, of: fn(&gfmd_contact::Stiffness) -> f64) -> Cell {
    match &at.stiffness {
        Ok(found) if found.value.is_finite() => of(found).into(),
        Ok(_) => Cell::undefined(
            "infinite: in full contact the surface moves as a whole, and the mean level of this body is fixed",
        ),
        Err(reason) => Cell::undefined(reason.clone()),
    }
}

/// Returns the jump flag of a step, or the reason why it is unknown.
fn jumped(at: &StateContext) -> Cell {
    let Some((step, reading)) = &at.step else {
        return at.rest.and_then(|rest| rest.law()).map_or(Cell::Real(f64::NAN), |law| law.passed_instability.into());
    };
    if let (Loss::Certified { .. }, Some(_), true) = (reading.loss, step.dissipated, law(at.facts)) {
        return (step.losses.jumps != 0.0).into();
    }
    let unknown = match reading.loss {
        Loss::Balance(_) => "--energy-solves did not suffice to tell a jump from a smooth change",
        Loss::Certified { .. } if law(at.facts) => "the step did not reach a state at rest",
        Loss::Certified { .. } | Loss::Known(_) | Loss::Conserved => {
            "no law attracts the surfaces, without which they do not jump"
        }
        Loss::Unknown => "the tractions have no energy, whose loss would tell a jump",
    };
    step.jumped.ok_or(unknown).into()
}
