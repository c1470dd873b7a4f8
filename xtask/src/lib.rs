//! The commands of gfmd, as a library so that tests can call them.

pub mod fit;
