//! The fields of a state, each once.

use gfmd_contact::Fields as _;
use gfmd_problem::{Facts, Rest};
use ndarray::{Axis, CowArray, Ix2};

use crate::column::{Meaning, meaning};
use crate::when::{any, between, hardness, path};

/// A field of a state, one number for each point `[x, y]`.
#[derive(Clone, Copy, Debug)]
pub struct Array {
    /// The name in a file.
    pub name: &'static str,
    /// The kind of quantity, such as "stress" or "stress*length".
    pub unit: &'static str,
    /// The definitions, of which the first that applies is the one of a problem.
    pub meanings: &'static [Meaning],
    /// True if the states of a problem have the field.
    pub present: fn(&Facts) -> bool,
    /// The options with which a load has the field, empty if each has it; `None` if no load has it.
    pub of_loads: Option<&'static str>,
    /// The field of a state; `None` if it has none.
    pub value: for<'a> fn(&'a Rest, &Facts) -> Option<CowArray<'a, f64, Ix2>>,
}

impl Array {
    const fn new(
        name: &'static str,
        unit: &'static str,
        meanings: &'static [Meaning],
        value: for<'a> fn(&'a Rest, &Facts) -> Option<CowArray<'a, f64, Ix2>>,
    ) -> Self {
        Self { name, unit, meanings, present: any, of_loads: Some(""), value }
    }

    /// In some problems alone: of loads, those with these options.
    const fn with(self, of_loads: &'static str, present: fn(&Facts) -> bool) -> Self {
        Self { present, of_loads: Some(of_loads), ..self }
    }

    /// In some paths alone.
    const fn of_paths(self, present: fn(&Facts) -> bool) -> Self {
        Self { present, of_loads: None, ..self }
    }

    /// The definition in a problem.
    pub fn meaning(&self, facts: &Facts) -> &'static str {
        meaning(self.meanings, facts)
    }
}

/// True if the pressure alone tells the points in contact: without a law it is that of a wall.
fn wall(facts: &Facts) -> bool {
    !facts.has_law()
}

/// True if loads have a lateral displacement.
fn lateral(facts: &Facts) -> bool {
    !path(facts) && facts.moves_sideways()
}

/// True if a path has a shear traction.
fn shear(facts: &Facts) -> bool {
    path(facts) && facts.moves_sideways()
}

fn axis_of<'a>(rest: &'a Rest, axis: usize) -> Option<CowArray<'a, f64, Ix2>> {
    rest.lateral().get(axis).map(|field| field.view().into())
}

fn shear_of<'a>(rest: &'a Rest, axis: usize) -> Option<CowArray<'a, f64, Ix2>> {
    rest.traction().map(|traction| traction.index_axis(Axis(0), axis).into())
}

/// The options with which a surface moves sideways.
const SIDEWAYS: &str = "--components all or --finite-slope (a profile has no y)";
/// Those with which there are two surfaces.
const BETWEEN: &str = "--lower-surface or --lower-seed";

/// All fields, in the order of a journal.
pub const ARRAYS: &[Array] = &[
    Array::new(
        "pressure",
        "stress",
        &[(any, "pressure on the elastic surface, compression positive; attraction is negative")],
        // A path without a law has the pressure of the wall: exactly zero where nothing touches.
        |rest, facts| Some(if path(facts) && wall(facts) { rest.repulsion() } else { rest.pressure() }),
    ),
    Array::new(
        "displacement_z",
        "length",
        &[(any, "normal displacement of the elastic surface, negative downwards")],
        |rest, _| Some(rest.displacement_z().into()),
    ),
    Array::new("gap", "length", &[(any, "distance between the surfaces")], |rest, _| Some(rest.gap().into())),
    Array::new(
        "plastic_depth",
        "length",
        &[
            (path, "depth by which the surfaces were pressed into each other so far"),
            (any, "depth by which the surfaces are pressed into each other beyond touching"),
        ],
        |rest, _| rest.plastic_depth().map(|depth| depth.view().into()),
    )
    .with("--hardness", hardness),
    Array::new("wear_depth", "length", &[(any, "depth that both surfaces have lost so far")], |rest, _| {
        rest.worn().map(|state| state.depth.view().into())
    })
    .of_paths(|facts| facts.wears),
    Array::new("displacement_x", "length", &[(any, "displacement of the elastic surface along x")], |rest, _| {
        axis_of(rest, 0)
    })
    .with(SIDEWAYS, lateral),
    Array::new("displacement_y", "length", &[(any, "displacement of the elastic surface along y")], |rest, _| {
        axis_of(rest, 1)
    })
    .with(SIDEWAYS, |facts| lateral(facts) && !facts.line),
    Array::new("shear_x", "stress", &[(any, "shear traction on the elastic surface along x")], |rest, _| {
        shear_of(rest, 0)
    })
    .of_paths(shear),
    Array::new("shear_y", "stress", &[(any, "shear traction on the elastic surface along y")], |rest, _| {
        shear_of(rest, 1)
    })
    .of_paths(|facts| shear(facts) && !facts.line),
    Array::new("lower_pressure", "stress", &[(any, "pressure on the lower face of the slab")], |rest, _| {
        rest.lower().map(|lower| lower.pressure.view().into())
    })
    .with(BETWEEN, between),
    Array::new(
        "lower_displacement_z",
        "length",
        &[(any, "normal displacement of the lower face of the slab, positive upwards")],
        |rest, _| rest.lower().map(|lower| (-&lower.displacement).into()),
    )
    .with(BETWEEN, between),
    Array::new(
        "lower_gap",
        "length",
        &[(any, "distance between the lower face of the slab and the lower surface")],
        |rest, _| rest.lower().map(|lower| lower.gap.view().into()),
    )
    .with(BETWEEN, between),
    Array::new(
        "repulsion",
        "stress",
        &[(any, "repulsive pressure, without attraction; positive at the points in contact")],
        // Beside that of a wall the pressure is an attraction, and where a law without a wall vanishes, its sign is
        // that of rounding errors.
        |rest, _| Some(rest.repulsion()),
    )
    .with("a --law with a wall (exponential, dugdale); elsewhere it is the positive part of the pressure", |facts| {
        !path(facts) && !wall(facts)
    }),
];

/// The fields of the states of a problem.
pub fn arrays(facts: &Facts) -> impl Iterator<Item = &'static Array> {
    ARRAYS.iter().filter(move |array| (array.present)(facts))
}

/// The name of the field whose positive values are those of the points in contact.
pub fn repulsion(facts: &Facts) -> &'static str {
    if wall(facts) { "pressure" } else { "repulsion" }
}
