//! Legends of the tables of the measurements.

use gfmd_record::{Record, Table};

/// Legend of the flow and the leak.
const FLOW: &str = "flow: mean flux under a pressure gradient, divided by the flux through a uniform gap \
                               equal to the mean gap; leak: volume per time through the cell, with --viscosity \
                               1mPa*s and --pressure-drop 1bar";

/// Legends of columns of the patches. The first one converts to device units.
const PATCHES: [(&str, &str); 2] = [
    (
        "conductance",
        "conductance: per area, times the sum of both resistivities; contact conductance: per area, with \
         --conductivity K1,K2",
    ),
    (
        "gas_conductance",
        "gas conductance: per area of the gas in the gap, radiation left out; points in contact contribute nothing",
    ),
];

/// Returns the legends below a table of `records`.
pub(crate) fn legends(table: Table, records: &[Record]) -> Vec<&'static str> {
    let has = |name: &str| records.iter().any(|record| record.get(name).is_some());
    match table {
        Table::Patches => PATCHES.into_iter().filter(|(name, _)| has(name)).map(|(_, legend)| legend).collect(),
        Table::Flow => vec![FLOW],
        _ => Vec::new(),
    }
}
