//! The check of the file of a sweep.

use std::path::Path;

use gfmd_contact::{Contact, Effort, Load, Residual};
use gfmd_files::{Output, Reader};
use gfmd_measure::Summary;
use gfmd_record::Origin;
use gfmd_sweep::{Analysis, Config, Example, Plan, Pressed, Study, run_one};
use ndarray::Array2;

use super::file;
use gfmd_run::failure::Failure;
use gfmd_run::result::{Against, Comparison, Folder, Kind, Pair};
use gfmd_run::session::Session;

/// The loads of all runs in the file of an earlier sweep, whose configuration may differ from that of `plan` in the fit only.
///
/// # Errors
/// Another configuration, a damaged file, loads that do not fulfil their certificates.
pub(super) fn earlier(path: &Path, plan: &Plan) -> Result<Vec<Vec<Pressed>>, Failure> {
    let refuse = |reason: &dyn std::fmt::Display| Failure::input("--runs-of", format!("{}: {reason}", path.display()));
    let reader = Reader::open(path).map_err(|error| Failure::input("--runs-of", error))?;
    if reader.is_intact().unwrap_or(Some(false)) == Some(false) {
        return Err(refuse(&"it is damaged, or was changed; gfmd check says where"));
    }
    let text = reader.text("/", "config").map_err(|error| refuse(&error))?;
    let config: Config = toml::from_str(&text).map_err(|error| refuse(&error.message()))?;
    let same = Config { fit: plan.config.fit.clone(), ..config };
    if same != plan.config {
        return Err(refuse(&"its configuration differs; it may differ in [fit] only"));
    }
    let mut comparison = Comparison::default();
    let runs = runs(&reader, plan, &mut comparison)?;
    match comparison.counts().2 {
        0 => Ok(runs),
        count => Err(refuse(&format!("{count} of its numbers do not fulfil their certificates"))),
    }
}

/// Recomputes the points and fits of a sweep from its runs, certifies its example, and computes runs again if asked to.
pub(crate) fn check(
    reader: &Reader,
    config: &str,
    rerun: bool,
    sample: Option<u64>,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    let config: Config =
        toml::from_str(config).map_err(|error| Failure::input("config of the file", error.message()))?;
    let plan = Plan::new(config)?;
    let runs = runs(reader, &plan, comparison)?;
    let analysis = Analysis::new(&plan, &runs)?;
    let example = example(reader, &plan, rerun, comparison)?;
    let study = Study { plan, runs, analysis, example };
    let folder = Folder::new()?;
    let output = Output::claim(folder.file())?;
    let path = file::write(&output, &study, &session.provenance(String::new()), f64::NAN)?;
    let second = Reader::open(path)?;
    Pair { kind: Kind::KappaSweep, first: reader, second: &second, against: Against::Values }.compare(comparison)?;
    if rerun {
        again(&study, sample, comparison, session)?;
    }
    Ok(())
}

/// The loads of all runs, from the table of the file.
pub(super) fn runs(reader: &Reader, plan: &Plan, comparison: &mut Comparison) -> Result<Vec<Vec<Pressed>>, Failure> {
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
pub(super) fn example(
    reader: &Reader,
    plan: &Plan,
    rerun: bool,
    comparison: &mut Comparison,
) -> Result<Example, Failure> {
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

/// Computes `sample` runs again, spread evenly, or all.
fn again(study: &Study, sample: Option<u64>, comparison: &mut Comparison, session: &Session) -> Result<(), Failure> {
    let all = study.plan.runs.len();
    let count = sample.map_or(all, |sample| (sample as usize).min(all));
    for run in (0..count).map(|k| k * all / count) {
        if session.is_interrupted() {
            return Err(Failure::Interrupted(format!("interrupted before run {run}")));
        }
        let loads = run_one(&study.plan, run, &())?;
        for (stored, found) in study.runs[run].iter().zip(&loads) {
            let [stored, found] = [stored, found].map(file::record);
            for column in file::scalars() {
                let floor = if column.origin == Origin::Residual { 1e-3 } else { 0.0 };
                let [stored, found] = [&stored, &found].map(|record| record.number(column.name));
                comparison.number(&format!("/runs/{} of run {run}", column.name), stored, found, floor);
            }
        }
    }
    Ok(())
}
