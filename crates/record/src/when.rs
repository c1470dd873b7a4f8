//! Conditions on problems that select columns, fields and their meanings.

use gfmd_contact::Boundary;
use gfmd_problem::{Facts, Sequence};

pub(crate) fn any(_: &Facts) -> bool {
    true
}

pub(crate) fn loads(facts: &Facts) -> bool {
    facts.sequence == Sequence::Loads
}

pub(crate) fn path(facts: &Facts) -> bool {
    facts.sequence == Sequence::Path
}

/// Returns true if the approach is prescribed instead of a load.
pub(crate) fn approach_given(facts: &Facts) -> bool {
    facts.approach
}

/// Returns true if displacements count from points one length of the profile away.
pub(crate) fn level_near(facts: &Facts) -> bool {
    facts.is_level_near()
}

/// Returns true if the load is prescribed, and for all paths, since surfaces may part at any step.
pub(crate) fn load_given(facts: &Facts) -> bool {
    !facts.approach || path(facts)
}

/// Returns true if shear may act along a path.
pub(crate) fn sheared(facts: &Facts) -> bool {
    path(facts) && (facts.lateral || friction(facts))
}

pub(crate) fn law(facts: &Facts) -> bool {
    facts.has_law()
}

pub(crate) fn between(facts: &Facts) -> bool {
    facts.lower.is_some()
}

/// Returns true for a slab between two surfaces whose hard walls are solved for the pressures of each face.
pub(crate) fn wall_between(facts: &Facts) -> bool {
    between(facts) && !of_a_law(facts)
}

/// Returns true for a slab between two surfaces with a hardness.
pub(crate) fn hard_between(facts: &Facts) -> bool {
    between(facts) && hardness(facts)
}

pub(crate) fn steep(facts: &Facts) -> bool {
    facts.finite_slope
}

pub(crate) fn hardness(facts: &Facts) -> bool {
    facts.hardness
}

pub(crate) fn yields(facts: &Facts) -> bool {
    facts.yields
}

pub(crate) fn relaxing(facts: &Facts) -> bool {
    facts.relaxes.is_some()
}

pub(crate) fn wears(facts: &Facts) -> bool {
    facts.wear.is_some()
}

pub(crate) fn friction(facts: &Facts) -> bool {
    facts.friction.is_some()
}

pub(crate) fn free(facts: &Facts) -> bool {
    facts.boundary == Boundary::Free
}

pub(crate) fn statistics(facts: &Facts) -> bool {
    facts.statistics
}

pub(crate) fn flow(facts: &Facts) -> bool {
    facts.flow
}

pub(crate) fn conducts(facts: &Facts) -> bool {
    facts.conducts
}

pub(crate) fn gas(facts: &Facts) -> bool {
    facts.gas
}

pub(crate) fn leak(facts: &Facts) -> bool {
    facts.leak
}

/// Returns true if states follow a law; on a path also for a periodic hard wall.
pub(crate) fn of_a_law(facts: &Facts) -> bool {
    facts.solves_a_law()
}

/// Returns true for a hard wall on a path that is solved by hard-wall methods.
pub(crate) fn wall_on_path(facts: &Facts) -> bool {
    facts.is_wall_on_path()
}

/// Returns true for a path on which energy may be lost by several causes.
pub(crate) fn several_causes(facts: &Facts) -> bool {
    let causes = [relaxing(facts), friction(facts), wears(facts), hardness(facts), law(facts)];
    path(facts) && causes.into_iter().filter(|cause| *cause).count() > 1
}
