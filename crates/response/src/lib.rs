//! Surface response of an elastic body on one grid: stiffness (traction = K displacement) and compliance (displacement
//! = G traction), applied to whole fields.
//!
//! - [`NormalResponse`]: one number per mode, for problems with u_z and the pressure only.
//! - [`FreeCompliance`]: the normal response of a non-periodic patch of a half-space; [`FreeFullCompliance`]: for all
//!   components.
//! - [`PlateResponse`]: pressure and indentation on both faces of a plate, a 2 × 2 matrix per mode.
//! - [`FullResponse`]: a matrix per mode, for problems with all components, x, y, z, or x, z on a line.
//! - [`Elastic`]: a shared [`NormalResponse`] or [`FullResponse`]; each problem owns its [`Transforms`], which hold the
//!   memory and a counter.
//! - [`Operator`]: any [`Hermitian`] matrix per mode, such as a preconditioner from stiffness and interface.
//!
//! A field of several [`Components`] is one slice, component after component, each laid out as a field of `gfmd-field`.
//! Displacement and traction refer to the surface of the body, with +z out of the body; compression makes u_z and t_z
//! negative.
//!
//! A uniform shear of a slab, and a displacement in all components:
//!
//! ```
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//! use gfmd_response::FullResponse;
//!
//! let body = Body::slab(Material::from_young(70.0, 0.33)?, 0.5)?;
//! let grid = Grid::square(16, 1.0)?;
//! let response = FullResponse::new(grid, &body);
//! let mut ws = response.workspace();
//! let points = grid.len();
//!
//! let mut displacement = vec![0.0; 3 * points];
//! displacement[..points].fill(0.001);
//! let mut traction = vec![0.0; 3 * points];
//! response.stiffness().apply(&displacement, &mut traction, &mut ws)?;
//! let shear_modulus = 70.0 / (2.0 * 1.33);
//! assert!((traction[0] - shear_modulus * 0.001 / 0.5).abs() < 1e-14);
//!
//! for (i, u) in displacement.iter_mut().enumerate() {
//!     *u = (i as f64 * 0.618).fract();
//! }
//! response.stiffness().apply(&displacement, &mut traction, &mut ws)?;
//! let mut back = vec![0.0; 3 * points];
//! response.compliance().apply(&traction, &mut back, &mut ws)?;
//! assert!(back.iter().zip(&displacement).all(|(a, b)| (a - b).abs() < 1e-12));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Other crates provide the matrices of one wave vector (`gfmd-green`) and the contact problems (`gfmd-contact`,
//! `gfmd-interface`, `gfmd-mixed`).

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
mod rounded;
mod scattered;
mod units;

pub use components::Components;
pub use elastic::{Elastic, FullTransforms, NormalTransforms, Transforms};
pub use free::{FreeCompliance, FreeRounded, FreeTransforms};
pub use free_full::{FreeFullCompliance, FreeFullTransforms};
pub use full::FullResponse;
pub use hermitian::Hermitian;
pub use normal::NormalResponse;
pub use operator::{Operator, Workspace};
pub use plate::{PlateResponse, PlateTransforms};
pub use rounded::RoundedTransforms;
pub use scattered::{Blocks, COARSENING, LANES, Scattered, ScatteredMemory};
pub use units::{power_of_two, unit_of};
