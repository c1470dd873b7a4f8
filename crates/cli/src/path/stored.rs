//! Report of the path in a file.

use gfmd_check::result::{Configuration, ResultKind, stored_problem};
use gfmd_check::stored::records_of;
use gfmd_contact::Load;
use gfmd_files::Reader;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_record::Record;
use gfmd_run::convergence::NotConverged;

use super::report::Report;
use super::{Args, PathInput, path_input, report_of};

/// Reads the report of the path in a file. Nothing is solved: all numbers come from the file or follow from its
/// numbers. A number missing in the file is NaN.
///
/// # Errors
/// Returns an error if the file is not the result of a path, or if its problem cannot be read from it.
pub fn stored(reader: &Reader, session: &Session) -> Result<Report, Failure> {
    let text = reader.text("/", "config").map_err(|error| Failure::refused(error.to_string()))?;
    let config = Configuration::read::<Args>(ResultKind::Path, &text)?;
    let args: Args = stored_problem(reader, &config)?;
    let mut input = path_input(&args, session)?;
    input.prepared.take_units(reader);
    let PathInput { prepared, places, drives, .. } = &input;
    let contact = prepared.pose(&args.source, &prepared.law)?;
    let mut records = records_of(reader, &prepared.facts)?;
    let is_computed = |record: &Record| record.number("mean_pressure").is_finite();
    records.truncate(records.iter().take_while(|record| is_computed(record)).count());
    // A path ends early where its surfaces part under a load, or with a step that did not converge.
    let converged = records.last().is_some_and(|last| last.number("converged") == 1.0);
    let is_loaded = |step: &usize| matches!(drives[*step].load, Load::MeanPressure(_));
    let parted_at = Some(records.len()).filter(|step| *step < drives.len() && converged && is_loaded(step));
    let report = report_of(&args, prepared, contact.surface(), (records, places))?;
    Ok(Report { parted_at, not_converged: NotConverged::read(reader), ..report })
}
