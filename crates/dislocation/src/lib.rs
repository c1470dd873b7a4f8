//! Green's function dislocation dynamics in plane strain. Edge dislocations glide on one slip system below a rigid flat
//! punch without friction: plasticity comes from dislocations and contact from the elastic response of the surface
//! (Venugopalan, Müser and Nicola 2017; discrete dislocation plasticity: van der Giessen and Needleman 1995).
//!
//! Fields of dislocations in an unbounded body are in closed form for periodic rows. A smooth image field restores the
//! conditions at the surface and at the base. It is a boundary-value problem of the surface alone, solved by
//! `gfmd-mixed` with the compliance of the body ([`Domain::state`]). Forces are Peach-Koehler forces. Sources emit
//! pairs, obstacles hold dislocations, opposite ones annihilate, and dislocations that reach the surface leave a step
//! ([`Crystal`]).
//!
//! - [`Edge`], [`Stress`]: dislocations with any Burgers vector, and stresses.
//! - [`Domain`], [`State`]: body, punch, and equilibrium with given dislocations: pressure, stresses, forces, energy.
//! - [`Crystal`]: dynamics on a [`SlipSystem`], with a [`Balance`] of energy.
//!
//! The image field consists of the waves of the grid: within about two spacings of the surface the image force is too
//! weak. Strains are small; the body is a half-space or one slab on a bonded base; the mean strain along x is zero far
//! below. The punch does not separate under tension. Equations: theory.md, section 15.
//!
//! The force on one dislocation below a free surface is the force of its image (Head 1953):
//!
//! ```
//! use gfmd_dislocation::{Domain, Edge};
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//!
//! let material = Material::from_young(70.0, 0.33)?;
//! let domain = Domain::new(&Body::half_space(material), &Grid::line(2001, 200.0)?, &[false; 2001])?;
//! let (b, depth) = (2.5e-4, 1.0);
//! let state = domain.state(&[Edge { place: [100.0, -depth], burgers: [0.0, b] }], &[], 0.0, 0.0)?;
//! let image = material.shear_modulus() * b * b / (4.0 * std::f64::consts::PI * (1.0 - 0.33) * depth);
//! assert!((state.force(0)?[1] - image).abs() < 1e-3 * image);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod array;
mod crystal;
mod domain;
mod error;

pub use array::{Edge, Stress};
pub use crystal::{Balance, Crystal, Dislocation, Events, Obstacle, SlipSystem, Source};
pub use domain::{Domain, State, Step};
pub use error::DislocationError;
