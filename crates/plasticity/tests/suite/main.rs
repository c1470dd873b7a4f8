//! Tests of `gfmd-plasticity` as one program. `cargo test -p gfmd-plasticity --test suite FILE::` runs one file.

mod limits;
mod ranks;
mod reference;
mod step;
