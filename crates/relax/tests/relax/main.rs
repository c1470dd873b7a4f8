//! Tests of the damped methods on small problems with known solutions.

mod checkpoint;
mod damping;
mod driver;
mod fire;
mod inertia;
mod mode_damped;
mod obstacle;
mod properties;
mod rates;
mod reproducible;
mod stretches;
mod support;
mod trap;
