//! The tests of `gfmd-flow` as one program: those of one file by `cargo test -p gfmd-flow --test suite FILE::`.

mod flow;
