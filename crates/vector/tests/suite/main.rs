//! Tests of `gfmd-vector` as one program; run one file with `cargo test -p gfmd-vector --test suite FILE::`.

mod share;
