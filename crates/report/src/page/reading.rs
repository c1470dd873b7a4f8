//! Reads the parts of a file for its page: columns by name, the configuration, fields of the expected shape.

use std::collections::HashMap;

use gfmd_field::Grid;
use gfmd_files::Reader;
use gfmd_record::{
    COLUMNS, Column, Record, Subject, Table as RecordTable, columns, heads, largest, size_for_unit, with_limit,
};
use gfmd_unit::{DisplayUnit, Units};
use maud::{Markup, html};

use super::said::{plain, unit_for};
use super::write::{number, powers, text};
use crate::figures::{Face, SceneFields};
use gfmd_input::failure::Failure;
use gfmd_input::units::units_of_result;

/// Values of a column and their readable unit; `None` for values in the unit of the file.
pub(crate) type InUnit = (Vec<f64>, Option<DisplayUnit>);

/// Reads the configuration of a file as a table; empty if it cannot be read.
pub(crate) fn config(reader: &Reader) -> toml::Table {
    reader.text("/", "config").ok().and_then(|config| config.parse().ok()).unwrap_or_default()
}

/// Columns of one group, all of the same length.
pub(crate) struct Stored<'a> {
    reader: &'a Reader,
    group: &'a str,
    length: usize,
}

impl<'a> Stored<'a> {
    /// Opens the columns of `group`. The column `first` must exist and sets their length.
    ///
    /// # Errors
    /// Returns an error if the file has no column `first`.
    pub(crate) fn new(reader: &'a Reader, group: &'a str, first: &str) -> Result<Self, Failure> {
        let values = reader.values::<f64>(&format!("{group}/{first}"));
        let values = values.map_err(|error| Failure::refused(error.to_string()))?;
        Ok(Self { reader, group, length: values.len() })
    }

    /// Returns the number of rows.
    pub(crate) fn len(&self) -> usize {
        self.length
    }

    /// Returns the column `name`; NaN in every row if the file has no such column of this length.
    pub(crate) fn column(&self, name: &str) -> Vec<f64> {
        let values = self.reader.values(&format!("{}/{name}", self.group)).unwrap_or_default();
        if values.len() == self.length { values } else { vec![f64::NAN; self.length] }
    }

    /// Returns the rows as records of a problem.
    pub(crate) fn records<S: Subject>(&self, facts: &S::Facts) -> Vec<Record<S>> {
        let columns: HashMap<&str, Vec<f64>> =
            columns::<S>(facts).map(|column| (column.name, self.column(column.name))).collect();
        let of = |row: usize| Record::stored(facts, |column: &Column<S>| (columns[column.name][row], None));
        (0..self.length).map(of).collect()
    }

    /// Returns a column of a table in a readable unit, if the unit of the file is known.
    pub(crate) fn read<S: Subject>(&self, column: &Column<S>, table: RecordTable) -> InUnit {
        let mut values = self.column(column.name);
        let beside = heads::<S>(table).filter(|(other, _)| other.unit == column.unit);
        let beside = || beside.map(|(other, _)| largest(self.column(other.name)));
        let unit = self.units().shown(column.unit, size_for_unit(largest(values.iter().copied()), beside));
        if let Some(unit) = &unit {
            values.iter_mut().for_each(|value| *value *= unit.factor);
        }
        (values, unit)
    }

    /// Returns the units of the numbers, as far as they are known.
    pub(crate) fn units(&self) -> Units {
        units_of_result(self.reader).unwrap_or_default()
    }

    /// Formats a number of a row, multiplied by `times`, with its unit, as in the tables. A column with a limit on fine
    /// grids shows its certain digits, or two digits and `~` if the limit is unknown; other columns show five digits.
    pub(crate) fn said(&self, name: &str, row: usize, times: f64) -> Markup {
        self.said_beside(name, &[], row, times)
    }

