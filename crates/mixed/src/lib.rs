//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! Start at [`MixedProblem`]. A point may be held in all components (a sticking punch) or in some (u_z under a
//! frictionless punch). The contact area is given.
//!
//! | method                                       | unknown                        | cost of a step |
//! |----------------------------------------------|--------------------------------|----------------|
//! | [`Method::ConjugateGradients`] (the default) | traction on held entries       | 2 applications |
//! | [`Method::Verlet`], [`Method::Fire`], ...    | displacement of free entries   | 1 application  |
//!
//! An application of stiffness or compliance takes one transform pair for each component. The result of either method
//! is defined by its traction and certified: u = G t is recomputed and compared with the prescribed displacement.
//!
//! Fields are `[component, x, y]` with the components x, y, z, or x, z on a line; t is the traction on the body's
//! surface, so that under a punch u_z < 0 and t_z < 0.
//!
//! If the mean displacement of a component does not depend on its mean traction (half-space; u_z of a bonded
//! incompressible slab; see [`FullResponse::uniform_compliance`](gfmd_response::FullResponse::uniform_compliance)),
//! displacements are measured from the mean level of the surface: ⟨u⟩ = 0 at any load. For the slab this follows from
//! its constant volume; for the half-space it is a choice of origin.

mod conjugate_gradients;
mod dynamics;
mod error;
mod prescribed;
mod problem;
mod punch;
mod solution;
mod solve;
mod surface;

pub use error::MixedError;
pub use gfmd_field::Grid;
pub use gfmd_green::{Body, Material};
pub use gfmd_relax::Budget;
pub use gfmd_relax::Factors;
pub use prescribed::Prescribed;
pub use problem::{Method, MixedProblem};
pub use punch::{Edge, FlatPunch};
pub use solution::MixedSolution;
