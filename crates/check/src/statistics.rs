//! Patches, distributions and spectra of the loads in a file.

use gfmd_field::Grid;
use gfmd_files::{Archive, Dimension, Reader, Variable};
use gfmd_record::{Along, STATISTICS, Statistic, Statistics};
use gfmd_unit::Units;

use crate::result::Comparison;
use gfmd_input::failure::Failure;

/// Joins the values of all loads; empty if a load has none, except for patches.
fn joined(statistic: &Statistic, loads: &[Statistics]) -> Vec<f64> {
    let of_loads: Vec<Vec<f64>> =
        loads.iter().enumerate().map(|(load, found)| (statistic.values)(found, load)).collect();
    let is_whole = statistic.along == Along::Patch || of_loads.iter().all(|values| !values.is_empty());
    if is_whole { of_loads.concat() } else { Vec::new() }
}

/// Writes the arrays of the solved loads, with numbers in these units.
///
/// # Errors
/// Returns an error if the file cannot be written.
pub fn write(archive: &mut Archive, grid: &Grid, units: &Units, loads: &[Statistics]) -> Result<(), Failure> {
    let Some(first) = loads.first() else { return Ok(()) };
    let unit = &*units.name("length");
    let load = Dimension::index("load", loads.len(), "load step");
    let patches = joined(&STATISTICS[0], loads).len();
    for statistic in STATISTICS {
        let Statistic { path, along, unit: own, meaning, .. } = *statistic;
        let values = joined(statistic, loads);
        let axis =
            |name: &str, unit: &str, meaning: &str| Dimension::values(name, first.axis(along, grid), unit, meaning);
        let axis = match along {
            Along::Patch => Dimension::index("patch", patches, "patch of any load"),
            Along::Bin => {
                let bins = first.axis(along, grid).len();
                Dimension::index("bin", bins, "bin between zero and the largest value of the load")
            }
            Along::Ring => axis("wavenumber", &format!("rad/{unit}"), "mean wavenumber of a ring"),
            Along::LagX => axis("lag_x", unit, "distance"),
            Along::LagY => axis("lag_y", unit, "distance"),
        };
        let both = [&load, &axis];
        let dimensions = if along == Along::Patch { &both[1..] } else { &both };
        if !values.is_empty() && !axis.is_empty() {
            let units = units.name(own.unwrap_or("length"));
            let variable = Variable { dimensions, units: &units, long_name: meaning };
            archive.write(path, &variable, &values)?;
        }
    }
    Ok(())
}

/// Compares the arrays of a file with the arrays of the loads.
///
/// # Errors
/// Returns an error if the file cannot be read.
pub fn compare(reader: &Reader, loads: &[Statistics], comparison: &mut Comparison) -> Result<(), Failure> {
    for statistic in STATISTICS {
        let (path, values) = (statistic.path, joined(statistic, loads));
        if reader.contains(path) {
            comparison.values(path, &reader.values::<f64>(path)?, &values, 0.0);
        } else if !values.is_empty() {
            comparison.differ(path, "it is missing".into());
        }
    }
    Ok(())
}
