//! Developer tools of gfmd: `verify` compares the program with references, `bench-peers` with other programs,
//! `bench-rows` the time and memory of what people run with those of the solution, `accuracy` its errors of the grid
//! with finer ones; `finite` computes surfaces of finite spectra, `results` draws docs/results.md, `reproduce` the
//! figures of the thesis.

pub mod accuracy;
pub mod bench_peers;
pub mod finite;
pub mod reproduce;
pub mod results;
pub mod solved;
pub mod verify;
