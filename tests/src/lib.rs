//! Validation: results of the crates against references, closed forms and identities.
//!
//! A [`Check`] is a value and the bound it must meet. [`TOPICS`] lists the functions that make them, one file each.
//! `cargo test` asserts them, and `cargo xtask verify` prints them and writes docs/validation.md. To add a topic: a
//! file with a function of a [`Reference`], and its line in [`TOPICS`].
//!
//! The crate also has short ways to pose a contact problem.

mod analytic;
mod bounded;
mod check;
mod damping;
mod exact;
mod friction;
mod inside;
mod kernels;
mod laws;
mod layered;
mod limits;
mod moving;
mod patch;
mod plastic;
mod punch;
mod reference;
mod squeezed;
mod steep;

use std::sync::Arc;

use gfmd_contact::{Contact, Equilibrium, Load, Solution, SolveError, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_response::NormalResponse;
use ndarray::ArrayRef2;

pub use check::{Bound, Check, Topic, ValidationError};
pub use reference::Reference;

/// All topics, in the order of docs/validation.md.
pub const TOPICS: [Topic; 16] = [
    Topic { name: "limits", title: "Limits of the stiffness: tables 3.1 to 3.3 of the thesis", checks: limits::checks },
    Topic { name: "kernels", title: "Stiffness and compliance of one wave vector", checks: kernels::checks },
    Topic { name: "inside", title: "Fields inside the body", checks: inside::checks },
    Topic { name: "punch", title: "Flat punches that stick: chapter 4 of the thesis", checks: punch::checks },
    Topic { name: "damping", title: "Damping of the dynamics", checks: damping::checks },
    Topic { name: "analytic", title: "Contacts with a closed form", checks: analytic::checks },
    Topic { name: "exact", title: "Contacts that other programs solved", checks: exact::checks },
    Topic { name: "bounded", title: "Free boundaries and hardness", checks: bounded::checks },
    Topic { name: "plastic", title: "A hardness for each point, on layers, along a path", checks: plastic::checks },
    Topic { name: "layered", title: "Layers, bases and pairs of bodies", checks: layered::checks },
    Topic { name: "laws", title: "Adhesion, cohesion, friction", checks: laws::checks },
    Topic { name: "friction", title: "Friction with pressure and shear coupled", checks: friction::checks },
    Topic { name: "patch", title: "Laws, friction and slabs on a patch", checks: patch::checks },
    Topic { name: "moving", title: "A base that moves", checks: moving::checks },
    Topic { name: "squeezed", title: "A slab between two rough surfaces", checks: squeezed::checks },
    Topic { name: "steep", title: "Finite slopes", checks: steep::checks },
];

/// All methods that can be selected by name.
pub const SOLVERS: [Solver; 9] = [
    Solver::PolonskyKeer,
    Solver::ProjectedCg,
    Solver::PreconditionedCg,
    Solver::Verlet,
    Solver::VerletCritical,
    Solver::VerletModes,
    Solver::Fire,
    Solver::Fire2,
    Solver::AugmentedLagrangian,
];

/// Returns a half-space of contact modulus 1.
///
/// # Panics
/// Never panics.
pub fn unit_half_space() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.0).expect("a valid material"))
}

/// Solves without monitoring.
///
/// # Errors
/// As [`Equilibrium::equilibrate`].
pub fn press(
    response: &Arc<NormalResponse>,
    heights: &ArrayRef2<f64>,
    load: Load,
    solver: Solver,
    tolerance: f64,
) -> Result<Solution, SolveError<Solution>> {
    Contact::with_response(Arc::clone(response), heights)?.press(load).solver(solver).tolerance(tolerance).solve()
}

/// Presses `heights` on the unit half-space over a square cell of length 1, by the default method.
///
/// # Errors
/// As [`Equilibrium::equilibrate`]; a shape that makes no grid.
pub fn press_on_half_space(
    heights: &ArrayRef2<f64>,
    mean_pressure: f64,
    tolerance: f64,
) -> Result<Solution, ValidationError> {
    let grid = Grid::new(heights.dim().into(), [1.0, 1.0])?;
    let contact = Contact::new(&unit_half_space(), &grid, heights)?;
    Ok(contact.press(Load::MeanPressure(mean_pressure)).tolerance(tolerance).solve()?)
}
