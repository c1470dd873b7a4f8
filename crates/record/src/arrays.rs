//! Fields of a state, each declared once.

use gfmd_contact::Fields as _;
use gfmd_problem::{AnyState, Facts};
use ndarray::{CowArray, Ix2};

use crate::column::{Meaning, meaning};
use crate::when::{any, between, hard_between, hardness, law, path, yields};

/// Field of a state, one number for each point `[x, y]`.
#[derive(Clone, Copy, Debug)]
pub struct Array {
    /// Name in a file.
    pub name: &'static str,
    /// Kind of quantity, such as "stress" or "stress*length".
    pub unit: &'static str,
    /// Definitions; a problem uses the first one that applies.
    pub meanings: &'static [Meaning],
    /// True if the states of a problem have the field.
    pub present: fn(&Facts) -> bool,
    /// Options that give a load the field; empty if every load has it, `None` if no load has it.
    pub of_loads: Option<&'static str>,
    /// Values in a state; `None` if it does not have the field.
    pub value: for<'a> fn(&'a AnyState, &Facts) -> Option<CowArray<'a, f64, Ix2>>,
}

impl Array {
    const fn new(
        name: &'static str,
        unit: &'static str,
        meanings: &'static [Meaning],
        value: for<'a> fn(&'a AnyState, &Facts) -> Option<CowArray<'a, f64, Ix2>>,
    ) -> Self {
        Self { name, unit, meanings, present: any, of_loads: Some(""), value }
    }

    /// Restricts the field to some problems; among loads, to problems with the options `of_loads`.
    const fn with(self, of_loads: &'static str, present: fn(&Facts) -> bool) -> Self {
        Self { present, of_loads: Some(of_loads), ..self }
    }

    /// Restricts the field to some paths.
    const fn of_paths(self, present: fn(&Facts) -> bool) -> Self {
        Self { present, of_loads: None, ..self }
    }

    /// Returns the definition for a problem.
    pub fn meaning(&self, facts: &Facts) -> &'static str {
        meaning(self.meanings, facts)
    }
}

/// Returns true if the pressure alone identifies the points in contact: without a law it is a wall pressure.
fn wall(facts: &Facts) -> bool {
    !facts.has_law()
}

/// Returns true if loads have a lateral displacement.
fn lateral(facts: &Facts) -> bool {
    !path(facts) && facts.moves_sideways()
}

/// Returns true if a path has a shear traction.
fn shear(facts: &Facts) -> bool {
    path(facts) && facts.moves_sideways()
}

fn axis_of<'a>(rest: &'a AnyState, axis: usize) -> Option<CowArray<'a, f64, Ix2>> {
    rest.lateral().get(axis).map(|field| field.view().into())
}

fn shear_of<'a>(rest: &'a AnyState, axis: usize) -> Option<CowArray<'a, f64, Ix2>> {
    rest.shear(axis).map(Into::into)
}

/// Options that make a surface move sideways.
const SIDEWAYS: &str = "--components all or --finite-slope (a profile has no y)";
/// Options that add a lower surface.
const BETWEEN: &str = "--lower-surface or --lower-seed";
/// Options that add a lower surface and a hardness.
const HARD_BETWEEN: &str = "--hardness and --lower-surface or --lower-seed";

/// All fields, in journal order.
pub const ARRAYS: &[Array] = &[
    Array::new(
        "pressure",
        "stress",
        &[(any, "pressure on the elastic surface, compression positive; attraction is negative")],
        // Without a law, the pressure on a path is the wall pressure: exactly zero where nothing touches.
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
            (path, "depth by which the surfaces have been pressed into each other"),
            (between, "depth by which the upper face and surface are pressed into each other beyond touching"),
            (any, "depth by which the surfaces are pressed into each other beyond touching"),
        ],
        |rest, _| rest.plastic_depth().map(|depth| depth.view().into()),
    )
    .with("--hardness", hardness),
    Array::new(
        "plastic_displacement_z",
        "length",
        &[(any, "normal displacement due to plastic strain below the surface; once unloaded, the residual topography")],
        |rest, _| Some(rest.yielding()?.plastic_displacement.view().into()),
    )
    .of_paths(yields),
    Array::new(
        "wear_depth",
        "length",
        &[(between, "depth lost by the upper face and surface so far"), (any, "depth lost by both surfaces so far")],
        |rest, _| rest.of_parts()?.wear_depth().map(|depth| depth.view().into()),
    )
    .of_paths(|facts| facts.wear.is_some()),
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
    Array::new(
        "lower_pressure",
        "stress",
        &[
            (law, "pressure on the lower face of the slab; attraction is negative"),
            (any, "pressure on the lower face of the slab"),
        ],
        |rest, facts| {
            rest.lower().map(|face| if path(facts) && wall(facts) { face.repulsion() } else { face.pressure() })
        },
    )
    .with(BETWEEN, between),
    Array::new(
        "lower_displacement_z",
        "length",
        &[(any, "normal displacement of the lower face of the slab, positive upwards")],
        |rest, _| rest.lower().map(|face| (-&face.displacement_z()).into()),
    )
    .with(BETWEEN, between),
    Array::new(
        "lower_gap",
        "length",
        &[(any, "distance between the lower face of the slab and the lower surface")],
        |rest, _| rest.lower().map(|face| face.gap().into()),
    )
    .with(BETWEEN, between),
    Array::new(
        "lower_plastic_depth",
        "length",
        &[
            (path, "depth by which the lower face and surface have been pressed into each other"),
            (any, "depth by which the lower face and surface are pressed into each other beyond touching"),
        ],
        |rest, _| rest.lower_plastic_depth().map(|depth| depth.view().into()),
    )
    .with(HARD_BETWEEN, hard_between),
    Array::new("lower_wear_depth", "length", &[(any, "depth lost by the lower face and surface so far")], |rest, _| {
        rest.lower_of_parts()?.wear_depth().map(|depth| depth.view().into())
    })
    .of_paths(|facts| between(facts) && facts.wear.is_some()),
    Array::new(
        "lower_repulsion",
        "stress",
        &[(any, "repulsive pressure on the lower face of the slab, without attraction")],
        |rest, _| rest.lower().map(|face| face.repulsion()),
    )
    .with("--lower-surface or --lower-seed and a --law", |facts| between(facts) && !path(facts) && !wall(facts)),
    Array::new(
        "repulsion",
        "stress",
        &[(any, "repulsive pressure, without attraction; positive at the points in contact")],
        // With a wall, the pressure also holds the attraction; where a law without a wall vanishes, the sign of its
        // pressure is a rounding error.
        |rest, _| Some(rest.repulsion()),
    )
    .with("a --law with a wall (exponential, dugdale); elsewhere it is the positive part of the pressure", |facts| {
        (!path(facts) || facts.statistics) && !wall(facts)
    }),
];

/// Returns the fields of the states of a problem.
pub fn arrays(facts: &Facts) -> impl Iterator<Item = &'static Array> {
    ARRAYS.iter().filter(move |array| (array.present)(facts))
}

/// Returns the name of the field that is positive at the points in contact.
pub fn repulsion(facts: &Facts) -> &'static str {
    if wall(facts) { "pressure" } else { "repulsion" }
}
