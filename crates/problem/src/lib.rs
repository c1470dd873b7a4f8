//! Contact problem of any kind, from its description to its states at rest.
//!
//! - [`options`] describe a problem. Command line flags, configurations and Python dictionaries fill them.
//! - [`Facts`] list the parts of a problem: a law, free boundaries, a second body, ... [`RULES`] say which parts cannot
//!   be combined, once for the program, the Python package, the documentation and the tests.
//! - [`pose`] is the only place that makes a contact from them: a [`Posed`] problem, which every solver, path and file
//!   treats as a single kind. A new kind of contact implements [`ContactKind`].
//! - [`AnyState`] is a state at rest of any kind; [`AnyState::get`] returns it as its own type.
//!
//! ```
//! use gfmd_contact::{Equilibrium, Fields, Load};
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//! use gfmd_problem::{Facts, Given, pose};
//! use ndarray::Array2;
//!
//! let grid = Grid::square(32, 1.0)?;
//! let wave = |i: usize| (std::f64::consts::TAU * i as f64 / 32.0).cos();
//! let heights = Array2::from_shape_fn((32, 32), |(i, j)| 0.01 * wave(i) * wave(j));
//! let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
//!
//! let facts = Facts { finite_slope: true, ..Facts::default() };
//! facts.check()?;
//! let problem = pose(&Given::new(facts, &body, &grid, &heights))?;
//! let state = problem.press(Load::MeanPressure(0.01)).solve()?;
//! assert!(state.worst() <= 1e-8);
//!
//! let clash = Facts { hardness: true, ..facts }.check().unwrap_err();
//! assert_eq!(clash.to_string(), "--hardness is given; it must be left out with --finite-slope (not implemented)");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

extern crate self as gfmd_problem;

mod accuracy;
mod adhesion;
mod facts;
mod grid_error;
mod kinds;
mod memory;
mod moduli;
pub mod options;
mod parts;
mod pose;
mod posed;
mod rules;
mod unknown;
mod unusable;
mod words;

pub use accuracy::{Accuracy, AccuracyError};
pub use adhesion::Adhesion;
pub use facts::{Facts, Friction, Lower, MovedBase, Support, Task};
pub use grid_error::GridError;
pub use memory::MemoryNeed;
pub use moduli::Moduli;
pub use pose::{Given, pose};
pub use posed::{AnyState, ContactKind, NoStiffness, Posed, State};
pub use rules::{Clash, Part, RULES, Rule, rules_of, rules_of_wear, table};
pub use unknown::{NoUnknown, Unknown};
pub use unusable::{SIZES, Unusable, check_size};
pub use words::{Spelling, Words, argument, flag, key, setting};
