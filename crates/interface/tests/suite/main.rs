//! Tests of `gfmd-interface` as one program. `cargo test -p gfmd-interface --test suite FILE::` runs one file.

mod adhesion;
mod checkpoint;
mod cohesive;
mod cost;
mod free;
mod friction;
mod kinks;
mod path;
mod plastic;
mod small_loads;
