//! The tests of `gfmd-sweep` as one program: those of one file by `cargo test -p gfmd-sweep --test suite FILE::`.

mod protocol;
mod study;
