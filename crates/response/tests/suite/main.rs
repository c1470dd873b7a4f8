//! Tests of `gfmd-response` as one program; run one file with `cargo test -p gfmd-response --test suite FILE::`.

mod free_full;
mod operators;
mod scattered;
mod softened;
mod units;
