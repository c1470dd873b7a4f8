//! Mixed boundary-value problems on the surface of an elastic body: the displacement is prescribed at held points, the
//! traction, zero or given, at free points. A point may be held in all components (a sticking punch) or in some (u_z
//! under a frictionless punch). The problem is linear; the contact area is given.
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
//! // The work of the punch is stored in the body.
//! let pressure = -solution.mean_traction()[2];
//! assert!((solution.elastic_energy() - 0.5 * pressure * depth).abs() < 1e-8 * pressure * depth);
//! # Ok(())
//! # }
//! ```
//!
//! Start at [`MixedProblem`]. Not here: unknown contact areas (`gfmd-contact`), fields below the surface (`gfmd-body`),
//! files.

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
pub use gfmd_relax::Factors;
pub use prescribed::Prescribed;
pub use problem::{Method, MixedProblem};
pub use punch::{Edge, FlatPunch};
pub use solution::MixedSolution;
