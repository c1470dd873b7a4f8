//! The tests of `gfmd-surface` as one program. To run one file: `cargo test -p gfmd-surface --test suite FILE::`.

mod fill;
mod numbers;
mod pair;
mod preparation;
mod ranks;
mod real_space;
mod statistics;
mod synthesis;
