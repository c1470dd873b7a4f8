//! Options of a problem: groups of named values that command line flags, configuration tables and Python dictionaries
//! fill alike. A field is an option; its doc comment is the help, its name the key.

mod body;
mod choice;
mod compliance;
mod dynamics;
pub mod flags;
mod generator;
pub mod given;
mod law;
mod prony;
pub mod quantities;
mod solver;
pub mod values;

pub use body::{BodyArgs, HEIGHTS, Layer, OtherArgs, RecordedBodyArgs, height, height_if, parse_height, sides};
pub use choice::{Choice, named, named_if, parse_choice};
pub use compliance::{ComplianceArgs, Row, check_wavenumbers};
pub use dynamics::{DampedBy, DynamicsArgs};
pub use generator::{GeneratorArgs, LARGEST_SEED, Method};
pub use law::LawArgs;
pub use prony::{PronyArgs, Relaxation};
pub use solver::SolverArgs;
