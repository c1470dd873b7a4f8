//! The tests of `gfmd-xtask` as one program: those of one file by `cargo test -p gfmd-xtask --test suite FILE::`.

mod help;
mod reproduce;
mod verify;
