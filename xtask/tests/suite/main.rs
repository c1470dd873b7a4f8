//! The tests of `gfmd-xtask` as one program. To run one file: `cargo test -p gfmd-xtask --test suite FILE::`.

mod help;
mod reproduce;
mod verify;
