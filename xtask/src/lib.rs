//! Developer tools of gfmd. `verify` compares the program with references, `bench-peers` with other programs,
//! `bench-rows` time and memory of typical runs with the solution alone, `accuracy` grid errors with finer grids.
//! `deviations` compares estimates with solved contacts, `finite` computes surfaces of finite spectra, `results` draws
//! docs/results.md, `reproduce` the figures of the thesis.

pub mod accuracy;
pub mod bench_peers;
pub mod deviations;
pub mod finite;
pub mod reproduce;
pub mod results;
pub mod solved;
pub mod verify;
