//! Measurements of states: patches, distributions, spectra and conductance, flow through the gap, gas in it. `contact`
//! measures each load, `path` each step.

mod args;
mod conductance;
mod figures;
mod findings;
mod legends;

pub(crate) use args::MeasureArgs;
pub(crate) use conductance::Conducting;
pub(crate) use figures::{draw_flow, draw_patches};
pub(crate) use findings::{Findings, Gathered, Touching, measured, recalled};
pub(crate) use legends::legends;
