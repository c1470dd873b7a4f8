//! Tests of `gfmd-flow` as one program; run one file with `cargo test -p gfmd-flow --test suite FILE::`.

mod flow;
