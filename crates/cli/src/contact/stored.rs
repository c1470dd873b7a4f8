//! The records in the file of a contact.

use gfmd_files::Reader;
use gfmd_problem::Facts;
use gfmd_record::{Record, reason_of};

use super::Args;
use crate::failure::Failure;
use crate::result::{Configuration, Kind};

/// The configuration of the result of a contact.
///
/// # Errors
/// A file that cannot be read; a key that is none of such results, a value of another type.
pub fn configuration(reader: &Reader) -> Result<toml::Table, Failure> {
    let text = reader.text("/", "config").map_err(|error| Failure::Input(error.to_string()))?;
    Configuration::read::<Args>(Kind::Contact, &text).map(Configuration::into_table)
}

/// The facts of the configuration of a contact, whose surface may be a `line`.
///
/// # Errors
/// A configuration of another kind; a name that is not known.
pub fn facts_of(config: &str, line: bool) -> Result<Facts, Failure> {
    Ok(Configuration::read::<Args>(Kind::Contact, config)?.as_named::<Args>()?.facts(line))
}

/// The records of all loads of a file. A number that the file does not have is NaN.
///
/// # Errors
/// A file that is no result of a contact.
pub fn records(reader: &Reader) -> Result<Vec<Record>, Failure> {
    let refuse = |error: gfmd_files::FileError| Failure::Input(error.to_string());
    let config = reader.text("/", "config").map_err(refuse)?;
    let line = reader.shape("/surface/height").map_err(refuse)?.get(1) == Some(&1);
    let facts = facts_of(&config, line)?;
    let shape = reader.shape("/loads/mean_pressure").map_err(refuse)?;
    let &[count] = &shape[..] else {
        let path = reader.path().display();
        return Err(Failure::Input(format!(
            "{path}: /loads/mean_pressure has the shape {shape:?}; it must be [loads]"
        )));
    };
    let mut columns = std::collections::BTreeMap::new();
    for column in gfmd_record::columns(&facts) {
        let path = format!("/loads/{}", column.name);
        let values = if reader.contains(&path) { reader.values::<f64>(&path).map_err(refuse)? } else { Vec::new() };
        if !values.is_empty() && values.len() != count {
            let file = reader.path().display();
            return Err(Failure::Input(format!(
                "{file}: {path} has the shape [{}]; it must be [{count}]",
                values.len()
            )));
        }
        columns.insert(column.name, (values, reader.text(&path, "undefined").ok()));
    }
    let record = |row: usize| {
        Record::stored(&facts, |column| {
            let (values, reasons) = &columns[column.name];
            let value = values.get(row).copied().unwrap_or(f64::NAN);
            (value, reasons.as_ref().filter(|_| value.is_nan()).and_then(|reasons| reason_of(reasons, row)))
        })
    };
    Ok((0..count).map(record).collect())
}
