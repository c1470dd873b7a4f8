//! The tests of `gfmd-law` as one program: those of one file by `cargo test -p gfmd-law --test suite FILE::`.

mod in_units;
mod law;
mod properties;
mod tabulated;
