//! Mixed boundary-value problems on the surface of an elastic body: the displacement is prescribed on some points (held),
//! the traction on the others, zero or given. What holds may hold all components (a sticking punch) or some (u_z under
//! a frictionless one). Linear: no contact is found or lost here.
//!
//! | method                                    | unknown                         | a step costs   |
//! |-------------------------------------------|---------------------------------|----------------|
//! | [`Method::ConjugateGradients`] (the rule) | traction where it is held       | 2 applications |
//! | [`Method::Verlet`], [`Method::Fire`], ... | displacement where it is free   | 1              |
//!
//! An application of stiffness or compliance takes one transform pair for each component. The result of either method
//! is defined by its traction, and certified: u = G t is recomputed from it, and must meet what was prescribed.
//!
//! Fields are `[component, x, y]` with the components x, y, z, or x, z on a line; t is the traction on the body's
//! surface, so that under a punch u_z < 0 and t_z < 0.
//!
//! Where the mean displacement of a component does not answer to its mean traction (half-space; u_z of a bonded
//! incompressible slab; see [`FullResponse::uniform_compliance`](gfmd_response::FullResponse::uniform_compliance)),
//! displacements are measured from the mean level of the surface: ⟨u⟩ = 0 whatever the load. Of the slab that is
//! all there is to say, for its volume does not change; of the half-space it is a choice of origin.
//!
//! A square punch that sticks to a slab:
//!
//! ```
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//! use gfmd_mixed::{Edge, FlatPunch, Method, MixedProblem, Prescribed};
//! use gfmd_relax::Budget;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let grid = Grid::square(32, 1.0)?;
//! let body = Body::slab(Material::from_young(70.0, 0.33)?, 1.0)?;
//!
//! let (punch, depth) = (FlatPunch::new(0.25, Edge::Inclusive)?.points(&grid), 0.004);
//! let held = Prescribed::sticking(&grid, punch.view(), [0.0, 0.0, -depth])?;
//! let problem = MixedProblem::new(&body, &grid, held)?;
//! let solution = problem.solve(Method::default(), &Budget::default(), &mut ())?;
//! assert!(solution.residual <= 1e-8);
//! assert!((solution.displacement[[2, 16, 16]] + depth).abs() < 1e-8 * depth);
//! assert!(solution.traction[[2, 16, 16]] < 0.0 && solution.traction[[2, 0, 0]] == 0.0);
//! // What the punch has done is stored in the body.
//! let pressure = -solution.mean_traction()[2];
//! assert!((solution.elastic_energy() - 0.5 * pressure * depth).abs() < 1e-8 * pressure * depth);
//! # Ok(())
//! # }
//! ```
//!
//! Start at [`MixedProblem`]. Not here: what finds its own contact (`gfmd-contact`), fields below the surface, files.

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
pub use prescribed::Prescribed;
pub use problem::{Method, MixedProblem};
pub use punch::{Edge, FlatPunch};
pub use solution::MixedSolution;
