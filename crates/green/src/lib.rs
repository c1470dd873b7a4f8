//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! | body                     | frictionless stiffness 1/G_zz(q)                    | derived in             |
//! |--------------------------|-----------------------------------------------------|------------------------|
//! | half-space               | E* q/2                                              | theory.md, section 3   |
//! | slab, bonded base        | P N/(sinh h cosh h − r h), h = q·height             | theory.md, sections 1–3|
//! | slab, sliding base       | (E* q/2)(sinh h cosh h + h)/sinh² h                 | theory.md, section 4   |
//! | plate, free base         | (E* q/2)(sinh² h − h²)/(sinh h cosh h + h)          | theory.md, section 4   |
//! | coating, stack of layers | layer by layer from below                           | theory.md, section 4   |
//! | two bodies               | 1/(G_zz of one + G_zz of the other)                 | theory.md, section 4.1 |
//! | slab pressed on two faces| [`Plate`]                                           | theory.md, section 4.3 |
//!
//! Start at [`Body`]: create a [`Material`], then a half-space, a slab on a [`Base`], or a [stack](Body::stack). A body
//! gives the stiffness of a wave vector, or a table for all modes of a grid. [`Body::at_depth`] gives displacements and
//! stresses inside. A [`Layer`] has two moving faces. A [`Conductor`] conducts heat or electric current. Displacement u
//! and traction t refer to the surface of the body, +z points out of the body, and fields vary as e^(+i q·r). The mode
//! q = 0 is identified by its indices, never by a small wavenumber. ν = 1/2 is exact, and no product q·height
//! overflows. Formulas are derived in theory.md.
//!
//! [`patch_compliance`] gives the displacements of a body loaded on a patch of its surface, without periodic images:
//! one number for each distance between two cells.

mod blocks;
mod body;
mod conductor;
mod error;
mod ground;
mod half_space;
mod hyperbolic;
mod layer;
mod material;
mod patch;
mod plate;
mod sagittal;
mod section;
mod slab;
mod stack;
mod stacking;
mod tables;
mod tabulated;

pub use blocks::{Blocks, Matrix2, Matrix3};
pub use body::{Base, Body, Height};
pub use conductor::Conductor;
pub use error::GreenError;
pub use gfmd_field::Grid;
pub use ground::{Condition, Ground};
pub use layer::Layer;
pub use material::Material;
pub use num_complex::Complex64;
pub use patch::{PatchMatrix, has_level, patch_compliance, patch_matrix, patch_resistance};
pub use plate::{Plate, PlateCompliance};
pub use section::{ContinuousMatrix, Section, StressMatrix2, StressMatrix3};
pub use stacking::{BaseKind, UnknownBase};
pub use tables::{
    StiffnessRange, normal_stiffness_range, normal_stiffness_table, restricted_normal_stiffness_table, stiffness_range,
    table_of_lanes, table_of_modes,
};
