//! The tests of `gfmd-green` as one program: those of one file by `cargo test -p gfmd-green --test suite FILE::`.

mod bases;
mod grids;
mod inside;
mod plate;
mod support;
mod surface;
mod tabulated;
