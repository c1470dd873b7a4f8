//! The problems of which something holds: those that have a column or a field, or one of its meanings.

use gfmd_contact::Boundary;
use gfmd_problem::{Facts, Task};

pub(crate) fn any(_: &Facts) -> bool {
    true
}

pub(crate) fn loads(facts: &Facts) -> bool {
    facts.task == Task::Loads
}

pub(crate) fn path(facts: &Facts) -> bool {
    facts.task == Task::Path
}

/// True if the approach is given in place of a load.
pub(crate) fn approach_given(facts: &Facts) -> bool {
    facts.approach
}

/// True if the load is given, or the steps of a path, at any of which surfaces may part.
pub(crate) fn load_given(facts: &Facts) -> bool {
    !facts.approach || path(facts)
}

/// True if the approach is that of each step of a path.
pub(crate) fn prescribed(facts: &Facts) -> bool {
    path(facts) && facts.approach
}

/// True if a shear may act along a path.
pub(crate) fn sheared(facts: &Facts) -> bool {
    path(facts) && (facts.lateral || friction(facts))
}

pub(crate) fn law(facts: &Facts) -> bool {
    facts.has_law()
}

pub(crate) fn between(facts: &Facts) -> bool {
    facts.lower.is_some()
}

pub(crate) fn steep(facts: &Facts) -> bool {
    facts.finite_slope
}

pub(crate) fn hardness(facts: &Facts) -> bool {
    facts.hardness
}

pub(crate) fn relaxing(facts: &Facts) -> bool {
    facts.relaxes.is_some()
}

pub(crate) fn wears(facts: &Facts) -> bool {
    facts.wears
}

pub(crate) fn friction(facts: &Facts) -> bool {
    facts.friction.is_some()
}

pub(crate) fn free(facts: &Facts) -> bool {
    loads(facts) && facts.boundary == Boundary::Free
}

pub(crate) fn statistics(facts: &Facts) -> bool {
    facts.statistics
}

pub(crate) fn flow(facts: &Facts) -> bool {
    facts.flow
}

/// True if the states are those of a law: on a path, of a periodic hard wall, too.
pub(crate) fn of_a_law(facts: &Facts) -> bool {
    if path(facts) { !friction(facts) && !facts.is_wall_on_path() } else { law(facts) }
}

/// True if the path is that of a hard wall by the methods of one.
pub(crate) fn wall_on_path(facts: &Facts) -> bool {
    facts.is_wall_on_path()
}
