//! Tests of `gfmd-body` as one program; run one file with `cargo test -p gfmd-body --test suite FILE::`.

mod base;
mod fields;
mod uniform;
