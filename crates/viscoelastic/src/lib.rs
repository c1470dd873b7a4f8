//! Contact of a rigid rough surface with a viscoelastic body, step by step in time: creep, relaxation, loading and
//! unloading.
//!
//! - [`Prony`]: relaxation of the modulus, branch by branch; [`Relaxes`] selects the moduli that relax.
//! - [`ViscoelasticContact`]: contact with a viscoelastic body through a hard wall or a law. A
//!   [`Drive`](gfmd_contact::Drive) sets the time at which its load or approach is reached; the previous state is the
//!   start. Each step is one solve of an elastic contact, exact for a displacement linear in time.
//! - [`SlidingContact`]: steady state of a surface sliding over a viscoelastic body, with hysteretic friction.
//! - [`ViscoelasticState`]: fields at one time, energies, and the memory of the body.
//!
//! Creep under a load that is applied instantly and then held:
//!
//! ```
//! use gfmd_contact::{Contact, Drive, Equilibrium, Load};
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//! use gfmd_viscoelastic::{Prony, Relaxes, ViscoelasticContact};
//! use ndarray::Array2;
//!
//! let grid = Grid::square(32, 1.0)?;
//! let wave = |i: usize| (std::f64::consts::TAU * i as f64 / 32.0).cos();
//! let heights = Array2::from_shape_fn((32, 32), |(i, j)| 0.01 * wave(i) * wave(j));
//! let body = Body::half_space(Material::from_contact_modulus(1.0, 0.5)?);
//! let rubber = Prony::from_fractions(&[(1.0, 0.5), (100.0, 0.4)])?;
//! let elastic = Contact::new(&body, &grid, &heights)?;
//! let contact = ViscoelasticContact::new(elastic.clone(), &body, &rubber, Relaxes::Both)?;
//!
//! let load = Load::MeanPressure(0.005);
//! let mut state = contact.press(load).solve()?;
//! let touched = state.solution.approach;
//! for time in [0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
//!     state = contact.press(Drive::from(load).at(time)).starting_from(Some(&state)).solve()?;
//!     assert!(state.dissipated > 0.0);
//! }
//! // All ends in the contact with the long-term modulus.
//! let end = elastic.press(load).solve()?;
//! assert!(touched < 0.5 * end.approach && (state.solution.approach / end.approach - 1.0).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not included: friction, lateral motion, and layers with different relaxation.

mod branch;
mod bulk;
mod contact;
mod elastic_contact;
mod history;
mod poles;
mod prony;
mod relaxes;
mod sliding;
mod spectrum;
mod state;
mod step;
mod velocity;

pub use branch::Branch;
pub use contact::ViscoelasticContact;
pub use elastic_contact::{ElasticContact, StepFrame, Stiffening};
pub use prony::{Prony, PronyError};
pub use relaxes::{Relaxes, UnknownRelaxes};
pub use sliding::{Persson, SlidingContact, SlidingError, SlidingState};
pub use state::ViscoelasticState;
pub use velocity::{Velocity, VelocityError};
