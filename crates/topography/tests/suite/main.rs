//! The tests of `gfmd-topography` as one program: those of one file by
//! `cargo test -p gfmd-topography --test suite FILE::`. Hostile files are read by a program of their own, whose memory
//! is counted.

mod dialects;
mod formats;
mod instruments;
#[path = "../harness/made.rs"]
mod made;
mod text;
