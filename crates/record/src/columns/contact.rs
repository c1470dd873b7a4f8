//! Area, pressure in contact, gap and wear of a state.

use gfmd_contact::Fields as _;
use gfmd_interface::QuasistaticState;

use super::{Column, undefined::reduced, undefined::worn_error};
use crate::column::{Form, Origin};
use crate::when::{any, between, friction, hardness, law, loads, path, relaxing, several_causes, wears, yields};
use crate::{Cell, StateContext};

/// Columns of the points in contact and the gap.
pub(super) const COLUMNS: &[Column] = &[
    Column::new(
        "area_fraction",
        "1",
        &[
            (path, "share of points that are repelled"),
            (law, "contact area fraction: share of points that are repelled"),
            (any, "contact area fraction: share of points in contact"),
        ],
        // On a path without contact at the wall, rounding errors of the traction would count in the summary.
        |at| match at.rest.and_then(|rest| rest.law()).filter(|_| path(at.facts)) {
            Some(law) => law.contact_fraction.into(),
            None => at.summary.area_fraction.into(),
        },
    )
    .head("area", Form::Share)
    .main(),
    Column::new(
        "stick_fraction",
        "1",
        &[(any, "fraction of all points that touch with a shear below its limit; NaN without friction")],
        |at| on_path(at).and_then(QuasistaticState::stick_fraction).unwrap_or(f64::NAN).into(),
    )
    .with(path)
    .unless(|facts| (!friction(facts)).then_some("without friction nothing sticks"))
    .head("stick", Form::Share),
    Column::new(
        "area_fraction_corrected",
        "1",
        &[(any, "contact area fraction, corrected for the excess of perimeter pixels (Yastrebov et al. 2017)")],
        |at| at.summary.area_fraction_corrected.into(),
    )
    .with(loads),
    Column::new(
        "kappa",
        "1",
        &[(law, "area_fraction / p_star; NaN if attraction carries the load"), (any, "area_fraction / p_star")],
        |at| ratio(at, at.summary.kappa),
    )
    .with(loads)
    .head("kappa", Form::Ratio)
    .detail(),
    Column::new(
        "kappa_corrected",
        "1",
        &[
            (law, "area_fraction_corrected / p_star; NaN if attraction carries the load"),
            (any, "area_fraction_corrected / p_star"),
        ],
        |at| ratio(at, at.summary.kappa_corrected),
    )
    .with(loads),
    Column::new(
        "contact_nodes",
        "1",
        &[(law, "number of points that are repelled"), (any, "number of points in contact")],
        |at| at.summary.contact_nodes.into(),
    )
    .count()
    .with(loads),
    Column::new(
        "boundary_links",
        "1",
        &[
            (law, "number of neighbouring pairs with exactly one point repelled"),
            (any, "number of neighbouring pairs with exactly one point in contact"),
        ],
        |at| at.summary.boundary_links.into(),
    )
    .count()
    .with(loads),
    Column::new("mean_gap", "length", &[(any, "mean distance between the surfaces")], |at| at.summary.mean_gap.into())
        .head("mean gap", Form::Size),
    Column::new("max_pressure", "stress", &[(law, "largest repulsive pressure"), (any, "largest pressure")], |at| {
        at.summary.max_pressure.into()
    })
    .with(|facts| loads(facts) || relaxing(facts) || wears(facts) || yields(facts) || several_causes(facts))
    .head("peak p", Form::Size),
    Column::new(
        "max_net_pressure",
        "stress",
        &[(any, "largest net pressure on the body (repulsion minus attraction), at most the hardness")],
        |at| {
            let Some(rest) = at.rest else { return f64::NAN.into() };
            let own = rest.pressure().iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let of_all = at.share.as_ref().map_or_else(|| vec![own], |share| share.each(own));
            of_all.into_iter().fold(f64::NEG_INFINITY, f64::max).into()
        },
    )
    .with(|facts| law(facts) && hardness(facts)),
    Column::new(
        "wear_volume",
        "length",
        &[
            (between, "mean depth lost so far, over the whole upper face"),
            (any, "mean depth lost so far, over the whole surface"),
        ],
        |at| worn(at).map_or(f64::NAN, |(volume, _)| volume).into(),
    )
    .with(wears)
    .head("wear", Form::Size)
    .main(),
    Column::new(
        "wear_volume_error",
        "length",
        &[(
            any,
            "estimated error of wear_volume by the finite length of all increments so far: twice its difference from a \
             path with half as many; NaN if that path was not followed",
        )],
        |at| worn_error(at, 0),
    )
    .with(wears)
    .by(Origin::Way),
    Column::new(
        "max_wear",
        "length",
        &[(between, "largest depth lost so far at the upper face"), (any, "largest depth lost so far")],
        |at| worn(at).map_or(f64::NAN, |(_, deepest)| deepest).into(),
    )
    .with(wears)
    .head("deepest", Form::Size)
    .detail(),
    Column::new(
        "mean_pressure_in_contact",
        "stress",
        &[
            (law, "mean repulsive pressure over the points that are repelled"),
            (any, "mean pressure over the points in contact"),
        ],
        |at| at.summary.mean_pressure_in_contact.into(),
    )
    .with(loads),
    Column::new(
        "pressure_deviation_in_contact",
        "stress",
        &[
            (law, "standard deviation of the repulsive pressure over the points that are repelled"),
            (any, "standard deviation of the pressure over the points in contact"),
        ],
        |at| at.summary.pressure_deviation_in_contact.into(),
    )
    .with(loads),
    Column::new(
        "pressure_moment_2",
        "stress^2",
        &[
            (law, "mean square repulsive pressure over the whole surface"),
            (any, "mean square pressure over the whole surface"),
        ],
        |at| at.summary.pressure_moment_2.into(),
    )
    .with(loads),
];

/// Returns the ratio of area to load, or the reason why there is none.
fn ratio(at: &StateContext, value: f64) -> Cell {
    if value.is_nan() && law(at.facts) {
        return Cell::undefined("attraction carries the load, to which the area has no ratio");
    }
    reduced(at, value)
}

/// Returns the state of a path.
fn on_path<'a>(at: &StateContext<'a>) -> Option<&'a QuasistaticState> {
    at.rest.and_then(|rest| rest.of_parts())
}

/// Returns mean and largest depth that the surfaces have lost.
fn worn(at: &StateContext) -> Option<(f64, f64)> {
    on_path(at).and_then(QuasistaticState::wear_volume_and_depth)
}
