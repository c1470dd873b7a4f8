//! Parts of a series: their words, and their places in a file.

use gfmd_problem::{Facts, Sequence};

/// Words for the parts of a series, and their places in a file.
pub struct SeriesLayout {
    /// Word for a part.
    pub name: &'static str,
    /// Word for several parts.
    pub plural: &'static str,
    /// Group of their scalars.
    pub group: &'static str,
    /// Meaning of the dimension of their scalars, which has the name of a part.
    pub(super) meaning: &'static str,
    /// Dimension of their fields, and its meaning.
    pub stored: (&'static str, &'static str),
}

impl SeriesLayout {
    /// Returns the parts of a problem.
    pub fn of(facts: &Facts) -> &'static Self {
        match facts.sequence {
            Sequence::Loads => &LOADS,
            Sequence::Path => &STEPS,
        }
    }
}

const LOADS: SeriesLayout = SeriesLayout {
    name: "load",
    plural: "loads",
    group: "/loads",
    meaning: "load step",
    stored: ("load", "load step"),
};

const STEPS: SeriesLayout = SeriesLayout {
    name: "step",
    plural: "steps",
    group: "/path",
    meaning: "step of the path",
    stored: ("waypoint", "waypoint of the path"),
};
