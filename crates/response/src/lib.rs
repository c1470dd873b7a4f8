//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`NormalResponse`]: one number per mode, for problems with u_z and the pressure only.
//! - [`FreeCompliance`]: the normal response of a non-periodic patch of a half-space; [`FreeFullCompliance`]: for all
//!   components.
//! - [`PlateResponse`]: pressure and indentation on both faces of a plate, a 2 × 2 matrix per mode.
//! - [`FullResponse`]: a matrix per mode, for problems with all components, x, y, z, or x, z on a line.
//! - [`Elastic`]: a shared [`NormalResponse`] or [`FullResponse`]; each problem owns its [`Transforms`], which hold the
//!   memory and a counter.
//! - [`ComplexTransforms`]: a complex factor per mode, for waves whose pressure leads the displacement.
//! - [`Operator`]: any [`Hermitian`] matrix per mode, such as a preconditioner from stiffness and interface.
//!
//! A field of several [`Components`] is one slice, component after component, each laid out as a field of `gfmd-field`.
//! Displacement and traction refer to the surface of the body, with +z out of the body; compression makes u_z and t_z
//! negative.

mod complex;
mod components;
mod elastic;
mod free;
mod free_full;
mod full;
mod hermitian;
mod normal;
mod operator;
mod patch_table;
mod plate;
mod recent;
mod rounded;
mod scattered;
mod units;

pub use complex::ComplexTransforms;
pub use components::Components;
pub use elastic::{Elastic, FullTransforms, NormalTransforms, Transforms};
pub use free::{FreeCompliance, FreeRounded, FreeTransforms};
pub use free_full::{FreeFullCompliance, FreeFullTransforms};
pub use full::FullResponse;
pub use gfmd_field::Grid;
pub use gfmd_green::{Body, Material};
pub use hermitian::Hermitian;
pub use normal::NormalResponse;
pub use operator::{Operator, Workspace};
pub use plate::{PlateResponse, PlateTransforms};
pub use rounded::RoundedTransforms;
pub use scattered::{BlockRows, Blocks, COARSENING, Cells, LANES, Scattered, ScatteredMemory};
pub use units::{power_of_two, unit_of};
