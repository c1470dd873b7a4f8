use gfmd_contact::{Refusal, SqueezedContact, SteepContact};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Parts, QuasistaticContact, Sequence, Squeezed};
use gfmd_plasticity::{PlasticityError, YieldingContact};
use ndarray::ArrayRef2;

use crate::options::Plasticity;
use crate::posed::{Posed, posed};
use crate::rules::Facts;
use crate::sideways::Sideways;
use crate::unknown::Unknown;

/// Problem after reading its files: its facts, and arrays with the rows of this process.
#[derive(Clone)]
pub struct Given<'a> {
    /// Facts of the problem.
    pub facts: Facts,
    /// Parts of the contact. The facts decide the sequence, the boundary and the components, and whether a wall is
    /// solved as a law, whatever the parts say.
    pub parts: Parts<'a>,
    /// Heights of the rigid surface below the slab, `[x, y]`, length; peaks point at the body.
    pub lower: Option<&'a ArrayRef2<f64>>,
    /// Yielding of the body, with cells that [fit](Plasticity::cells).
    pub plasticity: Option<&'a Plasticity>,
    /// True if a dynamic solver moves all components ([`Facts::moves_all_by`]).
    pub moves_all: bool,
}

impl<'a> Given<'a> {
    /// Describes a hard wall, for facts that need no more than a body and heights.
    pub fn new(facts: Facts, body: &'a Body, grid: &'a Grid, heights: &'a ArrayRef2<f64>) -> Self {
        Self { facts, parts: Parts::new(body, grid, heights), lower: None, plasticity: None, moves_all: false }
    }

    /// Returns the parts, completed by the facts.
    fn completed(&self) -> Parts<'a> {
        let Self { facts, parts, moves_all, .. } = self;
        Parts {
            sequence: facts.sequence,
            boundary: facts.boundary,
            // A path of a periodic hard wall is solved as a law, since the energy of a law gives the loss.
            law: parts.law.clone().filter(|_| facts.solves_a_law()),
            all_components: facts.shears_by_law() || *moves_all,
            held: facts.unknown == Unknown::Held,
            ..parts.clone()
        }
    }
}

/// Builds the contact of a problem with parts that can be combined ([`Facts::check`]).
///
/// # Errors
/// Returns an error if heights, body, hardness or law cannot be in contact, or if the given parts differ from the
/// facts.
pub fn pose(given: &Given) -> Result<Posed, Refusal> {
    let Given { facts, lower, plasticity, moves_all, .. } = given;
    let parts = given.completed();
    // All parts, so that none of them is left out of the contact.
    for (part, is_fact, is_given) in [
        ("lower surface", facts.lower.is_some(), lower.is_some()),
        ("hardness", facts.hardness, parts.hardness.is_some()),
        ("yield stress", facts.yields, plasticity.is_some()),
        ("limit of the shear", facts.friction.is_some(), parts.shear.is_some()),
        ("relaxation", facts.relaxes.is_some(), parts.relaxation.is_some()),
        ("coefficient of wear", facts.wear.is_some(), parts.wear.is_some()),
    ] {
        if is_fact != is_given {
            return Err(Refusal::Part { part });
        }
    }
    let Parts { body, grid, heights, .. } = &parts;
    let share = &parts.share.cloned().unwrap_or_else(|| grid.whole());
    let moves_sideways = facts.unknown == Unknown::All && !facts.finite_slope && !*moves_all;
    let sideways = || moves_sideways.then(|| Sideways::new(facts.boundary, share, grid, body)).transpose();
    if let Some(lower) = lower {
        if facts.sequence == Sequence::Path || facts.has_law() {
            return Ok(posed(Squeezed::new(&parts, lower)?, sideways()?));
        }
        let contact = match parts.held {
            true => SqueezedContact::held_sideways_over(share, body, grid, heights, lower)?,
            false => SqueezedContact::distributed(share, body, grid, heights, lower)?,
        };
        return Ok(match &parts.hardness {
            Some(hardness) => posed(contact.with_hardness(hardness.clone())?, sideways()?),
            None => posed(contact, sideways()?),
        });
    }
    if facts.finite_slope {
        // Finite slopes have a lateral displacement of their own.
        let contact = SteepContact::distributed(share, body, grid, heights)?;
        return Ok(match &parts.hardness {
            Some(hardness) => posed(contact.with_hardness(hardness.clone())?, None),
            None => posed(contact, None),
        });
    }
    if let Some(Plasticity { hardening, cells, .. }) = plasticity {
        let contact = YieldingContact::distributed(share, body, grid, heights, hardening, cells);
        let contact = contact.map_err(|error| match error {
            PlasticityError::Contact(refusal) => refusal,
            _ => Refusal::Part { part: "cells" },
        });
        return Ok(posed(contact?, sideways()?));
    }
    Ok(posed(QuasistaticContact::new(&parts)?, sideways()?))
}
