//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`WearContact`]: a hard wall that wears. A [`Drive`] gives the distance at which its load, or
//!   approach, is reached; the previous state is the start. Steps are implicit and stable at any length.
//! - [`WearState`]: the fields at one distance, the depth lost so far, and the energies.

mod contact;
mod state;

pub use contact::WearContact;
pub use gfmd_contact::{Body, Contact, Drive, Equilibrium, Fields, Grid, Load, Material};
pub use ndarray;
pub use state::WearState;
