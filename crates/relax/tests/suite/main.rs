//! Tests of `gfmd-relax` as one program. To run one file: `cargo test -p gfmd-relax --test suite FILE::`.

mod bounded_quadratic;
mod checkpoint;
mod damping;
mod driver;
mod fire;
mod inertia;
mod mode_damped;
mod obstacle;
mod paired;
mod properties;
mod rates;
mod reproducible;
mod stretches;
mod support;
mod trap;
