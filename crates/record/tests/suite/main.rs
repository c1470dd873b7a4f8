//! Tests of `gfmd-record` as one program; for one file: `cargo test -p gfmd-record --test suite FILE::`.

mod classes;
#[path = "../../../problem/tests/suite/parts.rs"]
mod parts;
mod python;
mod walk;
