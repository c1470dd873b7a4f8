//! The description of what a file holds: variables, their dimensions, attributes, origin.

/// A named dimension with its coordinates, written once per group as an HDF5 dimension scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Dimension {
    /// Name, also of the coordinate variable: `load`, `x`, `run` ...
    pub name: String,
    /// The coordinate of each entry.
    pub coordinates: Coordinates,
    /// Unit of the coordinates: `1`, `length` ...
    pub units: String,
    /// Meaning in words.
    pub long_name: String,
}

/// The coordinates along a dimension.
#[derive(Clone, Debug, PartialEq)]
pub enum Coordinates {
    /// 0, 1, 2, ... so many.
    Index(usize),
    /// Positions.
    Values(Vec<f64>),
    /// Names.
    Labels(Vec<String>),
}

impl Dimension {
    /// A dimension counted from zero.
    pub fn index(name: &str, length: usize, long_name: &str) -> Self {
        let coordinates = Coordinates::Index(length);
        Self { name: name.into(), coordinates, units: "1".into(), long_name: long_name.into() }
    }

    /// A dimension with positions.
    pub fn values(name: &str, values: Vec<f64>, units: &str, long_name: &str) -> Self {
        let coordinates = Coordinates::Values(values);
        Self { name: name.into(), coordinates, units: units.into(), long_name: long_name.into() }
    }

    /// A dimension with a name for each entry.
    pub fn labels(name: &str, labels: &[&str], long_name: &str) -> Self {
        let coordinates = Coordinates::Labels(labels.iter().map(|&label| label.into()).collect());
        Self { name: name.into(), coordinates, units: "1".into(), long_name: long_name.into() }
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        match &self.coordinates {
            Coordinates::Index(length) => *length,
            Coordinates::Values(values) => values.len(),
            Coordinates::Labels(labels) => labels.len(),
        }
    }

    /// True without entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What a variable is, apart from its values.
#[derive(Clone, Copy, Debug)]
pub struct Variable<'a> {
    /// Slowest first, as the values lie in memory; empty for a single number.
    pub dimensions: &'a [&'a Dimension],
    /// Unit, or the kind of quantity where any consistent set of units will do: `stress`, `length`, `1`.
    pub units: &'a str,
    /// Meaning in words.
    pub long_name: &'a str,
}

impl Variable<'_> {
    pub(super) fn shape(&self) -> Vec<usize> {
        self.dimensions.iter().map(|dimension| dimension.len()).collect()
    }
}

/// Where a file comes from: the attributes of its root.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Name of the program.
    pub program: String,
    /// Its version.
    pub version: String,
    /// The commit it was built from, `unknown` if it is not known.
    pub git_commit: String,
    /// The command line.
    pub command: String,
    /// Time of creation, RFC 3339.
    pub created: String,
    /// The complete resolved configuration as TOML.
    pub config: String,
    /// The machine, in words.
    pub machine: String,
    /// Number of threads.
    pub threads: usize,
}

/// A single value beside a group or variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Words.
    Text(String),
    /// A real number.
    Real(f64),
    /// A whole number.
    Integer(i64),
    /// A whole number that is not negative, such as a seed.
    Natural(u64),
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Attribute {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Attribute {
    fn from(number: f64) -> Self {
        Self::Real(number)
    }
}

impl From<u64> for Attribute {
    fn from(number: u64) -> Self {
        Self::Natural(number)
    }
}

impl From<i64> for Attribute {
    fn from(number: i64) -> Self {
        Self::Integer(number)
    }
}
