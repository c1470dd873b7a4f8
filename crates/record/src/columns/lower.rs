//! Lower face of a slab between two surfaces.

use gfmd_interface::QuasistaticState;

use super::{Column, undefined::worn_error};
use crate::column::{Form, Origin, Table};
use crate::when::{any, between, hard_between, hardness, path, wall_between, wears};
use crate::{Cell, StateContext};

/// Column of the lower face of a slab between two surfaces.
macro_rules! lower {
    ($name:literal, $unit:literal, $meaning:literal, |$face:ident, $summary:ident| $value:expr) => {
        Column::new(concat!("lower_", $name), $unit, &[(any, $meaning)], |at| {
            at.rest.and_then(|rest| rest.lower()).map_or(Cell::Real(f64::NAN), |$face| {
                let $summary = $face.summary();
                let _ = &$summary;
                Cell::from($value)
            })
        })
        .at(concat!("lower.", $name))
        .with(between)
    };
}

/// Residual of the lower face.
macro_rules! lower_residual {
    ($name:ident, $meaning:literal) => {
        Column::new(concat!("lower_residual_", stringify!($name)), "1", &[(any, $meaning)], |at| {
            at.rest.and_then(|rest| rest.lower_wall()).map_or(f64::NAN, |face| face.residual.$name).into()
        })
        .at(concat!("lower.residual.", stringify!($name)))
        .with(wall_between)
        .by(Origin::Residual)
    };
}

/// Columns and residuals of the lower face.
pub(super) const COLUMNS: &[Column] = &[
    lower!("mean_pressure", "stress", "mean pressure over the whole lower surface", |face, summary| summary
        .mean_pressure),
    lower!("approach", "length", "part of the approach at the lower face", |face, summary| face.approach()).on(
        Table::LowerFace,
        "approach",
        Form::Size,
    ),
    lower!("area_fraction", "1", "contact area fraction of the lower face", |face, summary| summary.area_fraction)
        .on(Table::LowerFace, "area", Form::Share)
        .main(),
    lower!(
        "area_fraction_corrected",
        "1",
        "contact area fraction of the lower face, corrected for the excess of perimeter pixels",
        |face, summary| summary.area_fraction_corrected
    )
    .on(Table::LowerFace, "corrected", Form::Share)
    .detail(),
    lower!("contact_nodes", "1", "number of points in contact at the lower face", |face, summary| summary
        .contact_nodes)
    .count(),
    lower!(
        "boundary_links",
        "1",
        "number of neighbouring pairs with exactly one point in contact, at the lower face",
        |face, summary| summary.boundary_links
    )
    .count(),
    lower!("mean_gap", "length", "mean distance between lower face and lower surface", |face, summary| summary
        .mean_gap)
    .on(Table::LowerFace, "mean gap", Form::Size),
    lower!("max_pressure", "stress", "largest pressure on the lower face", |face, summary| summary.max_pressure).on(
        Table::LowerFace,
        "peak p",
        Form::Size,
    ),
    lower!(
        "mean_pressure_in_contact",
        "stress",
        "mean pressure over the points in contact at the lower face",
        |face, summary| summary.mean_pressure_in_contact
    ),
    Column::new("lower_plastic_fraction", "1", &[(any, "share of lower-face points at the hardness")], |at| {
        plastic(at).map_or(f64::NAN, |(fraction, _)| fraction).into()
    })
    .at("lower.plastic_fraction")
    .with(hard_between)
    .on(Table::LowerFace, "plastic", Form::Share),
    Column::new(
        "lower_plastic_volume",
        "length",
        &[
            (path, "mean plastic depth over the whole lower face so far"),
            (any, "mean plastic depth over the whole lower face"),
        ],
        |at| plastic(at).map_or(f64::NAN, |(_, volume)| volume).into(),
    )
    .at("lower.plastic_volume")
    .with(hard_between)
    .on(Table::LowerFace, "depth", Form::Size)
    .detail(),
    Column::new("lower_wear_volume", "length", &[(any, "mean depth lost so far, over the whole lower face")], |at| {
        worn(at).map_or(f64::NAN, |(volume, _)| volume).into()
    })
    .at("lower.wear_volume")
    .with(|facts| between(facts) && wears(facts))
    .on(Table::LowerFace, "wear", Form::Size),
    Column::new("lower_wear_volume_error", "length", &[(any, "as wear_volume_error, at the lower face")], |at| {
        worn_error(at, 1)
    })
    .at("lower.wear_volume_error")
    .with(|facts| between(facts) && wears(facts))
    .by(Origin::Way),
    Column::new("lower_max_wear", "length", &[(any, "largest depth lost so far at the lower face")], |at| {
        worn(at).map_or(f64::NAN, |(_, deepest)| deepest).into()
    })
    .at("lower.max_wear")
    .with(|facts| between(facts) && wears(facts))
    .on(Table::LowerFace, "deepest", Form::Size)
    .detail(),
    lower_residual!(complementarity, "sum(p gap) / (sum(p) h_rms) at the lower face"),
    lower_residual!(penetration, "max(0, -min gap) / h_rms at the lower face"),
    lower_residual!(negative_pressure, "max(0, -min p) / mean p at the lower face"),
    lower_residual!(load, "|mean p - prescribed| / prescribed at the lower face, or as residual_load"),
    Column::new(
        "lower_residual_saturation",
        "1",
        &[(any, "largest gap / h_rms at points at the hardness, at the lower face")],
        |at| {
            let plastic = at.rest.and_then(|rest| rest.lower_wall()).and_then(|face| face.plastic.as_ref());
            plastic.map_or(f64::NAN, |plastic| plastic.saturation).into()
        },
    )
    .at("lower.residual.saturation")
    .with(|facts| wall_between(facts) && hardness(facts))
    .by(Origin::Residual),
];

/// Returns plastic fraction and volume of the lower face.
fn plastic(at: &StateContext) -> Option<(f64, f64)> {
    at.rest.and_then(|rest| rest.lower_plastic_fraction_and_volume())
}

/// Returns mean and largest depth lost at the lower face.
fn worn(at: &StateContext) -> Option<(f64, f64)> {
    at.rest.and_then(|rest| rest.lower_of_parts()).and_then(QuasistaticState::wear_volume_and_depth)
}
