//! Measurements of states: patches, distributions, spectra and conductance, flow through the gap, gas in it. `contact`
//! measures each load, `path` each step.

mod args;
mod conductance;
mod findings;
mod legends;

pub(crate) use args::MeasureArgs;
pub(crate) use conductance::Conducting;
pub(crate) use findings::{Findings, Gathered, Touching, measured, recalled};
pub(crate) use legends::legends;
