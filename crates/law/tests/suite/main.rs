//! Tests of `gfmd-law` as one program. `cargo test -p gfmd-law --test suite FILE::` runs one file.

mod in_units;
mod law;
mod properties;
mod tabulated;
