//! Numbers of a contact at rest, declared once.
//!
//! A [`Column`] has a name, a unit, a definition, the problems that have it, the problems in which it has no value and
//! why, and a function that computes it from a state. JSON, HDF5, tables, `check`, Python and the documentation walk
//! over [`COLUMNS`]. All of them give a reason for a missing number.
//!
//! ```
//! use gfmd_contact::{Equilibrium, Load};
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//! use gfmd_problem::{Facts, Given, pose};
//! use gfmd_record::{At, Record};
//! use ndarray::Array2;
//!
//! let grid = Grid::square(32, 1.0)?;
//! let wave = |i: usize| (std::f64::consts::TAU * i as f64 / 32.0).cos();
//! let heights = Array2::from_shape_fn((32, 32), |(i, j)| 0.01 * wave(i) * wave(j));
//! let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
//! let facts = Facts { finite_slope: true, ..Facts::default() };
//! let problem = pose(&Given::new(facts, &body, &grid, &heights))?;
//! let state = problem.press(Load::MeanPressure(0.01)).solve()?;
//!
//! let record = Record::of(&At::new(&facts, &state, &problem, &grid, 1e-8));
//! assert!((record.number("mean_pressure") / 0.01 - 1.0).abs() < 1e-8);
//! assert!(record.number("stiffness").is_nan());
//! let why = record.undefined().find(|(name, _)| *name == "stiffness").unwrap().1;
//! assert!(why.starts_with("not computed with finite slopes"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arrays;
mod cell;
mod column;
mod columns;
mod context;
mod digits;
mod json;
mod record;
mod statistics;
mod table;
mod when;

pub use arrays::{ARRAYS, Array, arrays, repulsion};
pub use cell::Cell;
pub use column::{Column, Form, Head, Meaning, Number, Origin, State, Subject, Table};
pub use columns::{
    COLUMNS, FEWEST_WAVES, Punch, PunchContext, PunchFacts, SLIDING_FIELDS, Sliding, SlidingContext, SlidingFacts,
    SlidingField, Surface, SurfaceContext, SurfaceFacts, UNRESOLVED, columns, not_calibrated, page,
};
pub use context::{Measured, NOT_SOLVED, OnFinerGrid, StateContext};
pub use digits::with_limit;
pub use json::{RecordError, by_reason, reason_for};
pub use record::{ROUGH, Record, lines, reason_of, reasons};
pub use statistics::{Along, STATISTICS, Statistic, Statistics, Unmeasured, patches};
pub use table::{aligned, heads, readable, significant, table_of};
