//! The tests of `gfmd-mixed` as one program: those of one file by `cargo test -p gfmd-mixed --test suite FILE::`.

mod properties;
mod punch;
