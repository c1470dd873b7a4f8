//! The tests of `gfmd-tests` as one program. To run one file: `cargo test -p gfmd-tests --test suite FILE::`.

mod agreement;
mod checks;
mod circles;
mod english;
mod lines;
mod space;
mod transforms;
mod update_matrix;
mod warm_start;
