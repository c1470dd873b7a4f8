//! Numbers of special contacts: patches, hardness, finite slopes, bodies that yield.

use gfmd_plasticity::PlasticState;

use super::Column;
use crate::column::Form;
use crate::when::{any, between, hardness, path, steep, yields};
use crate::{Cell, StateContext};

/// Columns of the plastic depth, the projected area and the plastic strain below the surface.
pub(super) const COLUMNS: &[Column] = &[
    Column::new(
        "plastic_fraction",
        "1",
        &[
            (path, "share of points at the hardness, to its accuracy"),
            (between, "share of upper-face points at the hardness"),
            (any, "share of points at the hardness"),
        ],
        |at| plastic(at)[0].into(),
    )
    .with(hardness)
    .head("plastic", Form::Share),
    Column::new(
        "plastic_volume",
        "length",
        &[
            (path, "mean plastic depth so far"),
            (between, "mean plastic depth over the whole upper face"),
            (any, "mean plastic depth over the whole surface"),
        ],
        |at| plastic(at)[1].into(),
    )
    .with(hardness)
    .head("depth", Form::Size)
    .detail(),
    Column::new(
        "projected_area_fraction",
        "1",
        &[(
            any,
            "contact area of the deformed surface projected onto the plane of the rigid one, divided by the cell area",
        )],
        |at| {
            let found = at.rest.and_then(|rest| rest.steep()).map(|state| state.projected_area());
            found.map_or(Cell::Real(f64::NAN), |found| found.map_err(|error| error.to_string()).into())
        },
    )
    .with(steep),
    Column::new("max_plastic_strain", "1", &[(any, "largest equivalent plastic strain below the surface")], |at| {
        yielding(at, PlasticState::max_plastic_strain)
    })
    .with(yields)
    .head("strain", Form::Size),
    Column::new(
        "plastic_strain_integral",
        "length",
        &[(any, "equivalent plastic strain integrated over depth, averaged over the surface")],
        |at| yielding(at, PlasticState::plastic_strain_integral),
    )
    .with(yields),
    Column::new("yielded_volume", "length", &[(any, "yielded volume per surface area")], |at| {
        yielding(at, PlasticState::yielded_volume)
    })
    .with(yields),
    Column::new(
        "yield_depth",
        "length",
        &[(any, "bottom depth of the lowest cell that has yielded; 0 if none has")],
        |at| yielding(at, PlasticState::yield_depth),
    )
    .with(yields)
    .head("yielded", Form::Size),
    Column::new(
        "plastic_displacement_mean",
        "length",
        &[(any, "mean normal surface displacement due to plastic strain, negative downwards")],
        |at| yielding(at, |state| state.plastic_displacement_measures().mean),
    )
    .at("plastic_displacement.mean")
    .with(yields),
    Column::new(
        "plastic_displacement_rms",
        "length",
        &[(any, "rms normal displacement due to plastic strain, about its mean")],
        |at| yielding(at, |state| state.plastic_displacement_measures().rms),
    )
    .at("plastic_displacement.rms")
    .with(yields),
    Column::new(
        "plastic_displacement_min",
        "length",
        &[(any, "lowest normal displacement due to plastic strain: the deepest imprint")],
        |at| yielding(at, |state| state.plastic_displacement_measures().min),
    )
    .at("plastic_displacement.min")
    .with(yields)
    .head("imprint", Form::Size),
];

/// Returns a number of a body that yields.
pub(super) fn yielding(at: &StateContext, of: impl Fn(&PlasticState) -> f64) -> Cell {
    at.rest.and_then(|rest| rest.yielding()).map_or(f64::NAN, of).into()
}

/// Returns the fraction of plastic points and the mean plastic depth.
fn plastic(at: &StateContext) -> [f64; 2] {
    let found = at.rest.and_then(|rest| rest.plastic_fraction_and_volume());
    found.map_or([f64::NAN; 2], |(fraction, volume)| [fraction, volume])
}
