//! Tests of `gfmd-topography` as one program. `cargo test -p gfmd-topography --test suite FILE::` runs the tests of one
//! file. Hostile files are read by a separate program, which counts its memory.

mod dialects;
mod formats;
mod instruments;
#[path = "../harness/made.rs"]
mod made;
mod readers;
mod text;
