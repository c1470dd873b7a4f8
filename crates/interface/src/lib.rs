//! Contact of an elastic body and a rigid rough surface with an interface law: adhesion, cohesion and friction.
//!
//! - [`Interface`]: a law acting across the gap, with or without a hard wall, in u_z alone or in all components. In
//!   equilibrium the elastic traction balances the tractions of law and wall. If several equilibria exist, the solver
//!   finds a stable one by lowering the energy from the starting state.
//! - [`FrictionalContact`]: a hard wall with Coulomb or Tresca friction, solved increment by increment.
//! - [`PlasticContact`]: a hard wall with a hardness and permanent plastic depth.
//! - [`Path`]: any of these contacts along a path of drives, with the energy lost in each step.
//!
//! An adhesive wave, pressed on a half-space and pulled off:
//!
//! ```
//! use gfmd_contact::{Equilibrium, Load};
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//! use gfmd_interface::Interface;
//! use gfmd_law::Exponential;
//! use ndarray::Array2;
//!
//! let n = 512;
//! let grid = Grid::line(n, 1.0)?;
//! let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
//! let heights = Array2::from_shape_fn((n, 1), |(i, _)| 0.01 * (std::f64::consts::TAU * i as f64 / n as f64).cos());
//! let interface = Interface::new(&body, &grid, &heights, Exponential::new(5e-5, 1.2e-3)?)?;
//! assert!(interface.trapping().is_none());
//!
//! let pressed = interface.press(Load::Approach(0.004)).solve()?;
//! let pulled = interface.press(Load::Approach(-0.001)).starting_from(Some(&pressed)).solve()?;
//! assert!(pressed.mean_pressure > 0.0 && pulled.mean_pressure < 0.0);
//! assert!(pulled.contact_fraction > 0.1 && pulled.contact_fraction < pressed.contact_fraction);
//! assert!(pulled.residual.worst() <= 1e-8);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not included: the laws (`gfmd-law`) and frictionless hard-wall contact (`gfmd-contact`, with faster solvers).

mod certify;
mod dynamics;
mod frame;
mod friction;
mod gradient;
mod newton;
mod numbers;
mod patch;
mod path;
mod plastic;
mod problem;
mod resumable;
mod search_result;
mod solve;
mod state;
mod stored_fields;

pub use friction::{FrictionResidual, FrictionState, FrictionalContact};
pub use path::{Loss, Path, Quasistatic, Reading, Refinement, Step};
pub use plastic::{PlasticContact, PlasticState};
pub use problem::{Interface, Trapping};
pub use state::{Residual, State};
pub use stored_fields::StoredFields;
