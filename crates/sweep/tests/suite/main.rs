//! Tests of `gfmd-sweep` as one program; for one file: `cargo test -p gfmd-sweep --test suite FILE::`.

mod protocol;
mod study;
