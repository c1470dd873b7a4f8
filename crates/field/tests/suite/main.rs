//! Tests of `gfmd-field` as one program; run one file with `cargo test -p gfmd-field --test suite FILE::`.

mod convolution;
mod cosines;
mod grid;
mod identities;
mod oracle;
mod prefetch;
mod ranks;
mod spline;
