//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! Fields of dislocations in an unbounded body are in closed form for periodic rows. A smooth image field restores the
//! conditions at the surface and at the base. It is a boundary-value problem of the surface alone, solved by
//! `gfmd-mixed` with the compliance of the body ([`Domain::state`]). Forces are Peach-Koehler forces. Sources emit
//! pairs, obstacles hold dislocations, opposite ones annihilate, and dislocations that reach the surface leave a step
//! ([`Crystal`]). Discrete dislocation plasticity: van der Giessen and Needleman 1995.
//!
//! - [`Edge`], [`Stress`]: dislocations with any Burgers vector, and stresses.
//! - [`Domain`], [`State`]: body, punch, and equilibrium with given dislocations: pressure, stresses, forces, energy.
//! - [`Crystal`]: dynamics on a [`SlipSystem`], with a [`Balance`] of energy.
//!
//! The image field consists of the waves of the grid: within about two spacings of the surface the image force is too
//! weak. Strains are small; the body is a half-space or one slab on a bonded base; the mean strain along x is zero far
//! below. Equations: theory.md, section 15.

mod array;
mod crystal;
mod domain;
mod error;

pub use array::{Edge, Stress};
pub use crystal::{Balance, Crystal, Dislocation, Events, Obstacle, SlipSystem, Source};
pub use domain::{Domain, State, Step};
pub use error::DislocationError;
pub use gfmd_field::Grid;
pub use gfmd_green::{Body, Material};
