//! Tests of `gfmd-mixed` as one program. One file runs with `cargo test -p gfmd-mixed --test suite FILE::`.

mod flat_punch;
mod properties;
mod punch;
