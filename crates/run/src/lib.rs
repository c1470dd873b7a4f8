//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! [`series`] computes the states at the loads of `contact` and at the steps of `path`, and keeps them in a file and
//! beside it; [`resume`] continues. [`convergence`] says why a search ended, [`trace`] records every step of one.
//! [`parts`] divides long work over processes and time.
#![warn(missing_docs)]

pub mod accuracy;
pub mod columns;
pub mod convergence;
pub mod flow;
pub mod gas;
pub mod parts;
pub mod progress;
pub mod resume;
pub mod series;
pub mod trace;
