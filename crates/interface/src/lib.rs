//! An elastic body and a rigid rough surface joined by an interface law: adhesive and cohesive contact, friction.
//!
//! - [`Interface`]: a law that acts across the gap, with or without a hard wall, in u_z alone or in all components. At
//!   rest the elastic traction balances that of law and wall. If there are several such states, the solver finds a
//!   stable one by lowering the energy from the state of the start.
//! - [`FrictionalContact`]: a hard wall with Coulomb or Tresca friction, solved increment by increment.
//! - [`PlasticContact`]: a hard wall with a hardness, whose plastic depth stays.
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
//! Not here: the laws themselves (`gfmd-law`), hard-wall contact without friction (`gfmd-contact`, whose solvers are
//! faster).

mod certify;
mod dynamics;
mod ended;
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
mod solve;
mod state;
mod stored_fields;

pub use friction::{FrictionResidual, FrictionState, FrictionalContact};
pub use path::{Loss, Path, Quasistatic, Reading, Refinement, Step};
pub use plastic::{PlasticContact, PlasticState};
pub use problem::{Interface, Trapping};
pub use state::{Residual, State};
pub use stored_fields::StoredFields;
