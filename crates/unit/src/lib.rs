//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! A problem has a unit of length and a unit of stress, independent of each other: an energy per area is a stress times
//! a length in any unit system ([`Units`]). A [`Dimension`] holds the powers of stress, length, time and temperature;
//! results write it as `stress*length`.

mod dimension;
mod display_unit;
mod length;
mod quantity;
mod units;

pub use dimension::Dimension;
pub use display_unit::{DisplayUnit, digits};
pub use length::{Conversion, canonical, convert_lengths, is_length};
pub use quantity::{Quantity, UnknownUnit};
pub use units::{NoValue, Units};
