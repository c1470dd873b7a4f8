//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`Interface`]: a law acting across the gap, with or without a hard wall, in u_z alone or in all components. The
//!   wall may have a hardness and springs. In equilibrium the elastic traction balances the tractions of law and wall.
//!   If several equilibria exist, the solver finds a stable one by lowering the energy from the starting state.
//! - [`QuasistaticContact`]: a contact made of [`Parts`], under loads or increment by increment: a wall or a law,
//!   friction, a hardness, wear, and a body that relaxes, in any combination.
//! - [`Squeezed`]: such a contact at both faces of a plate between two surfaces.
//! - [`Path`]: any of these contacts along a path of drives, with the energy lost in each step; [`follow`] keeps all
//!   states, from which [`QuasistaticContact::gradient_along`] computes derivatives.

mod bonds;
mod certify;
mod dynamics;
mod frame;
mod give_way;
mod gradient;
mod increments;
mod kinks;
mod newton;
mod numbers;
mod patch;
mod path;
mod problem;
mod quasistatic;
mod resumable;
mod search_result;
mod solve;
mod squeezed;
mod start;
mod state;
mod stiffness;
mod stored_fields;

pub use gfmd_contact::{Body, Equilibrium, Grid, Load, Loss, Losses, Material, Quasistatic, Reading};
pub use gfmd_law as law;
pub use increments::follow;
pub use ndarray;
pub use path::{Path, Refinement, Step};
pub use problem::{Interface, Trapping};
pub use quasistatic::{
    Increment, LimitingPressure, Parts, PathGradient, PathGradientError, QuasistaticContact, QuasistaticState,
    Sequence, Shear, StiffnessError, Wear,
};
pub use squeezed::{Squeezed, SqueezedState, stiffness_between_walls};
pub use state::{Residual, State};
pub use stored_fields::StoredFields;
