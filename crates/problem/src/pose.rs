use std::sync::Arc;

use gfmd_contact::{Contact, Dynamics, Hardness, Refusal, SqueezedContact, SteepContact};
use gfmd_field::{Grid, Share};
use gfmd_green::Body;
use gfmd_interface::{Interface, Parts, QuasistaticContact, Squeezed};
use gfmd_law::{HardWall, Law};
use gfmd_plasticity::{PlasticityError, YieldingContact};
use ndarray::{Array2, ArrayRef2};

use crate::facts::Task;
use crate::inelastic::Inelastic;
use crate::options::Plasticity;
use crate::posed::Posed;
use crate::rules::Facts;
use crate::sideways::Sideways;
use crate::unknown::Unknown;

/// Problem after reading its files: its facts, and arrays with the rows of this process.
#[derive(Clone)]
pub struct Given<'a> {
    /// Parts of the problem.
    pub facts: Facts,
    /// Elastic body, with the second one if there are two.
    pub body: &'a Body,
    /// Grid of the surface.
    pub grid: &'a Grid,
    /// Rows of this process; all rows if it is alone.
    pub share: Share,
    /// Heights of the rigid surface, `[x, y]`, length, with the lift of a base that moves; peaks point at the body.
    pub heights: &'a ArrayRef2<f64>,
    /// u_x and u_y of the surface by a base that moves, `[x, y]`, length; empty at rest.
    pub sideways: &'a [Array2<f64>],
    /// Heights of the rigid surface below the slab, `[x, y]`, length; peaks point at the body.
    pub lower: Option<&'a ArrayRef2<f64>>,
    /// Law across the gap.
    pub law: Arc<dyn Law>,
    /// Largest pressure, stress.
    pub hardness: Option<Hardness>,
    /// Yielding, friction, relaxation and wear.
    pub inelastic: Inelastic,
    /// Time step and damping of the dynamic solvers.
    pub dynamics: Dynamics,
    /// True if a dynamic solver moves all components ([`Facts::moves_all_by`]).
    pub moves_all: bool,
}

impl<'a> Given<'a> {
    /// Describes a hard wall, for facts that need no more than a body and heights.
    pub fn new(facts: Facts, body: &'a Body, grid: &'a Grid, heights: &'a ArrayRef2<f64>) -> Self {
        Self {
            facts,
            body,
            grid,
            share: grid.whole(),
            heights,
            sideways: &[],
            lower: None,
            law: HardWall.into_shared(),
            hardness: None,
            inelastic: Inelastic::default(),
            dynamics: Dynamics::default(),
            moves_all: false,
        }
    }

    /// Builds the contact with a hard wall.
    fn wall(&self) -> Result<Contact, Refusal> {
        let Self { facts, body, grid, share, heights, moves_all, .. } = self;
        let contact = match facts.unknown {
            _ if *moves_all => Contact::in_all_components(body, grid, heights),
            Unknown::Held => Contact::held_sideways_over(share, body, grid, heights),
            _ => Contact::with_boundary_over(share, facts.boundary, body, grid, heights),
        };
        let contact = contact?.with_dynamics(self.dynamics);
        match &self.hardness {
            Some(hardness) => contact.with_hardness(hardness.clone()),
            None => Ok(contact),
        }
    }
}

/// Builds the contact of a problem with parts that can be combined ([`Facts::check`]).
///
/// # Errors
/// Returns an error if heights, body, hardness or law cannot be in contact, or if the given parts differ from the
/// facts.
pub fn pose(given: &Given) -> Result<Posed, Refusal> {
    let posed = pose_normal(given)?;
    let Given { facts: Facts { unknown, finite_slope, boundary, .. }, body, grid, share, moves_all, .. } = given;
    // Finite slopes have a lateral displacement of their own.
    if *unknown != Unknown::All || *finite_slope || *moves_all {
        return Ok(posed);
    }
    Ok(posed.with_sideways(Sideways::new(*boundary, share, grid, body)?))
}

