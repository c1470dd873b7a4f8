//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! [`result`](mod@result) reads the problem of a file and compares numbers; [`series`] recomputes the states of
//! `contact` and `path`, [`sweep`] the contacts of a sweep, [`statistics`] their distributions. [`study`] is the file
//! of a study.
#![warn(missing_docs)]

pub mod result;
pub mod series;
pub mod statistics;
pub mod stored;
pub mod study;
pub mod sweep;
