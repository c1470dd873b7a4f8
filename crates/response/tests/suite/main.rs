//! The tests of `gfmd-response` as one program: those of one file by `cargo test -p gfmd-response --test suite FILE::`.

mod free_full;
mod operators;
mod scattered;
mod softened;
mod units;
