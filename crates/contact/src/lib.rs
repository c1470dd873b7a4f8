//! Contact of a rigid rough surface with an elastic body, hard wall, no friction: pressure, displacement and gap at
//! equilibrium, with residuals that are computed from the result and not taken from the solver.
//!
//! | method                                  | unknown           | a step costs       |
//! |-----------------------------------------|-------------------|--------------------|
//! | [`Solver::PreconditionedCg`] (the rule) | pressure          | 2 transform pairs  |
//! | [`Solver::ProjectedCg`]                 | pressure          | 1½                 |
//! | [`Solver::PolonskyKeer`]                | pressure          | 1½                 |
//! | [`Solver::AugmentedLagrangian`]         | both              | 1                  |
//! | [`Solver::Verlet`], [`Solver::Fire`]    | displacement      | 1                  |
//!
//! ```
//! use gfmd_contact::{Contact, Control, Settings};
//! use gfmd_response::NormalResponse;
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//! use ndarray::Array2;
//! use std::ops::ControlFlow;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let n = 64;
//! let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
//! let response = NormalResponse::new(Grid::square(n, 1.0)?, &body);
//! let wave = |i: usize| (std::f64::consts::TAU * i as f64 / n as f64).cos();
//! let heights = Array2::from_shape_fn((n, n), |(i, j)| 0.01 * wave(i) * wave(j));
//!
//! let contact = Contact::new(&response, heights.view())?;
//! let mut watch = |_: &_| ControlFlow::Continue(());
//! let solution = contact.solve(Control::MeanPressure(0.005), &Settings::default(), None, &mut watch)?;
//! assert!(solution.residual.worst() <= 1e-8);
//! assert!((solution.pressure.mean().unwrap() - 0.005).abs() < 1e-16);
//! # Ok(())
//! # }
//! ```
//!
//! Start at [`Contact`]. [`FullContact`] lets the surface move sideways too. Not here: where heights come from (`gfmd-surface`), what is measured on the result
//! (`gfmd-measure`), files (`xtask`).

mod dual;
mod dynamics;
mod error;
mod extension;
mod full;
mod problem;
mod solution;
mod solver;
mod wall;

pub use error::ContactError;
pub use full::{FullContact, FullSolution};
pub use problem::{Contact, Control, Progress, Settings, Watch};
pub use solution::{Residual, Solution};
pub use solver::Solver;
