//! Flow through the gap.

use super::{Column, undefined::flag};
use crate::column::{Form, Origin, Table};
use crate::when::{any, flow, leak};
use crate::{Cell, StateContext};

/// Definition of a conductivity.
macro_rules! over_uniform {
    ($flux:literal, $gradient:literal) => {
        concat!(
            "mean flux along ",
            $flux,
            " under a mean pressure gradient along ",
            $gradient,
            ", divided by the flux through a uniform gap equal to the mean gap"
        )
    };
}

/// Definition of a leak.
macro_rules! leak_along {
    ($axis:literal) => {
        concat!("fluid volume per time through the gap of the cell, driven by the pressure drop along ", $axis)
    };
}

/// Columns of the conductivity of the gap.
pub(super) const COLUMNS: &[Column] = &[
    Column::new("flow_xx", "1", &[(any, over_uniform!("x", "x"))], |at| conductivity(at, [0, 0]))
        .at("flow.conductivity.0.0")
        .with(flow)
        .on(Table::Flow, "flow xx", Form::Rough),
    Column::new("flow_xy", "1", &[(any, over_uniform!("x", "y"))], |at| conductivity(at, [0, 1]))
        .at("flow.conductivity.0.1")
        .with(flow)
        .on(Table::Flow, "flow xy", Form::Rough)
        .detail(),
    Column::new("flow_yx", "1", &[(any, over_uniform!("y", "x"))], |at| conductivity(at, [1, 0]))
        .at("flow.conductivity.1.0")
        .with(flow),
    Column::new("flow_yy", "1", &[(any, over_uniform!("y", "y"))], |at| conductivity(at, [1, 1]))
        .at("flow.conductivity.1.1")
        .with(flow)
        .on(Table::Flow, "flow yy", Form::Rough),
    Column::new("flow_percolates_x", "1", &[(any, "1 if the gap is open to flow along x")], |at| {
        flag(at.measured.flow.map(|flow| flow.percolates), 0)
    })
    .flag()
    .at("flow.percolates.0")
    .with(flow)
    .on(Table::Flow, "open along x", Form::Flag),
    Column::new("flow_percolates_y", "1", &[(any, "1 if the gap is open to flow along y")], |at| {
        flag(at.measured.flow.map(|flow| flow.percolates), 1)
    })
    .flag()
    .at("flow.percolates.1")
    .with(flow)
    .on(Table::Flow, "open along y", Form::Flag),
    Column::new(
        "flow_residual",
        "1",
        &[(any, "upper minus lower bound of the conductivity, divided by the conductivity; larger of x and y")],
        |at| at.measured.flow.map_or(f64::NAN, |flow| flow.residual).into(),
    )
    .at("flow.residual")
    .with(flow)
    .by(Origin::Residual),
    Column::new("leak_x", "length^3/time", &[(any, leak_along!("x"))], |at| leaked(at, 0))
        .at("leak.0")
        .with(leak)
        .on(Table::Flow, "leak x", Form::Size)
        .main(),
    Column::new("leak_y", "length^3/time", &[(any, leak_along!("y"))], |at| leaked(at, 1))
        .at("leak.1")
        .with(leak)
        .on(Table::Flow, "leak y", Form::Size)
        .main(),
];

/// Returns the leak along an axis; zero through a gap that is closed along it.
fn leaked(at: &StateContext, axis: usize) -> Cell {
    let (Some(flow), Some(fluid)) = (at.measured.flow, at.fluid) else { return f64::NAN.into() };
    if !flow.percolates[axis] {
        return 0.0.into();
    }
    match conductivity(at, [axis; 2]) {
        Cell::Real(conductivity) => fluid.leak(axis, conductivity, at.summary.mean_gap, at.lengths).into(),
        undefined => undefined,
    }
}

/// Returns the conductivity along `row` due to a gradient along `column`.
fn conductivity(at: &StateContext, [row, column]: [usize; 2]) -> Cell {
    let gap = at.summary.mean_gap;
    match at.measured.flow {
        Some(_) if gap == 0.0 => Cell::undefined(
            "the gap is closed everywhere; a conductivity is relative to a uniform gap of the mean height",
        ),
        Some(_) if gap < 0.0 => Cell::undefined(format!(
            "the mean gap is {gap:.3e}, since the surfaces overlap; a conductivity is relative to a uniform gap of \
             that height"
        )),
        Some(flow) => flow.conductivity[row][column].into(),
        None => f64::NAN.into(),
    }
}