    /// Formats a number like [`said`](Self::said); a zero has the unit of the columns beside it.
    fn said_beside(&self, name: &str, beside: &[&str], row: usize, times: f64) -> Markup {
        let [value, limit, error] = ["", "_limit", "_limit_error"].map(|end| self.column(&format!("{name}{end}"))[row]);
        let kind = COLUMNS.iter().find(|column| column.name == name).map_or("1", |column| column.unit);
        let beside = || beside.iter().map(|other| self.column(other)[row]);
        let (factor, unit) = unit_for(size_for_unit(value.abs(), beside), kind, &self.units());
        let [value, limit, error] = [value, limit, error].map(|number| times * factor * number);
        let limited = self.has(&format!("{name}_limit"));
        html! { @if limited { (powers(&with_limit(value, limit, error))) } @else { (number(value)) } (unit) }
    }

    /// Returns a line of the headline for each leak and conductance that was asked for, at a row.
    pub(crate) fn joint(&self, row: usize) -> Markup {
        let all = [
            ("leak_x", "leak_y", "leaks along x"),
            ("leak_y", "leak_x", "leaks along y"),
            ("contact_conductance", "gas_conductance", "conducted by the contacts"),
            ("gas_conductance", "contact_conductance", "conducted by the gas in the gap"),
        ];
        let asked = all.into_iter().filter(|(name, ..)| self.has(name));
        html! {
            @for (name, beside, meaning) in asked {
                p.headline {
                    @if self.column(name)[row].is_finite() {
                        (self.said_beside(name, &[beside], row, 1.0)) " " span { (meaning) }
                    }
                    @else { "No value of " (name.replace('_', " ")) " " span { (self.attribute(name, "undefined")) } }
                }
            }
        }
    }

    /// Returns true if the file has the column.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.reader.contains(&format!("{}/{name}", self.group))
    }

    /// Returns the largest residual `name` of the computed rows, i.e. rows with a mean pressure; NaN if one of them is
    /// NaN.
    pub(crate) fn worst(&self, name: &str) -> f64 {
        let rows = self.column("mean_pressure").into_iter().zip(self.column(name));
        let computed = rows.filter(|(pressure, _)| pressure.is_finite()).map(|(_, residual)| residual);
        // `f64::max` ignores NaN.
        computed.reduce(|a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }).unwrap_or(f64::NAN)
    }

    /// Returns the sum of a column without NaN values; NaN if the file has none.
    pub(crate) fn sum(&self, name: &str) -> f64 {
        self.column(name).into_iter().filter(|value| !value.is_nan()).reduce(|a, b| a + b).unwrap_or(f64::NAN)
    }

    /// Returns the names of columns that begin with `prefix`, sorted.
    pub(crate) fn names(&self, prefix: &str) -> Vec<String> {
        self.reader.names(self.group).into_iter().filter(|name| name.starts_with(prefix)).collect()
    }

    /// Returns the unit of a column as stored in the file; empty for a number without unit.
    pub(crate) fn unit(&self, name: &str) -> String {
        let unit = self.attribute(name, "units");
        if unit == "1" { String::new() } else { plain(&unit) }
    }

    /// Returns the definition of a column as stored in the file.
    pub(crate) fn definition(&self, name: &str) -> String {
        self.attribute(name, "long_name")
    }

    fn attribute(&self, name: &str, attribute: &str) -> String {
        text(&self.reader.text(&format!("{}/{name}", self.group), attribute).unwrap_or_default())
    }
}

/// Names of the fields of one face of the body.
pub(crate) struct FaceFields {
    pub(crate) pressure: &'static str,
    pub(crate) gap: &'static str,
    pub(crate) displacement: &'static str,
    pub(crate) depth: &'static str,
    pub(crate) face: Face,
}

impl FaceFields {
    pub(crate) const UPPER: Self = Self {
        pressure: "pressure",
        gap: "gap",
        displacement: "displacement_z",
        depth: "plastic_depth",
        face: Face::Upper,
    };
    pub(crate) const LOWER: Self = Self {
        pressure: "lower_pressure",
        gap: "lower_gap",
        displacement: "lower_displacement_z",
        depth: "lower_plastic_depth",
        face: Face::Lower,
    };
}

