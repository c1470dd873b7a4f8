//! Units: conversion of quantities such as `70 GPa` to numbers of a problem, and of numbers of a problem to readable
//! units.
//!
//! A problem has a unit of length and a unit of stress, independent of each other: an energy per area is a stress times
//! a length in any unit system ([`Units`]). A [`Dimension`] holds the powers of stress, length, time and temperature;
//! results write it as `stress*length`. Numbers without a unit are not changed.
//!
//! ```
//! use gfmd_unit::{Quantity, Units};
//!
//! let units = Units::new(Some("nm"), Some("Pa"));
//! let value = |text: &str, kind: &str| units.value(&Quantity::parse(text).unwrap().unwrap(), kind).unwrap();
//! assert_eq!(value("70 GPa", "stress"), 70e9);
//! assert_eq!(value("0.05 J/m^2", "stress*length"), 0.05e9);
//! assert_eq!(Quantity::parse("70e9"), Ok(None));
//! assert_eq!(units.shown("stress", 7.1e8).unwrap().to_string(), "MPa");
//! ```
//!
//! Units of files are read by `topography`, flags by `problem`.

mod dimension;
mod display_unit;
mod length;
mod quantity;
mod units;

pub use dimension::Dimension;
pub use display_unit::DisplayUnit;
pub use length::{Conversion, canonical, convert_lengths, is_length};
pub use quantity::{Quantity, UnknownUnit};
pub use units::{NoValue, Units};
