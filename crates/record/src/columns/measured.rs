//! Measured columns by subject.

use super::{Column, contact, energy, flow, load, lower, patches, search, special};

/// Column tables of the subjects, in print order.
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
