//! Developer tools of gfmd: `verify` compares the program with references, `bench-peers` with other programs, `results` draws
//! docs/results.md.

pub mod bench_peers;
pub mod results;
pub mod verify;
