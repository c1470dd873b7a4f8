//! Developer tools of gfmd: `verify` compares the program with references, `bench-peers` with other programs, `results` draws
//! docs/results.md, `reproduce` the figures of the source.

pub mod accuracy;
pub mod bench_peers;
pub mod reproduce;
pub mod results;
pub mod verify;
