//! The tests of `gfmd-field` as one program: those of one file by `cargo test -p gfmd-field --test suite FILE::`.

mod identities;
mod oracle;
mod ranks;
