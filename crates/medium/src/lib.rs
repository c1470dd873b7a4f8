//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`Medium`]: a body with a memory, as the steps of a contact see it.
//! - [`Relaxing`]: a body that relaxes by a [`Prony`] series, branch by branch; [`Relaxes`] selects the moduli that
//!   relax. A step is exact for a displacement linear in time.
//! - [`PronyFit`]: a series fitted to measured storage and loss moduli; [`Wlf`] shifts them with temperature.
//! - [`SlidingContact`]: steady state of a surface sliding over a viscoelastic body, with hysteretic friction.

mod branch;
mod bulk;
mod derivatives;
mod dma;
mod medium;
mod memory;
mod nnls;
mod poles;
mod prony;
mod relaxes;
mod relaxing;
mod sliding;
mod spectrum;
mod step;
mod velocity;
mod wlf;

pub use branch::Branch;
pub use derivatives::MemoryDerivatives;
pub use dma::{
    DynamicModulus, EXCESS, FitError, FittedBranch, GOOD_MISFIT, MOST_TIMES, PLATEAU, PronyFit, RelaxationTimes,
};
pub use gfmd_contact::{Body, Contact, Drive, Equilibrium, Grid, Load, Material};
pub use medium::{Affine, Medium, Stiffening};
pub use memory::{Energies, Memory};
pub use ndarray;
pub use prony::{Prony, PronyError};
pub use relaxes::{Relaxes, UnknownRelaxes};
pub use relaxing::Relaxing;
pub use sliding::{Persson, SlidingContact, SlidingError, SlidingState};
pub use velocity::{Velocity, VelocityError};
pub use wlf::{Wlf, WlfError};
