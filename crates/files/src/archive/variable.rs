//! Descriptions of the contents of a file: variables, dimensions, attributes, provenance.

use crate::Warnings;

/// Named dimension with its coordinates, written once per group as an HDF5 dimension scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Dimension {
    /// Name, also of the coordinate variable: `load`, `x`, `run` ...
    pub name: String,
    /// Coordinate of each entry.
    pub coordinates: Coordinates,
    /// Unit of the coordinates: `1`, `length` ...
    pub units: String,
    /// Meaning in words.
    pub long_name: String,
}

/// Coordinates along a dimension.
#[derive(Clone, Debug, PartialEq)]
pub enum Coordinates {
    /// Indices 0, 1, 2, ...; the number is the length.
    Index(usize),
    /// Positions.
    Values(Vec<f64>),
    /// Names.
    Labels(Vec<String>),
}

impl Dimension {
    /// Creates a dimension with the indices from zero as coordinates.
    pub fn index(name: &str, length: usize, long_name: &str) -> Self {
        let coordinates = Coordinates::Index(length);
        Self { name: name.into(), coordinates, units: "1".into(), long_name: long_name.into() }
    }

    /// Creates a dimension with positions as coordinates.
    pub fn values(name: &str, values: Vec<f64>, units: &str, long_name: &str) -> Self {
        let coordinates = Coordinates::Values(values);
        Self { name: name.into(), coordinates, units: units.into(), long_name: long_name.into() }
    }

    /// Creates a dimension with names as coordinates.
    pub fn labels(name: &str, labels: &[&str], long_name: &str) -> Self {
        let coordinates = Coordinates::Labels(labels.iter().map(|&label| label.into()).collect());
        Self { name: name.into(), coordinates, units: "1".into(), long_name: long_name.into() }
    }

    /// Returns the number of entries.
    pub fn len(&self) -> usize {
        match &self.coordinates {
            Coordinates::Index(length) => *length,
            Coordinates::Values(values) => values.len(),
            Coordinates::Labels(labels) => labels.len(),
        }
    }

    /// Returns true if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Description of a variable without its values.
#[derive(Clone, Copy, Debug)]
pub struct Variable<'a> {
    /// Dimensions, slowest first, in the memory order of the values; empty for a single number.
    pub dimensions: &'a [&'a Dimension],
    /// Unit, or the kind of quantity if any consistent units are valid: `stress`, `length`, `1`.
    pub units: &'a str,
    /// Meaning in words.
    pub long_name: &'a str,
}

impl Variable<'_> {
    pub(super) fn shape(&self) -> Vec<usize> {
        self.dimensions.iter().map(|dimension| dimension.len()).collect()
    }
}

/// Provenance of a file: the attributes of its root.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Name of the program.
    pub program: String,
    /// Version of the program.
    pub version: String,
    /// Commit the program was built from, or `unknown`.
    pub git_commit: String,
    /// Command line.
    pub command: String,
    /// Time of creation, RFC 3339.
    pub created: String,
    /// Complete resolved configuration as TOML.
    pub config: String,
    /// Description of the machine.
    pub machine: String,
    /// Number of threads.
    pub threads: usize,
    /// Warnings on the result; warnings added before the file is finished are written.
    pub warnings: Warnings,
}
