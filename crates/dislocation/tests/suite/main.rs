//! The tests of `gfmd-dislocation` as one program. To run one file:
//! `cargo test -p gfmd-dislocation --test suite FILE::`.

mod dynamics;
mod state;
