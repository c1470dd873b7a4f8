//! Processes that share one contact: [`Ranks`](gfmd_vector::Ranks) by an MPI library that is found when the program starts.
//!
//! No library is needed to build, nor to run alone. One binary runs with Open MPI, with MPICH and what has its interface (Intel
//! MPI, Cray MPICH, MVAPICH), and with the standard interface of MPI 5 (`libmpi_abi`). `GFMD_MPI` names the file of a library, or is
//! `none`: each process then runs alone.
//!
//! [`start`] begins, [`World`] sends and ends. Not here: what is shared (`gfmd-vector`), and what a process prints.
#![warn(missing_docs)]
#![warn(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)]

mod kind;
mod launcher;
mod library;
mod world;

pub use launcher::Launcher;
pub use world::{MpiError, World, start};
