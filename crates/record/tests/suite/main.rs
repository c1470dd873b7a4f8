//! The tests of `gfmd-record` as one program: those of one file by `cargo test -p gfmd-record --test suite FILE::`.

mod classes;
#[path = "../../../problem/tests/suite/parts.rs"]
mod parts;
mod python;
mod walk;
