//! Legends of the tables of the measurements.

use gfmd_record::{Record, Table};

/// Legends of columns, and what stands in their place without these.
const FLOW: [(&str, &str, &str); 2] = [
    (
        "flow_xx",
        "flow: mean flux under a pressure gradient, divided by the flux through a uniform gap equal to the mean gap",
        "",
    ),
    (
        "leak_x",
        "leak: volume per time through the cell",
        "--viscosity 1mPa*s and --pressure-drop 1bar add the leak, the volume per time through the cell",
    ),
];

/// Legends of columns of the patches, and what stands in their place without these. The first one converts to device
/// units.
const PATCHES: [(&str, &str, &str); 3] = [
    ("conductance", "conductance: per area, times the sum of both resistivities", ""),
    (
        "contact_conductance",
        "contact conductance: per area through the contacts",
        "--conductivity K1,K2 adds the contact conductance, per area",
    ),
    (
        "gas_conductance",
        "gas conductance: per area of the gas in the gap, radiation left out; points in contact contribute nothing",
        "",
    ),
];

/// Returns the legends below a table of `records`.
pub(crate) fn legends(table: Table, records: &[Record]) -> Vec<&'static str> {
    let has = |name: &str| records.iter().any(|record| record.get(name).is_some());
    let of = |legends: &'static [(&str, &'static str, &'static str)]| {
        let words = legends.iter().map(|(name, legend, instead)| if has(name) { *legend } else { *instead });
        words.filter(|words| !words.is_empty()).collect()
    };
    match table {
        Table::Patches => of(&PATCHES),
        Table::Flow => of(&FLOW),
        _ => Vec::new(),
    }
}
