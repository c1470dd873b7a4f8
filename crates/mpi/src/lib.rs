//! MPI communication for processes that share one contact: [`Ranks`](gfmd_vector::Ranks) on an MPI library that is
//! loaded at run time.
//!
//! Neither the build nor a single process needs a library. One binary runs with Open MPI, with MPICH and libraries of
//! the same interface (Intel MPI, Cray MPICH, MVAPICH), and with the standard interface of MPI 5 (`libmpi_abi`).
//! `GFMD_MPI` names the file of a library; with `none` each process runs alone.
//!
//! [`start`] initialises MPI, [`World`] communicates and finalises it. Not here: the partition of fields
//! (`gfmd-vector`) and the output of processes.
#![warn(missing_docs)]
#![warn(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)]

mod kind;
mod launcher;
mod library;
mod world;

pub use launcher::Launcher;
pub use world::{MpiError, World, start};
