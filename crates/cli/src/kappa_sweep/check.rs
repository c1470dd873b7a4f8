//! The check of the file of a sweep.

use std::path::Path;

use gfmd_files::{Output, Reader};
use gfmd_problem::key;
use gfmd_record::Origin;
use gfmd_sweep::{Analysis, Config, Plan, Pressed, Study, run_one};

use super::{Report, file};
use gfmd_check::result::{Against, Comparison, Folder, Pair, ResultKind};
use gfmd_check::sweep::{columns, example, record, runs};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;

/// Reads the loads of all runs from the file of an earlier sweep. Its configuration may differ from `plan` only in the
/// fit.
///
/// # Errors
/// Returns an error for another configuration, a damaged file, or loads that miss their tolerance.
pub(super) fn earlier(path: &Path, plan: &Plan) -> Result<Vec<Vec<Pressed>>, Failure> {
    let refuse =
        |reason: &dyn std::fmt::Display| Failure::input(key("runs_of"), format!("{}: {reason}", path.display()));
    let reader = Reader::open(path).map_err(|error| Failure::input(key("runs_of"), error))?;
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

/// Reads the report of the sweep in a file. No contact is solved: points and fits follow from the runs in the file.
///
/// # Errors
/// Returns an error if the file is not a result of a sweep, or for runs that do not fulfil their certificates.
pub fn report_of(reader: &Reader) -> Result<Report, Failure> {
    let path = reader.path();
    let refuse = |reason: &dyn std::fmt::Display| Failure::refused(format!("{}: {reason}", path.display()));
    let text = reader.text("/", "config").map_err(|error| Failure::refused(error.to_string()))?;
    let config: Config = toml::from_str(&text).map_err(|error| refuse(&error.message()))?;
    let (plan, mut comparison) = (Plan::new(config)?, Comparison::default());
    let runs = runs(reader, &plan, &mut comparison)?;
    if comparison.counts().2 > 0 {
        return Err(refuse(&"numbers of its runs do not fulfil their certificates; gfmd check names them"));
    }
    let analysis = Analysis::new(&plan, &runs)?;
    let seconds = reader.number("/", "seconds").unwrap_or(f64::NAN);
    Ok(Report::new(&plan, &analysis, (path.to_path_buf(), Vec::new()), (seconds, 0)))
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
    Pair { kind: ResultKind::KappaSweep, first: reader, second: &second, against: Against::Values }
        .compare(comparison)?;
    if rerun {
        again(&study, sample, comparison, session)?;
    }
    Ok(())
}

/// Computes `sample` runs again, spread evenly, or all.
fn again(study: &Study, sample: Option<u64>, comparison: &mut Comparison, session: &Session) -> Result<(), Failure> {
    let all = study.plan.runs.len();
    let count = sample.map_or(all, |sample| (sample as usize).min(all));
    for run in (0..count).map(|k| k * all / count) {
        if session.is_interrupted() {
            return Err(Failure::interrupted(format!("interrupted before run {run}")));
        }
        let loads = run_one(&study.plan, run, &())?;
        for (stored, found) in study.runs[run].iter().zip(&loads) {
            let [stored, found] = [stored, found].map(record);
            for column in columns() {
                let floor = if column.origin == Origin::Residual { 1e-3 } else { 0.0 };
                let [stored, found] = [&stored, &found].map(|record| record.number(column.name));
                comparison.number(&format!("/runs/{} of run {run}", column.name), stored, found, floor);
            }
        }
    }
    Ok(())
}
