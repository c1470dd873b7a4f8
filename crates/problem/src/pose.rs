use gfmd_contact::{Refusal, SqueezedContact, SteepContact};
use gfmd_interface::{Parts, QuasistaticContact, Sequence, Squeezed};
use gfmd_plasticity::{PlasticityError, YieldingContact};

use crate::options::Plasticity;
use crate::posed::{Posed, posed};
use crate::rules::Facts;
use crate::sideways::Sideways;
use crate::unknown::Unknown;

/// Builds the contact of a problem with parts that can be combined ([`Facts::check`]), after its files are read. The
/// facts decide the sequence, the boundary, what is held, and whether a wall is solved as a law, whatever the parts
/// say; `all_components` of the parts is true if a dynamic solver moves all components ([`Facts::moves_all_by`]). The
/// cells of the `plasticity` [fit](Plasticity::cells).
///
/// # Errors
/// Returns an error if heights, body, hardness, law or cells cannot be in contact, or if the parts differ from the
/// facts.
pub fn pose(facts: &Facts, given: &Parts, plasticity: Option<&Plasticity>) -> Result<Posed, Refusal> {
    // All parts, so that none of them is left out of the contact.
    for (part, is_fact, is_given) in [
        ("lower surface", facts.lower.is_some(), given.lower.is_some()),
        ("hardness", facts.hardness, given.hardness.is_some()),
        ("yield stress", facts.yields, plasticity.is_some()),
        ("limit of the shear", facts.friction.is_some(), given.shear.is_some()),
        ("relaxation", facts.relaxes.is_some(), given.relaxation.is_some()),
        ("coefficient of wear", facts.wear.is_some(), given.wear.is_some()),
    ] {
        if is_fact != is_given {
            return Err(Refusal::Part { part });
        }
    }
    let parts = Parts {
        sequence: facts.sequence,
        boundary: facts.boundary,
        law: given.law.clone().filter(|_| facts.solves_a_law()),
        all_components: facts.shears_by_law() || given.all_components,
        held: facts.unknown == Unknown::Held,
        ..given.clone()
    };
    let Parts { body, grid, heights, .. } = parts;
    let share = &parts.share.cloned().unwrap_or_else(|| grid.whole());
    let moves_sideways = facts.unknown == Unknown::All && !facts.finite_slope && !given.all_components;
    let sideways = || moves_sideways.then(|| Sideways::new(facts.boundary, share, grid, body)).transpose();
    if let Some(lower) = parts.lower {
        if facts.sequence == Sequence::Path || facts.has_law() {
            return Ok(posed(Squeezed::new(&parts)?, sideways()?));
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
