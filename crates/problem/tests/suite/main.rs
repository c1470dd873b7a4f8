//! The tests of `gfmd-problem` as one program: those of one file by `cargo test -p gfmd-problem --test suite FILE::`.

mod parts;
mod walk;
