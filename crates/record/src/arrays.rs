//! The fields of a state, each once.

use gfmd_contact::Fields as _;
use gfmd_problem::{Facts, Rest, Task};
use ndarray::{Axis, CowArray, Ix2};

use crate::column::{Meaning, meaning};

/// A field of a state, one number for each point `[x, y]`.
#[derive(Clone, Copy, Debug)]
pub struct Array {
    /// The name in a file.
    pub name: &'static str,
    /// The kind of quantity: "stress" or "length".
    pub unit: &'static str,
    /// The definitions, of which the first that applies is the one of a problem.
    pub meanings: &'static [Meaning],
    /// True if the states of a problem have the field.
    pub present: fn(&Facts) -> bool,
    /// The field of a state; `None` if it has none.
    pub value: for<'a> fn(&'a Rest, &Facts) -> Option<CowArray<'a, f64, Ix2>>,
}

impl Array {
    /// The definition in a problem.
    pub fn meaning(&self, facts: &Facts) -> &'static str {
        meaning(self.meanings, facts)
    }
}

fn any(_: &Facts) -> bool {
    true
}

fn path(facts: &Facts) -> bool {
    facts.task == Task::Path
}

/// True if the pressure alone tells the points in contact: without a law it is that of a wall.
fn wall(facts: &Facts) -> bool {
    !facts.has_law()
}

fn hardness(facts: &Facts) -> bool {
    facts.hardness
}

fn lower(facts: &Facts) -> bool {
    facts.lower.is_some()
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

/// All fields, in the order of a journal.
pub const ARRAYS: &[Array] = &[
    Array {
        name: "pressure",
        unit: "stress",
        meanings: &[(any, "pressure on the elastic surface, compression positive; attraction is negative")],
        present: any,
        // A path without a law has the pressure of the wall: exactly zero where nothing touches.
        value: |rest, facts| Some(if path(facts) && wall(facts) { rest.repulsion() } else { rest.pressure() }),
    },
    Array {
        name: "displacement_z",
        unit: "length",
        meanings: &[(any, "normal displacement of the elastic surface, negative downwards")],
        present: any,
        value: |rest, _| Some(rest.displacement_z().into()),
    },
    Array {
        name: "gap",
        unit: "length",
        meanings: &[(any, "distance between the surfaces")],
        present: any,
        value: |rest, _| Some(rest.gap().into()),
    },
    Array {
        name: "plastic_depth",
        unit: "length",
        meanings: &[
            (path, "depth by which the surfaces were pressed into each other so far"),
            (any, "depth by which the surfaces are pressed into each other beyond touching"),
        ],
        present: hardness,
        value: |rest, _| rest.plastic_depth().map(|depth| depth.view().into()),
    },
    Array {
        name: "wear_depth",
        unit: "length",
        meanings: &[(any, "depth that both surfaces have lost so far")],
        present: |facts| facts.wears,
        value: |rest, _| rest.worn().map(|state| state.depth.view().into()),
    },
    Array {
        name: "displacement_x",
        unit: "length",
        meanings: &[(any, "displacement of the elastic surface along x")],
        present: lateral,
        value: |rest, _| axis_of(rest, 0),
    },
    Array {
        name: "displacement_y",
        unit: "length",
        meanings: &[(any, "displacement of the elastic surface along y")],
        present: |facts| lateral(facts) && !facts.line,
        value: |rest, _| axis_of(rest, 1),
    },
    Array {
        name: "shear_x",
        unit: "stress",
        meanings: &[(any, "shear traction on the elastic surface along x")],
        present: shear,
        value: |rest, _| shear_of(rest, 0),
    },
    Array {
        name: "shear_y",
        unit: "stress",
        meanings: &[(any, "shear traction on the elastic surface along y")],
        present: |facts| shear(facts) && !facts.line,
        value: |rest, _| shear_of(rest, 1),
    },
    Array {
        name: "lower_pressure",
        unit: "stress",
        meanings: &[(any, "pressure on the lower face of the slab")],
        present: lower,
        value: |rest, _| rest.lower().map(|lower| lower.pressure.view().into()),
    },
    Array {
        name: "lower_displacement_z",
        unit: "length",
        meanings: &[(any, "normal displacement of the lower face of the slab, positive upwards")],
        present: lower,
        value: |rest, _| rest.lower().map(|lower| (-&lower.displacement).into()),
    },
    Array {
        name: "lower_gap",
        unit: "length",
        meanings: &[(any, "distance between the lower face of the slab and the lower surface")],
        present: lower,
        value: |rest, _| rest.lower().map(|lower| lower.gap.view().into()),
    },
    Array {
        name: "repulsion",
        unit: "stress",
        meanings: &[(any, "repulsive pressure, without attraction; positive at the points in contact")],
        // Beside that of a wall the pressure is an attraction, and where a law without a wall vanishes, its sign is that of
        // rounding errors.
        present: |facts| !path(facts) && !wall(facts),
        value: |rest, _| Some(rest.repulsion()),
    },
];

/// The fields of the states of a problem.
pub fn arrays(facts: &Facts) -> impl Iterator<Item = &'static Array> {
    ARRAYS.iter().filter(move |array| (array.present)(facts))
}

/// The name of the field whose positive values are those of the points in contact.
pub fn repulsion(facts: &Facts) -> &'static str {
    if wall(facts) { "pressure" } else { "repulsion" }
}
