//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`Prony`]: relaxation of the modulus, branch by branch; [`Relaxes`] selects the moduli that relax.
//! - [`ViscoelasticContact`]: contact with a viscoelastic body through a hard wall or a law. A
//!   [`Drive`] sets the time at which its load or approach is reached; the previous state is the
//!   start. Each step is one solve of an elastic contact, exact for a displacement linear in time.
//! - [`SlidingContact`]: steady state of a surface sliding over a viscoelastic body, with hysteretic friction.
//! - [`ViscoelasticState`]: fields at one time, energies, and the memory of the body.

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
pub use gfmd_contact::{Body, Contact, Drive, Equilibrium, Grid, Load, Material};
pub use ndarray;
pub use prony::{Prony, PronyError};
pub use relaxes::{Relaxes, UnknownRelaxes};
pub use sliding::{Persson, SlidingContact, SlidingError, SlidingState};
pub use state::ViscoelasticState;
pub use velocity::{Velocity, VelocityError};
