//! Options of a problem: groups of named values that command line flags, configuration tables and Python dictionaries
//! fill alike. A field is an option: its doc comment is the help, its name the key, its clap attribute has flag and
//! default, and `#[option(kinds = ..)]` the kind of its numbers ([`Options`]).

mod body;
mod choice;
mod compliance;
mod dynamics;
pub mod flags;
mod generator;
pub mod given;
mod law;
mod plasticity;
mod prony;
pub mod quantities;
mod sliding;
mod solver;
pub mod text;
pub mod values;

pub use body::{BodyArgs, HEIGHTS, Layer, OtherArgs, RecordedBodyArgs, height, height_if, parse_height, sides};
pub use choice::{Choice, named, named_if, parse_choice, parse_choice_but};
pub use compliance::{ComplianceArgs, Row, check_wavenumbers};
pub use dynamics::{DampedBy, DynamicsArgs};
pub use generator::{GeneratorArgs, LARGEST_SEED, Method};
pub use law::LawArgs;
pub use plasticity::{GivenCells, Plasticity, PlasticityArgs, Yielding};
pub use prony::{PronyArgs, Relaxation};
pub use quantities::{Kinds, KindsByKey};
pub use sliding::{FrictionArgs, WearArgs};
pub use solver::{SearchArgs, SolverArgs};

pub use gfmd_derive::Options;

/// A group of options, derived from its fields (`gfmd-derive`).
pub trait Options: Default {
    /// Calls `see` with the key and the kinds of each option whose numbers may have a unit.
    fn kinds(see: &mut dyn FnMut(&'static str, Kinds));

    /// Takes the values of options that are arrays in memory.
    fn take_arrays(&mut self, arrays: &mut given::Arrays);
}
