//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`Thermal`]: conductivity and diffusivity of a body.
//! - [`Flash`]: a source that moves over a body. With a second body, in which the source rests, the heat is shared such
//!   that both surfaces have the same temperature at every heated point.
//! - [`Heated`]: heat flux into the body, temperature, and scalar results.
//!
//! In the frame of the source, a wave q of the heat flux Q (per area and time) causes the temperature
//! Q/(k √(q² − i q·v/α)), where the root has a positive real part (theory.md, section 7.11). A uniform flux has no
//! steady state: temperatures are relative to the mean of the surface.

mod error;
mod flash;
mod memory;
mod search;
mod thermal;

pub use error::HeatError;
pub use flash::{Flash, Heated};
pub use gfmd_field::Grid;
pub use gfmd_relax::{Budget, Watch};
pub use ndarray;
pub use thermal::Thermal;
