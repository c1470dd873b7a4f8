//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`options`] describe a problem. Command line flags, configurations and Python dictionaries fill them.
//! - [`Facts`] list the parts of a problem: a law, free boundaries, a second body, ... [`RULES`] say which parts cannot
//!   be combined, once for the program, the Python package, the documentation and the tests.
//! - [`pose`] is the only place that makes a contact from them: a [`Posed`] problem, which every solver, path and file
//!   treats as a single kind. A new kind of contact implements [`ContactKind`].
//! - [`AnyState`] is a state at rest of any kind; [`AnyState::get`] returns it as its own type.

extern crate self as gfmd_problem;

mod accuracy;
mod adhesion;
mod facts;
mod grid_error;
mod inelastic;
mod kept_strain;
mod kinds;
mod memory;
mod moduli;
pub mod options;
mod parts;
mod pose;
mod posed;
mod rules;
mod sideways;
mod unknown;
mod unusable;
mod words;
mod written;

pub use accuracy::{Accuracy, AccuracyError};
pub use adhesion::Adhesion;
pub use facts::{Friction, Lower, MovedBase, Support, WearBy};
pub use gfmd_interface::Sequence;
pub use grid_error::GridError;
pub use inelastic::Inelastic;
pub use kept_strain::KeptStrain;
pub use memory::MemoryNeed;
pub use moduli::Moduli;
pub use pose::pose;
pub use posed::{AnyState, ContactKind, NoStiffness, OfState, Posed, State};
pub use rules::{Clash, Facts, Part, RULES, Rule, rules_of, rules_of_sliding, table};
pub use unknown::{NoUnknown, Unknown};
pub use unusable::{SIZES, Unusable, check_size};
pub use words::{Spelling, Words, argument, flag, key, setting};
pub use written::Written;
