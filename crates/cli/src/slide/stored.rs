//! Report of the states in a file of steady sliding.

use gfmd_check::result::{Configuration, ResultKind, stored_problem};
use gfmd_check::stored::records_in;
use gfmd_files::Reader;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_record::{Record, Sliding};

use super::{Args, Report, SlideInput};

/// Reads the report of the states in a file. Nothing is solved: all numbers come from the file or follow from its
/// numbers. A number missing in the file is NaN.
///
/// # Errors
/// Returns an error if the file is not a result of steady sliding, or if its problem cannot be read from it.
pub fn stored(reader: &Reader, session: &Session) -> Result<Report, Failure> {
    let text = reader.text("/", "config").map_err(|error| Failure::refused(error.to_string()))?;
    let config = Configuration::read::<Args>(ResultKind::Slide, &text)?;
    let args: Args = stored_problem(reader, &config)?;
    let mut input = SlideInput::new(&args, session)?;
    input.prepared.take_units(reader);
    let mut records = records_in(reader, ("/states", "states"), &input.facts())?;
    let is_computed = |record: &Record<Sliding>| record.number("mean_pressure").is_finite();
    records.truncate(records.iter().take_while(|record| is_computed(record)).count());
    Ok(Report { states: records, ..input.report(&args)? })
}
