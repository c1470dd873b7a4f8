//! Records in a contact file.

use gfmd_files::Reader;
use gfmd_problem::Facts;
use gfmd_record::Record;

use super::Args;
use gfmd_check::result::{Configuration, ResultKind};
use gfmd_check::stored::records_of;
use gfmd_input::failure::Failure;

/// Reads the configuration of a contact result.
///
/// # Errors
/// Returns an error if the file cannot be read, a key does not belong to such results, or a value has another type.
pub fn configuration(reader: &Reader) -> Result<toml::Table, Failure> {
    let text = reader.text("/", "config").map_err(|error| Failure::refused(error.to_string()))?;
    Configuration::read::<Args>(ResultKind::Contact, &text).map(Configuration::into_table)
}

/// Reads the facts of the contact in a file, and the records of all its loads. A number missing in the file is NaN.
///
/// # Errors
/// Returns an error if the file is not a contact result.
pub fn records(reader: &Reader) -> Result<(Facts, Vec<Record>), Failure> {
    let refuse = |error: gfmd_files::FileError| Failure::refused(error.to_string());
    let config = reader.text("/", "config").map_err(refuse)?;
    let line = reader.shape("/surface/height").map_err(refuse)?.get(1) == Some(&1);
    let args = Configuration::read::<Args>(ResultKind::Contact, &config)?.as_named::<Args>()?;
    let facts = args.asked()?.facts(args.series(), line);
    Ok((facts, records_of(reader, &facts)?))
}
