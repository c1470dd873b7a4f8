//! Developer tools of gfmd: `verify` compares the program with references, `bench-peers` with other programs.

pub mod bench_peers;
pub mod verify;
