//! The tests of `gfmd-interface` as one program: those of one file by
//! `cargo test -p gfmd-interface --test suite FILE::`.

mod adhesion;
mod checkpoint;
mod cohesive;
mod cost;
mod free;
mod friction;
mod path;
mod plastic;
mod small_loads;
