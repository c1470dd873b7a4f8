//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! Start with [`Interior`], which computes the spectra of a surface displacement once. Each depth then costs one pass
//! over the modes and one inverse transform per component. All depths share memory, so that a volume takes the memory
//! of a few of its planes. The body is a half-space or a slab on any base, including layers; the surface is a plane or
//! a line (plane strain). Fields and their components are laid out as in `gfmd-response`.
//!
//! - [`Interior::new`] takes all components of the displacement; u_x and u_y are zero for a surface without lateral
//!   displacement.
//! - [`Interior::frictionless`] takes only u_z, for a surface without shear traction.

mod base;
mod deformation;
mod interior;

pub use base::BaseField;
pub use deformation::{Deformation, State};
pub use gfmd_field::Grid;
pub use gfmd_green::{Body, Material};
pub use interior::{Interior, InteriorError, Workspace};