/// Builds the contact in u_z, unless a dynamic solver moves all components.
fn pose_normal(given: &Given) -> Result<Posed, Refusal> {
    let Given { facts, body, grid, share, heights, lower, law, hardness, inelastic, .. } = given;
    // All parts, so that none of them is left out of the contact.
    let Inelastic { plasticity, shear, relaxation, wear } = inelastic;
    for (part, is_fact, is_given) in [
        ("lower surface", facts.lower.is_some(), lower.is_some()),
        ("hardness", facts.hardness, hardness.is_some()),
        ("yield stress", facts.yields, plasticity.is_some()),
        ("limit of the shear", facts.friction.is_some(), shear.is_some()),
        ("relaxation", facts.relaxes.is_some(), relaxation.is_some()),
        ("coefficient of wear", facts.wear.is_some(), wear.is_some()),
    ] {
        if is_fact != is_given {
            return Err(Refusal::Part { part });
        }
    }
    let parts = || Parts {
        body,
        grid,
        share: Some(share),
        heights,
        boundary: facts.boundary,
        // A path of a periodic hard wall is solved as a law, since the energy of a law gives the loss.
        law: facts.solves_a_law().then(|| Arc::clone(law)),
        all_components: facts.shears_by_law(),
        held: facts.unknown == Unknown::Held,
        hardness: hardness.clone(),
        shear: *shear,
        relaxation: relaxation.as_ref().map(|(prony, relaxes)| (prony, *relaxes)),
        wear: *wear,
        sideways: given.sideways,
    };
    if let Some(lower) = lower {
        if facts.task == Task::Path {
            return Ok(Posed::new(Squeezed::on_path(&parts(), lower)?));
        }
        if facts.has_law() {
            let law = Arc::clone(law);
            let contact = match facts.unknown {
                Unknown::Held => Squeezed::held_sideways_over(share, body, grid, [heights, lower], law)?,
                _ => Squeezed::distributed(share, body, grid, [heights, lower], law)?,
            };
            return Ok(Posed::new(match hardness {
                Some(hardness) => contact.with_hardness(hardness.clone())?,
                None => contact,
            }));
        }
        let contact = match facts.unknown {
            Unknown::Held => SqueezedContact::held_sideways_over(share, body, grid, heights, lower)?,
            _ => SqueezedContact::distributed(share, body, grid, heights, lower)?,
        };
        return Ok(Posed::new(match hardness {
            Some(hardness) => contact.with_hardness(hardness.clone())?,
            None => contact,
        }));
    }
    if facts.finite_slope {
        let contact = SteepContact::distributed(share, body, grid, heights)?;
        return Ok(Posed::new(match hardness {
            Some(hardness) => contact.with_hardness(hardness.clone())?,
            None => contact,
        }));
    }
    if let Some(Plasticity { hardening, cells, .. }) = plasticity {
        let contact = YieldingContact::distributed(share, body, grid, heights, hardening, cells);
        return contact.map(Posed::new).map_err(|error| match error {
            PlasticityError::Contact(refusal) => refusal,
            _ => Refusal::Part { part: "cells" },
        });
    }
    if facts.task == Task::Path {
        return Ok(Posed::new(QuasistaticContact::new(&parts())?));
    }
    if facts.has_law() {
        let law = Arc::clone(law);
        let interface = match facts.unknown {
            Unknown::Held => Interface::held_sideways_over(share, body, grid, heights, law)?,
            _ => Interface::with_boundary_over(share, facts.boundary, body, grid, heights, law)?,
        };
        return Ok(Posed::new(match hardness {
            Some(hardness) => interface.with_hardness(hardness.clone())?,
            None => interface,
        }));
    }
    // The solvers for a hard wall alone are faster than the solvers for a law.
    Ok(Posed::new(given.wall()?))
}
