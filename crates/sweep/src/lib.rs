//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! | step | contents |
//! |---|---|
//! | [`Config`] | the values that a user chooses; presets by name |
//! | [`Plan`] | points (discretisations), and runs (realisations) of each point, with their seeds |
//! | [`run()`] | the loads of every run, [`Pressed`]; [`run_shard`] computes a shard, [`run_one`] a single run |
//! | [`Analysis`] | kappa of every point and load; extrapolations, also one axis at a time ([`Protocol`]) |
//! | [`Study`] | all of these steps, in one call |
//!
//! Start at [`Study`]. The bits of a result depend on the configuration alone: not on the number of threads, nor on a
//! continuation from kept runs ([`Keep`]).

mod analysis;
mod composition;
mod config;
mod error;
mod estimator;
mod heights;
mod plan;
mod preset;
mod pressed;
mod protocol;
mod run;
mod shard;
mod study;
mod target;
mod words;

pub use analysis::{Alternative, Analysis, Area, Extrapolation, Form, Key, Source};
pub use config::{
    Alpha, BodyConfig, Config, Control, Design, Estimator, FitConfig, LoadsConfig, LongWavesConfig, Method,
    PointsConfig, SolverConfig, StatisticsConfig, SurfaceConfig,
};
pub use error::{Place, SweepError};
pub use plan::{Plan, Point, Run};
pub use preset::Preset;
pub use pressed::Pressed;
pub use protocol::{Arm, Curve, Estimated, Protocol};
pub use run::{Example, Keep, run, run_one, run_shard};
pub use shard::{Shard, ShardError, divide};
pub use study::Study;
pub use target::SweepPrecision;
