//! The commands of gfmd, as a library so that tests can call them. One file per command: flags in, one function, a
//! report out that prints itself as a table or as JSON (docs/interface.md).

pub mod bench_peers;
pub mod body;
pub mod contact;
pub mod damping;
pub mod elastic;
pub mod equilibrium;
pub mod failure;
pub mod figures;
pub mod generator;
pub mod green;
pub mod json;
pub mod kappa_sweep;
pub mod law;
pub mod load;
pub mod path;
pub mod progress;
pub mod punch;
pub mod session;
pub mod source;
pub mod surface;
pub mod verify;
