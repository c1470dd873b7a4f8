//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! A [`World`] is [`Ranks`](gfmd_vector::Ranks): [`start`] initialises MPI, the world communicates and finalises it.
//! One binary runs with Open MPI, with MPICH and libraries of the same interface (Intel MPI, Cray MPICH, MVAPICH), and
//! with the standard interface of MPI 5 (`libmpi_abi`). `GFMD_MPI` names the file of a library; with `none` each
//! process runs alone.
#![warn(missing_docs)]
#![warn(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)]

mod kind;
mod launcher;
mod library;
mod world;

pub use launcher::Launcher;
pub use world::{MpiError, World, start};
