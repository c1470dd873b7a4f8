//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`YieldingContact`]: a rigid surface pressed on a body that yields; [`step`](YieldingContact::step) makes the next
//!   [`PlasticState`] of a loading path, [`certify`](YieldingContact::certify) recomputes one.
//! - [`Hardening`]: yield stress with isotropic and kinematic hardening.
//! - [`Cells`]: the discretisation in depth.
//!
//! Only the plastic strain is discretised in depth, in cells with one value per point of their grid. Elastic waves are
//! exact in the contact: G p is the displacement of the body of `gfmd-green`. The cells are finite elements with the
//! strain at mid-depth; they give the displacement u^pl of the surface by plastic strain and, by its adjoint, the
//! stress of the pressure in the cells. The contact is solved for the clearance c − u^pl inside every evaluation, so
//! that the energy is a convex function of the plastic strain alone, minimised by Newton's method with conjugate
//! gradients.

mod error;
mod hardening;

mod cells;
mod division;
mod pack;
mod sweep;

mod frozen;
mod lane;
mod operator;
mod volume;

mod checkpoint;

mod plastic;

mod state;

mod yielding;

mod step;

mod equilibrium;

pub use cells::{Cell, Cells};
pub use error::PlasticityError;
pub use gfmd_contact::{Body, Budget, Contact, Fields, Grid, Load, Material, Refusal, SolveError, Why};
pub use hardening::Hardening;
pub use ndarray;
pub use plastic::PlasticStrain;
pub use state::{FlowResidual, PlasticDisplacement, PlasticState};
pub use yielding::YieldingContact;