/// Surface of a contact or path.
pub(crate) struct StoredSurface {
    pub(crate) grid: Grid,
    pub(crate) heights: Vec<f64>,
    /// Unit of lengths.
    pub(crate) unit: String,
    /// Units of the numbers.
    pub(crate) units: Units,
    pub(crate) rms_gradient: f64,
    pub(crate) description: String,
}

impl StoredSurface {
    /// Reads `/surface`.
    ///
    /// # Errors
    /// Returns an error if the file has no heights or lengths.
    pub(crate) fn read(reader: &Reader) -> Result<Self, String> {
        let path = "/surface/height";
        let heights: Vec<f64> = reader.values(path).map_err(|error| error.to_string())?;
        let shape = reader.shape(path).map_err(|error| error.to_string())?;
        let &[nx, ny] = &shape[..] else { return Err(format!("{path} has {} axes; it must have two", shape.len())) };
        let length = |name| reader.number("/surface", name).map_err(|error| error.to_string());
        let x = length("size_x")?;
        let grid = if ny == 1 { Grid::line(nx, x) } else { Grid::new([nx, ny], [x, length("size_y")?]) };
        Ok(Self {
            grid: grid.map_err(|error| error.to_string())?,
            heights,
            unit: text(&reader.text(path, "units").unwrap_or_else(|_| "size".into())),
            units: units_of_result(reader).unwrap_or_default(),
            rms_gradient: reader.number("/surface", "rms_gradient").unwrap_or(f64::NAN),
            description: text(&reader.text("/surface", "description").unwrap_or_default()),
        })
    }

    /// Returns the fields of state `index` for the figures of a face. Gap and displacement may be missing. The file
    /// lacks the pressure of a wall behind an attraction; points with a closed gap therefore also count as contact.
    ///
    /// # Errors
    /// Returns the errors of [`field`](Self::field) for the pressure.
    pub(crate) fn shown(&self, reader: &Reader, index: usize, fields: &FaceFields) -> Result<SceneFields, String> {
        let pressure = self.field(reader, fields.pressure, index)?;
        let gap = self.field(reader, fields.gap, index).unwrap_or_default();
        let mut repulsion: Vec<f64> = pressure.iter().map(|p| p.max(0.0)).collect();
        let closed = repulsion.iter_mut().zip(&gap).filter(|(_, gap)| **gap <= 0.0);
        closed.for_each(|(repulsion, _)| *repulsion = repulsion.max(f64::MIN_POSITIVE));
        let mut level = self.field(reader, fields.displacement, index).unwrap_or_default();
        // Both faces are pressed into the slab, whose inside lies below the upper face and above the lower one.
        let inside = if fields.face == Face::Upper { -1.0 } else { 1.0 };
        let depth = self.field(reader, fields.depth, index).unwrap_or_default();
        level.iter_mut().zip(depth).for_each(|(level, depth)| *level += inside * depth);
        Ok(SceneFields { pressure, repulsion, gap, level })
    }

    /// Reads the field `name` of state `index`.
    ///
    /// # Errors
    /// Returns an error if the field is missing, not on the grid of the surface, or not computed.
    pub(crate) fn field(&self, reader: &Reader, name: &str, index: usize) -> Result<Vec<f64>, String> {
        let path = format!("/fields/{name}");
        let shape = reader.shape(&path).map_err(|_| format!("the file has no field {name}"))?;
        // Compare the shape before reading that much data.
        if shape.get(1..) != Some(&self.grid.points()[..]) {
            return Err(format!(
                "{path} has the shape {shape:?}; its last two lengths must be the lengths of the surface"
            ));
        }
        let values: Vec<f64> = reader.slab(&path, index).map_err(|error| error.to_string())?;
        let computed = values.iter().all(|value| value.is_finite());
        if computed { Ok(values) } else { Err(format!("{path} of state {index} was not computed")) }
    }
}
