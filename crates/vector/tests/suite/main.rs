//! The tests of `gfmd-vector` as one program: those of one file by `cargo test -p gfmd-vector --test suite FILE::`.

mod share;
