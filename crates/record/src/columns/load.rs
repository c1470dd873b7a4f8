//! Load, approach, time and lateral displacement of a state.

use super::{Column, undefined::reduced};
use crate::column::Form;
use crate::when::{any, between, free, level_near, path, relaxing, steep, wears};
use crate::{Cell, StateContext};

/// Columns of the drive of a state, and of the loads that hold it.
pub(super) const COLUMNS: &[Column] = &[
    Column::new(
        "mean_pressure",
        "stress",
        &[
            (path, "mean pressure over the whole surface; negative under tension"),
            (any, "mean pressure over the whole surface"),
        ],
        |at| at.summary.mean_pressure.into(),
    )
    .head("pressure", Form::Size)
    .main(),
    Column::new("p_star", "1", &[(any, "reduced pressure p/(E* g)")], |at| reduced(at, at.summary.p_star))
        .head("p*", Form::Size)
        .detail(),
    Column::new("force", "stress*length^2", &[(any, "force; of a profile, per unit width (stress*length)")], |at| {
        (at.summary.mean_pressure * at.lengths[0] * at.lengths[1]).into()
    })
    .with(free)
    .head("force", Form::Size)
    .main(),
    Column::new(
        "approach",
        "length",
        &[
            (between, "approach of the two rigid surfaces beyond the distance where both touch the undeformed slab"),
            (level_near, "rigid approach beyond first touch, relative to points one profile length away"),
            (any, "rigid approach beyond first touch"),
        ],
        |at| at.approach.into(),
    )
    .head("approach", Form::Size),
    Column::new("time", "time", &[(any, "time since first touch, in the unit of the relaxation times")], |at| {
        at.step.as_ref().map_or(f64::NAN, |(_, reading)| reading.time).into()
    })
    .with(relaxing)
    .head("time", Form::Size)
    .main(),
    Column::new("distance", "length", &[(any, "sliding distance since first touch")], |at| {
        at.step.as_ref().map_or(f64::NAN, |(_, reading)| reading.distance).into()
    })
    .with(wears)
    .head("distance", Form::Size)
    .main(),
    Column::new("lateral_x", "length", &[(any, "lateral displacement of the rigid surface along x")], |at| {
        sideways(at, 0)
    })
    .at("lateral.0")
    .with(path)
    .head("lateral x", Form::SizeUnlessZero)
    .main(),
    Column::new("lateral_y", "length", &[(any, "lateral displacement of the rigid surface along y")], |at| {
        sideways(at, 1)
    })
    .at("lateral.1")
    .with(path)
    .head("lateral y", Form::SizeUnlessZero),
    Column::new(
        "mean_shear_x",
        "stress",
        &[
            (path, "mean shear traction on the elastic surface along x"),
            (any, "mean traction along x that holds the rigid surface in place"),
        ],
        |at| shear(at, 0),
    )
    .at("mean_shear.0")
    .with(|facts| path(facts) || steep(facts))
    .head("shear x", Form::SizeUnlessZero)
    .main(),
    Column::new(
        "mean_shear_y",
        "stress",
        &[
            (path, "mean shear traction on the elastic surface along y"),
            (any, "mean traction along y that holds the rigid surface in place"),
        ],
        |at| shear(at, 1),
    )
    .at("mean_shear.1")
    .with(|facts| path(facts) || steep(facts))
    .head("shear y", Form::SizeUnlessZero),
];

/// Returns the mean shear: on a path the traction on the body, with finite slopes the traction on the rigid surface.
fn shear(at: &StateContext, axis: usize) -> Cell {
    let steep = at.rest.and_then(|rest| rest.steep()).map(|state| state.mean_shear);
    at.step.as_ref().map(|(_, reading)| reading.mean_shear).or(steep).map_or(f64::NAN, |shear| shear[axis]).into()
}

fn sideways(at: &StateContext, axis: usize) -> Cell {
    at.step.as_ref().map_or(f64::NAN, |(_, reading)| reading.lateral[axis]).into()
}
