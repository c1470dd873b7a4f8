//! Tests of `gfmd-green` as one program. To run one file: `cargo test -p gfmd-green --test suite FILE::`.

mod bases;
mod grids;
mod inside;
mod plate;
mod support;
mod surface;
mod tabulated;
