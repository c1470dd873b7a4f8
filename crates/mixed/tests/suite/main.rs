//! The tests of `gfmd-mixed` as one program: those of one file by `cargo test -p gfmd-mixed --test suite FILE::`.

mod flat_punch;
mod properties;
mod punch;
