//! The contacts in the file of a sweep, verified as they are read.

use std::collections::HashMap;

use gfmd_contact::{Contact, Load};
use gfmd_files::Reader;
use gfmd_measure::Summary;
use gfmd_problem::Facts;
use gfmd_record::{COLUMNS, Column, Origin, Record, StateContext};
use gfmd_sweep::{Example, Plan, Pressed};
use ndarray::Array2;

use crate::result::Comparison;
use gfmd_input::failure::Failure;

/// Returns the columns of a run: the columns of a hard wall without numbers that a sweep does not measure or that
/// differ between identical runs.
pub fn columns() -> impl Iterator<Item = &'static Column> {
    let facts = Facts::default();
    COLUMNS.iter().filter(move |column| {
        (column.present)(&facts)
            && column.origin != Origin::Grid
            && !["stiffness", "stiffness_error", "seconds"].contains(&column.name)
    })
}

/// Returns the record of a load, as in files of `contact`. A load that does not converge ends a sweep, so that all
/// loads of a sweep have converged.
pub fn record(load: &Pressed) -> Record {
    Record::of(&StateContext {
        approach: load.approach,
        effort: load.effort,
        residuals: load.residual.parts().into(),
        ..StateContext::of_summary(&Facts::default(), load.summary)
    })
}

/// Returns the load of a record.
///
/// # Errors
/// Returns an error if a number is missing or not finite.
fn pressed(record: &Record) -> serde_json::Result<Pressed> {
    let mut value = serde_json::to_value(record)?;
    let residual = serde_json::from_value(value["residual"].take())?;
    let (summary, effort) = (value.clone(), value);
    Ok(Pressed {
        summary: serde_json::from_value(summary)?,
        approach: record.number("approach"),
        residual,
        effort: serde_json::from_value(effort)?,
    })
}

/// The loads of all runs, from the table of the file; their residuals are compared with the tolerance.
///
/// # Errors
/// A file without a column of `/runs`, or with another number of rows than the plan has.
pub fn runs(reader: &Reader, plan: &Plan, comparison: &mut Comparison) -> Result<Vec<Vec<Pressed>>, Failure> {
    let column = |name: &str| -> Result<Vec<f64>, Failure> { Ok(reader.values(&format!("/runs/{name}"))?) };
    let loads = plan.config.loads.p_star.len();
    let columns = columns().map(|of| Ok((of.name, column(of.name)?))).collect::<Result<HashMap<_, _>, Failure>>()?;
    let rows = plan.runs.len() * loads;
    if let Some((name, found)) = columns.iter().find(|(_, values)| values.len() != rows) {
        let name = format!("/runs/{name}");
        return Err(Failure::refused(format!("{name} has {} values; it must have {rows}", found.len())));
    }
    let of_row = |row: usize| {
        let value = |column: &Column| columns.get(column.name).map_or(f64::NAN, |values| values[row]);
        let record: Record = Record::stored(&Facts::default(), |column| (value(column), None));
        pressed(&record).map_err(|error| Failure::refused(format!("/runs, row {row}: {error}")))
    };
    let tolerance = plan.config.solver.budget().tolerance;
    let of_run = |run: usize| (0..loads).map(|load| of_row(run * loads + load)).collect::<Result<Vec<_>, Failure>>();
    let runs = (0..plan.runs.len()).map(of_run).collect::<Result<Vec<_>, Failure>>()?;
    for (run, pressed) in runs.iter().enumerate().flat_map(|(run, loads)| loads.iter().map(move |load| (run, load))) {
        comparison.at_most(&format!("residual of run {run}"), pressed.residual.worst(), tolerance);
        let Summary { kappa, area_fraction, p_star, .. } = pressed.summary;
        comparison.number("/runs/kappa", kappa, area_fraction / p_star, 0.0);
    }
    Ok(runs)
}

/// The example, whose stored pressure must be in equilibrium with its stored heights.
///
/// # Errors
/// A file without an example, or with one that no point of the plan has or that is no contact.
pub fn example(reader: &Reader, plan: &Plan, rerun: bool, comparison: &mut Comparison) -> Result<Example, Failure> {
    if rerun {
        return Ok(Example::new(plan, &())?);
    }
    let shape = reader.shape("/example/height")?;
    let hurst = reader.number("/example", "hurst")?;
    let same = |point: &&gfmd_sweep::Point| point.grid.points()[..] == shape[..] && point.hurst == hurst;
    let missing = || Failure::refused(format!("/example/height has the shape {shape:?}; no point of the sweep has it"));
    let point = *plan.points.iter().find(same).ok_or_else(missing)?;
    let field = |name: &str| -> Result<Array2<f64>, Failure> {
        let [nx, ny] = point.grid.points();
        let values = reader.values(&format!("/example/{name}"))?;
        Array2::from_shape_vec((nx, ny), values).map_err(|error| Failure::input("/example", error))
    };
    let (heights, pressure) = (field("height")?, field("pressure")?);
    let seed = reader.number("/example", "seed")? as u64;
    let refuse = |error: gfmd_contact::Refusal| Failure::input("/example/height", error);
    let body = plan.config.body()?;
    let contact = Contact::new(&body, &point.grid, &heights).map_err(refuse)?;
    let asked = plan.config.fit.p_star * body.contact_modulus() * plan.config.surface.rms_gradient;
    let state = contact.certify(&pressure, Load::MeanPressure(asked)).map_err(refuse)?;
    comparison.at_most("/example/pressure", state.residual.worst(), plan.config.solver.budget().tolerance);
    Ok(Example { point, seed, pressure, heights })
}
