//! The tests of `gfmd-dislocation` as one program: those of one file by
//! `cargo test -p gfmd-dislocation --test suite FILE::`.

mod dynamics;
mod state;
