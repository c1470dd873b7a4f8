//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! | step                                              | function                                    |
//! |---------------------------------------------------|---------------------------------------------|
//! | part of a scan                                    | [`crop`]                                    |
//! | points that stand out, line defects               | [`despike`], [`descar`]                     |
//! | offsets and drift of rows                         | [`level_rows`], [`level_columns`]           |
//! | form                                              | [`remove_polynomial`]                       |
//! | S and L filters (the rest of an S filter)         | [`smooth`]                                  |
//! | fewer points                                      | [`resample`]                                |
//! | a profile with uneven spacing                     | [`even`]                                    |
//!
//! Heights are `Array2<f64>` of shape `[nx, ny]`, index `[x, y]`; a profile is `[n, 1]`. Rows are lines along x, the
//! fast axis of most instruments, one for each y. All results have the same bits for any number of threads.
#![warn(missing_docs)]

mod defects;
mod error;
mod filter;
mod form;
mod rows;
mod size;

#[cfg(test)]
mod tests;

pub use defects::{Scars, Spikes, descar, despike};
pub use error::PrepareError;
pub use filter::{Edges, Filter, Kernel, Smoothed, equivalent_cut_off, smooth};
pub use form::{MOST_DEGREE, remove_polynomial};
pub use rows::{Levelled, Levelling, level_columns, level_rows};
pub use size::{Cropped, Resampled, crop, even, resample};
