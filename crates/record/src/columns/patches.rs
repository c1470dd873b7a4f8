//! Patches of points in contact, their conductance, and the conductance of a gas between them.

use gfmd_contact::Fields as _;

use super::{Column, undefined::flag};
use crate::column::{Form, Table};
use crate::when::{any, conducts, gas, statistics};
use crate::{Cell, StateContext};

/// Columns of the patches.
pub(super) const COLUMNS: &[Column] = &[
    Column::new("patches", "1", &[(any, "number of connected patches of points in contact")], |at| {
        at.measured.patches.map_or(Cell::Real(f64::NAN), |found| (found.patches.len() as u64).into())
    })
    .count()
    .at("patches.count")
    .with(statistics)
    .on(Table::Patches, "patches", Form::Whole),
    Column::new("largest_patch_fraction", "1", &[(any, "share of points in the largest patch")], |at| {
        at.measured.patches.map_or(f64::NAN, |found| found.largest() as f64 / at.points as f64).into()
    })
    .at("patches.largest_fraction")
    .with(statistics)
    .on(Table::Patches, "largest", Form::Share),
    Column::new(
        "percolates_x",
        "1",
        &[(any, "1 if a patch winds around the cell along x or, with free boundaries, spans the surface")],
        |at| flag(at.measured.patches.map(|found| found.percolate()), 0),
    )
    .flag()
    .at("patches.percolates.0")
    .with(statistics)
    .on(Table::Patches, "patch spans x", Form::Flag)
    .detail(),
    Column::new(
        "percolates_y",
        "1",
        &[(any, "1 if a patch winds around the cell along y or, with free boundaries, spans the surface")],
        |at| flag(at.measured.patches.map(|found| found.percolate()), 1),
    )
    .flag()
    .at("patches.percolates.1")
    .with(statistics)
    .on(Table::Patches, "patch spans y", Form::Flag)
    .detail(),
    Column::new(
        "conductance",
        "1/length",
        &[(
            any,
            "conductance per area of the points in contact between two conductors, times the sum of their \
             resistivities: current density divided by the potential difference without the bulk drop (with free \
             boundaries, by the whole difference); no value if all points of a periodic surface touch",
        )],
        |at| at.measured.conductance.clone().map_or(Cell::Real(f64::NAN), Into::into),
    )
    .with(statistics)
    .on(Table::Patches, "conductance", Form::Size),
    Column::new(
        "contact_conductance",
        "stress*length/time/temperature",
        &[(any, "contact conductance per area: conductance divided by the sum of both conductors' resistivities")],
        |at| match &at.measured.conductance {
            Some(Ok(conductance)) => at.conductivity.map_or(f64::NAN, |series| conductance * series).into(),
            Some(Err(reason)) => Cell::undefined(reason.clone()),
            None => f64::NAN.into(),
        },
    )
    .with(conducts)
    .on(Table::Patches, "contact conductance", Form::Size)
    .main(),
    Column::new(
        "gas_conductance",
        "stress*length/time/temperature",
        &[(
            any,
            "conductance per area of the gas in the gap: mean of k/(g + M) over all points, with gas conductivity k, \
             gap g and temperature-jump length M; points in contact contribute nothing; excludes radiation",
        )],
        through_gas,
    )
    .with(gas)
    .on(Table::Patches, "gas conductance", Form::Size)
    .main(),
];

/// Returns the conductance of the gas between the points that are not in contact.
fn through_gas(at: &StateContext) -> Cell {
    let (Some(gas), Some(rest)) = (at.gas, at.rest) else { return f64::NAN.into() };
    let (repulsion, gap) = (rest.repulsion(), rest.gap());
    let found = match &at.share {
        Some(share) if !share.is_whole() => gas.conductance_over(share, repulsion.view(), gap),
        _ => gas.conductance(repulsion.view(), gap),
    };
    found.unwrap_or(f64::NAN).into()
}
