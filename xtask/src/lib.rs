//! The commands of gfmd, as a library so that tests can call them.

pub mod archive;
pub mod fit;
