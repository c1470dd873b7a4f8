//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! [`source`], [`base`], [`lower`] and [`hardness`] read the arrays that options name. [`units`] replaces quantities
//! with a unit by bare numbers. A [`Session`](session::Session) handles interruptions, collects warnings and knows the
//! processes that compute together; a [`Failure`](failure::Failure) says why a command fails, and its exit status.
//! Nothing here prints, parses the command line or ends the process.
#![warn(missing_docs)]

pub mod array;
pub mod base;
pub mod failure;
pub mod fluids;
pub mod hardness;
pub mod json;
pub mod lower;
pub mod materials;
pub mod memory;
mod named;
pub mod processes;
pub mod rows;
pub mod session;
pub mod source;
mod table;
pub mod units;
