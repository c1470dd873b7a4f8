//! Numbers of a flat punch.

use gfmd_mixed::MixedSolution;
use gfmd_response::Components;
use ndarray::Axis;

use crate::Cell;
use crate::column::{Form, Meaning, Origin, Subject};

/// Punches on an elastic body.
#[derive(Clone, Copy, Debug)]
pub struct Punch;

/// Features of a problem of a punch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PunchFacts {
    /// True if a mask names the points under the punch, which then has no width.
    pub mask: bool,
    /// True of a strip in plane strain.
    pub line: bool,
}

/// Input from which the columns of a punch are computed.
#[derive(Clone, Copy, Debug)]
pub struct PunchContext<'a> {
    /// Displacement and traction.
    pub solution: &'a MixedSolution,
    /// Components of both.
    pub components: Components,
    /// Width of the punch, and width as which its points act, length.
    pub widths: [f64; 2],
    /// Depth to which the punch is pressed, length.
    pub depth: f64,
    /// Number of points under the punch.
    pub contact_nodes: usize,
    /// Largest residual of a converged state.
    pub tolerance: f64,
    /// Wall time, s.
    pub seconds: f64,
}

impl PunchContext<'_> {
    fn mean_traction(&self, component: usize) -> f64 {
        self.solution.mean_traction().get(component).copied().unwrap_or(f64::NAN)
    }

    fn max_pressure(&self) -> f64 {
        let normal = self.solution.traction.index_axis(Axis(0), self.components.normal());
        normal.iter().fold(0.0, |most, t| f64::max(most, -t))
    }
}

impl Subject for Punch {
    type Facts = PunchFacts;
    type Context<'a> = PunchContext<'a>;
    const COLUMNS: &'static [Column] = COLUMNS;
    const KEY: &'static str = "depth";
}

type Column = crate::Column<Punch>;

fn any(_: &PunchFacts) -> bool {
    true
}

const X: &[Meaning<PunchFacts>] = &[(any, "mean traction along x over the whole surface")];
const Y: &[Meaning<PunchFacts>] = &[(any, "mean traction along y over the whole surface")];
const Z: &[Meaning<PunchFacts>] = &[(any, "mean traction along z over the whole surface, negative if it presses")];

/// Numbers of a punch, in the order in which they are printed.
const COLUMNS: &[Column] = &[
    Column::new("punch_width", "length", &[(any, "width of the punch")], |at| at.widths[0].into())
        .with(|facts| !facts.mask),
    Column::new(
        "effective_width",
        "length",
        &[(any, "effective width of its N points, N - 1/3 grid spacings")],
        |at| at.widths[1].into(),
    )
    .with(|facts| !facts.mask),
    Column::new("depth", "length", &[(any, "indentation depth of the punch")], |at| at.depth.into())
        .head("depth", Form::Size),
    Column::new("contact_nodes", "1", &[(any, "points under the punch")], |at| (at.contact_nodes as u64).into())
        .count(),
    Column::new("mean_pressure", "stress", &[(any, "mean pressure over the whole surface")], |at| {
        (-at.mean_traction(at.components.normal())).into()
    })
    .head("mean pressure", Form::Size),
    mean_traction("mean_traction_x", "mean_traction.0", X, |at| at.mean_traction(0).into()),
    mean_traction("mean_traction_y", "mean_traction.1", Y, |at| at.mean_traction(1).into()).with(|facts| !facts.line),
    mean_traction("mean_traction_z", "mean_traction.2", Z, |at| at.mean_traction(2).into()).with(|facts| !facts.line),
    mean_traction("mean_traction_z", "mean_traction.1", Z, |at| at.mean_traction(1).into()).with(|facts| facts.line),
    Column::new("max_pressure", "stress", &[(any, "largest pressure, at the edge of the punch")], |at| {
        at.max_pressure().into()
    })
    .head("max pressure", Form::Size),
    Column::new("elastic_energy", "stress*length", &[(any, "elastic energy per area of the surface")], |at| {
        at.solution.elastic_energy().into()
    })
    .head("elastic energy", Form::Size),
    Column::new(
        "residual",
        "1",
        &[(any, "largest error of the prescribed displacement, divided by the depth")],
        |at| at.solution.residual.into(),
    )
    .by(Origin::Residual),
    Column::new("converged", "1", &[(any, "1 if the residual is within the tolerance")], |at| {
        (at.solution.residual <= at.tolerance).into()
    })
    .flag(),
    Column::new("iterations", "1", &[(any, "iterations, or time steps")], |at| at.solution.iterations.into())
        .count()
        .by(Origin::Way),
    Column::new("transform_pairs", "1", &[(any, "transform pairs of one component")], |at| {
        (at.solution.transform_pairs as u64).into()
    })
    .count()
    .by(Origin::Way),
    Column::new("seconds", "s", &[(any, "wall time")], |at| at.seconds.into()).by(Origin::Clock),
];

const fn mean_traction(
    name: &'static str,
    json: &'static str,
    meanings: &'static [Meaning<PunchFacts>],
    value: for<'a, 'b> fn(&'a PunchContext<'b>) -> Cell,
) -> Column {
    Column::new(name, "stress", meanings, value).at(json).in_file(|_| false)
}
