//! The columns that are measured, subject by subject.

use super::{contact, energy, flow, load, lower, patches, search, special};
use crate::column::Column;

/// The tables of the subjects, in the order in which they are printed.
pub(super) const MEASURED: &[&[Column]] = &[
    load::COLUMNS,
    contact::COLUMNS,
    energy::COLUMNS,
    search::COLUMNS,
    special::COLUMNS,
    patches::COLUMNS,
    flow::COLUMNS,
    lower::COLUMNS,
    search::BALANCE,
];
