//! Records in the file of a series.

use std::collections::BTreeMap;

use gfmd_files::Reader;
use gfmd_problem::Facts;
use gfmd_record::{Record, Subject, columns, reason_of};

use gfmd_input::failure::Failure;
use gfmd_run::series::SeriesLayout;

/// Reads the records of all parts of a contact's file. Missing numbers are NaN.
///
/// # Errors
/// Returns an error if the file is not a result of a problem with these facts.
pub fn records_of(reader: &Reader, facts: &Facts) -> Result<Vec<Record>, Failure> {
    let SeriesLayout { group, plural, .. } = SeriesLayout::of(facts);
    records_in(reader, (group, plural), facts)
}

/// Reads the records of a group of datasets with one value for each row; `plural` names the rows. Missing numbers are
/// NaN.
///
/// # Errors
/// Returns an error if the datasets are missing or of unequal length.
pub fn records_in<S: Subject>(
    reader: &Reader,
    (group, plural): (&str, &str),
    facts: &S::Facts,
) -> Result<Vec<Record<S>>, Failure> {
    let refuse = |error: gfmd_files::FileError| Failure::refused(error.to_string());
    let shape = reader.shape(&format!("{group}/mean_pressure")).map_err(refuse)?;
    let &[count] = &shape[..] else {
        let path = reader.path().display();
        return Err(Failure::refused(format!(
            "{path}: {group}/mean_pressure has the shape {shape:?}; it must be [{plural}]"
        )));
    };
    let mut found = BTreeMap::new();
    for column in columns::<S>(facts) {
        let path = format!("{group}/{}", column.name);
        let values = if reader.contains(&path) { reader.values::<f64>(&path).map_err(refuse)? } else { Vec::new() };
        if !values.is_empty() && values.len() != count {
            let file = reader.path().display();
            return Err(Failure::refused(format!(
                "{file}: {path} has the shape [{}]; it must be [{count}]",
                values.len()
            )));
        }
        found.insert(column.name, (values, reader.text(&path, "undefined").ok()));
    }
    let record = |row: usize| {
        Record::stored(facts, |column| {
            let (values, reasons) = &found[column.name];
            let value = values.get(row).copied().unwrap_or(f64::NAN);
            (value, reasons.as_ref().filter(|_| value.is_nan()).and_then(|reasons| reason_of(reasons, row)))
        })
    };
    Ok((0..count).map(record).collect())
}
