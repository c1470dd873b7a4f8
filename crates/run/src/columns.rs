//! Columns of records in files.

use gfmd_files::{Archive, Dimension, Variable};
use gfmd_record::{Record, Subject, columns, reasons};
use gfmd_unit::Units;

use gfmd_input::failure::Failure;

/// Writes the columns of a problem into a group, in the units of the problem: `count` rows, NaN beyond the given
/// records, with the reasons of numbers without a value. A row has a name, in singular and plural.
///
/// # Errors
/// Returns an error if the file cannot be written.
pub fn write_columns<S: Subject>(
    archive: &mut Archive,
    (group, rows, name): (&str, &Dimension, [&str; 2]),
    (facts, units): (&S::Facts, &Units),
    records: &[Record<S>],
    count: usize,
) -> Result<(), Failure> {
    for column in columns::<S>(facts).filter(|column| (column.in_file)(facts)) {
        let number = |row: usize| records.get(row).map_or(f64::NAN, |record| record.number(column.name));
        let values: Vec<f64> = (0..count).map(number).collect();
        let path = format!("{group}/{}", column.name);
        let units = units.name(column.unit);
        let variable = Variable { dimensions: &[rows], units: &units, long_name: column.meaning(facts) };
        archive.write(&path, &variable, &values)?;
        if let Some(reason) = reasons(records, column.name, name) {
            archive.attribute(&path, "undefined", &*reason)?;
        }
    }
    Ok(())
}
