//! Patches, distributions and spectra of the states in a file: of loads, or of waypoints of a path.

use gfmd_files::{Archive, Dimension, Reader, Variable};
use gfmd_problem::Facts;
use gfmd_record::{Along, Statistic, Statistics, statistics_of};
use gfmd_run::series::{Prepared, SeriesLayout};

use crate::result::Comparison;
use gfmd_input::failure::Failure;

/// Joins the values of all states; empty if a state has none, except for patches.
fn joined(statistic: &Statistic, states: &[Statistics]) -> Vec<f64> {
    let of_states: Vec<Vec<f64>> =
        states.iter().enumerate().map(|(number, found)| (statistic.values)(found, number)).collect();
    let is_whole = statistic.along == Along::Patch || of_states.iter().all(|values| !values.is_empty());
    if is_whole { of_states.concat() } else { Vec::new() }
}

/// Writes the arrays of the solved states of a problem.
///
/// # Errors
/// Returns an error if the file cannot be written.
pub fn write(archive: &mut Archive, prepared: &Prepared, states: &[Statistics]) -> Result<(), Failure> {
    let Some(first) = states.first() else { return Ok(()) };
    let (units, grid) = (prepared.surface.units(), &prepared.surface.grid);
    let unit = &*units.name("length");
    let (name, meaning) = SeriesLayout::of(&prepared.facts).stored;
    let state = Dimension::index(name, states.len(), meaning);
    let [of_patch, of_bin] =
        [format!("patch of any {name}"), format!("bin between zero and the largest value of the {name}")];
    let patches = states.iter().map(|found| found.axis(Along::Patch, grid).len()).sum();
    for statistic in statistics_of(&prepared.facts) {
        let Statistic { path, along, unit: own, meaning, .. } = *statistic;
        let values = joined(statistic, states);
        let axis =
            |name: &str, unit: &str, meaning: &str| Dimension::values(name, first.axis(along, grid), unit, meaning);
        let axis = match along {
            Along::Patch => Dimension::index("patch", patches, &of_patch),
            Along::Bin => Dimension::index("bin", first.axis(along, grid).len(), &of_bin),
            Along::Ring => axis("wavenumber", &format!("rad/{unit}"), "mean wavenumber of a ring"),
            Along::LagX => axis("lag_x", unit, "distance"),
            Along::LagY => axis("lag_y", unit, "distance"),
        };
        let both = [&state, &axis];
        let dimensions = if along == Along::Patch { &both[1..] } else { &both };
        if !values.is_empty() && !axis.is_empty() {
            let units = units.name(own.unwrap_or("length"));
            let variable = Variable { dimensions, units: &units, long_name: meaning };
            archive.write(path, &variable, &values)?;
        }
    }
    Ok(())
}

/// Compares the arrays of a file of a problem with the arrays of its states.
///
/// # Errors
/// Returns an error if the file cannot be read.
pub fn compare(
    reader: &Reader,
    facts: &Facts,
    states: &[Statistics],
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    for statistic in statistics_of(facts) {
        let (path, values) = (statistic.path, joined(statistic, states));
        if reader.contains(path) {
            comparison.values(path, &reader.values::<f64>(path)?, &values, 0.0);
        } else if !values.is_empty() {
            comparison.differ(path, "it is missing".into());
        }
    }
    Ok(())
}
