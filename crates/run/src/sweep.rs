//! The contacts in the file of a sweep, verified as they are read.

use gfmd_contact::{Contact, Effort, Load, Residual};
use gfmd_files::Reader;
use gfmd_measure::Summary;
use gfmd_sweep::{Example, Plan, Pressed};
use ndarray::Array2;

use crate::failure::Failure;
use crate::result::Comparison;

/// The loads of all runs, from the table of the file; their residuals are compared with the tolerance.
///
/// # Errors
/// A file without a column of `/runs`, or with another number of rows than the plan has.
pub fn runs(reader: &Reader, plan: &Plan, comparison: &mut Comparison) -> Result<Vec<Vec<Pressed>>, Failure> {
    let column = |name: &str| -> Result<Vec<f64>, Failure> { Ok(reader.values(&format!("/runs/{name}"))?) };
    let loads = plan.config.loads.p_star.len();
    let names = [
        "mean_pressure",
        "p_star",
        "area_fraction",
        "area_fraction_corrected",
        "kappa",
        "kappa_corrected",
        "contact_nodes",
        "boundary_links",
        "mean_gap",
        "max_pressure",
        "mean_pressure_in_contact",
        "pressure_deviation_in_contact",
        "pressure_moment_2",
        "elastic_energy",
        "displacement",
        "iterations",
        "transform_pairs",
        "residual_complementarity",
        "residual_penetration",
        "residual_negative_pressure",
        "residual_load",
    ];
    let columns = names.iter().map(|name| column(name)).collect::<Result<Vec<_>, _>>()?;
    let rows = plan.runs.len() * loads;
    if let Some((name, found)) = names.iter().zip(&columns).find(|(_, values)| values.len() != rows) {
        let name = format!("/runs/{name}");
        return Err(Failure::Input(format!("{name} has {} values; it must have {rows}", found.len())));
    }
    let at = |row: usize| {
        let mut values = columns.iter().map(|values| values[row]);
        let mut next = || values.next().unwrap_or(f64::NAN);
        let summary = Summary {
            mean_pressure: next(),
            p_star: next(),
            area_fraction: next(),
            area_fraction_corrected: next(),
            kappa: next(),
            kappa_corrected: next(),
            contact_nodes: next() as u64,
            boundary_links: next() as u64,
            mean_gap: next(),
            max_pressure: next(),
            mean_pressure_in_contact: next(),
            pressure_deviation_in_contact: next(),
            pressure_moment_2: next(),
            elastic_energy: next(),
        };
        let approach = next();
        let effort = Effort { iterations: next() as u64, transform_pairs: next() };
        let residual =
            Residual { complementarity: next(), penetration: next(), negative_pressure: next(), load: next() };
        Pressed { summary, approach, residual, effort }
    };
    let tolerance = plan.config.solver.budget().tolerance;
    let runs: Vec<Vec<Pressed>> =
        (0..plan.runs.len()).map(|run| (0..loads).map(|load| at(run * loads + load)).collect()).collect();
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
    let missing = || Failure::Input(format!("/example/height has the shape {shape:?}; no point of the sweep has it"));
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
