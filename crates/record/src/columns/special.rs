//! Numbers of special contacts: patches, hardness, finite slopes.

use super::Column;
use crate::column::Form;
use crate::when::{any, free, hardness, path, steep};
use crate::{Cell, StateContext};

/// Columns of the force on a patch, the plastic depth and the projected area.
pub(super) const COLUMNS: &[Column] = &[
    Column::new("force", "stress*length^2", &[(any, "force, of a line per length across it (stress*length)")], |at| {
        (at.summary.mean_pressure * at.lengths[0] * at.lengths[1]).into()
    })
    .with(free),
    Column::new(
        "plastic_fraction",
        "1",
        &[
            (path, "points whose pressure is the hardness, to its accuracy, over all points"),
            (any, "points whose pressure is the hardness over all points"),
        ],
        |at| plastic(at)[0].into(),
    )
    .with(hardness)
    .head("plastic", Form::Share),
    Column::new(
        "plastic_volume",
        "length",
        &[(path, "mean plastic depth so far"), (any, "mean plastic depth over the whole surface")],
        |at| plastic(at)[1].into(),
    )
    .with(hardness)
    .head("depth", Form::Size),
    Column::new(
        "projected_area_fraction",
        "1",
        &[(
            any,
            "contact area of the deformed surface, projected onto the plane of the rigid one, over the area of the \
             cell",
        )],
        |at| {
            let found = at.rest.and_then(|rest| rest.steep()).map(|state| state.projected_area());
            found.map_or(Cell::Real(f64::NAN), |found| found.map_err(|error| error.to_string()).into())
        },
    )
    .with(steep),
];

/// Returns the fraction of plastic points and the mean plastic depth.
fn plastic(at: &StateContext) -> [f64; 2] {
    let found = at.rest.and_then(|rest| rest.plastic_fraction_and_volume());
    found.map_or([f64::NAN; 2], |(fraction, volume)| [fraction, volume])
}
