//! Tests of `gfmd-problem` as one program; for one file: `cargo test -p gfmd-problem --test suite FILE::`.

mod parts;
mod walk;
