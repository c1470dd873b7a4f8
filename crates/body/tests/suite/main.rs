//! The tests of `gfmd-body` as one program: those of one file by `cargo test -p gfmd-body --test suite FILE::`.

mod base;
mod fields;
mod uniform;
