//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! A [`Column`] has a name, a unit, a definition, the problems that have it, the problems in which it has no value and
//! why, and a function that computes it from a state. JSON, HDF5, tables, `check`, Python and the documentation walk
//! over [`COLUMNS`]. All of them give a reason for a missing number.

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
pub use column::{Column, Form, Head, Importance, Meaning, Number, Origin, State, Subject, Table};
pub use columns::{
    COLUMNS, FEWEST_WAVES, Punch, PunchContext, PunchFacts, SLIDING_FIELDS, Sliding, SlidingContext, SlidingFacts,
    SlidingField, Surface, SurfaceContext, SurfaceDetail, SurfaceFacts, UNRESOLVED, columns, not_calibrated, page,
};
pub use context::{Measured, NOT_SOLVED, OnFinerGrid, StateContext};
pub use digits::with_limit;
pub use json::{RecordError, by_reason, reason_for};
pub use record::{BRACKETS, ROUGH, Record, lines, reason_of, reasons};
pub use statistics::{Along, STATISTICS, Statistic, Statistics, Unmeasured, patches, statistics_of};
pub use table::{Printed, Sheet, columns_of, heads, largest, significant, size_for_unit, table_of};
