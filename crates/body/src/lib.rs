//! Fields inside an elastic body computed from its surface displacement: displacement, strain, stress, von Mises stress
//! and elastic energy density at any depth ([theory.md](../gfmd/theory/index.html), section 5).
//!
//! Start with [`Interior`], which computes the spectra of a surface displacement once. Each depth then costs one pass
//! over the modes and one inverse transform per component. All depths share memory, so that a volume takes the memory
//! of a few of its planes. The body is a half-space or a slab on any base, including layers; the surface is a plane or
//! a line (plane strain). Fields and their components are laid out as in `gfmd-response`.
//!
//! - [`Interior::new`] takes all components of the displacement; u_x and u_y are zero for a surface without lateral
//!   displacement.
//! - [`Interior::frictionless`] takes only u_z, for a surface without shear traction.
//!
//! See `gfmd-contact` for contact, `gfmd-green` for the matrices of one wave vector, and `gfmd-files` for files.
//!
//! ```
//! use gfmd_body::Interior;
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//!
//! // A slab pressed down by a hundredth of its height: uniform strain, and stress C11 and C12 times it.
//! let body = Body::slab(Material::from_young(1.0, 0.25)?, 0.5)?;
//! let grid = Grid::square(16, 1.0)?;
//! let mut displacement = vec![0.0; 3 * grid.len()];
//! displacement[2 * grid.len()..].fill(-0.005);
//! let interior = Interior::new(&body, grid, &displacement)?;
//!
//! let mut ws = interior.workspace();
//! for depth in [0.0, 0.2, 0.5] {
//!     let u = interior.displacement(depth, &mut ws)?;
//!     assert!((u[2 * grid.len()] + 0.01 * (0.5 - depth)).abs() < 1e-16);
//!     let state = interior.deformation(depth, &mut ws)?.at(0);
//!     let [xx, _, zz, ..] = state.stress;
//!     assert!((zz + 0.012).abs() < 1e-16 && (xx + 0.004).abs() < 1e-16);
//!     assert!((state.von_mises() - 0.008).abs() < 1e-16);
//!     assert!((state.energy_density() - 0.5 * 0.012 * 0.01).abs() < 1e-18);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod base;
mod deformation;
mod interior;

pub use base::BaseField;
pub use deformation::{Deformation, State};
pub use interior::{Interior, InteriorError, Workspace};
