//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! [`source`], [`base`], [`lower`] and [`hardness`] read the arrays that options name. [`series`] computes the states
//! at the loads of `contact` and at the steps of `path`, keeps them in a file and beside it, and checks stored ones;
//! [`resume`] continues. [`units`] replaces quantities with a unit by bare numbers. [`result`](mod@result) reads the
//! problem of a file and compares numbers. A [`Session`](session::Session) handles interruptions, collects warnings and
//! knows the processes that compute together. Nothing here prints, parses the command line or ends the process.
#![warn(missing_docs)]

pub mod accuracy;
pub mod array;
pub mod base;
pub mod columns;
pub mod convergence;
pub mod failure;
pub mod flow;
pub mod hardness;
pub mod json;
pub mod lower;
pub mod memory;
pub mod processes;
pub mod progress;
pub mod result;
pub mod resume;
pub mod rows;
pub mod series;
pub mod session;
pub mod source;
pub mod statistics;
pub mod sweep;
mod table;
pub mod trace;
pub mod units;
