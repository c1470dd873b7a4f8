//! Values of options that are arrays: in a file that the option names, or in memory.
//!
//! A problem is a table of texts and numbers. A caller of the commands as a library gives its arrays beside the table,
//! by the keys of their options, and nothing is written to a file.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use ndarray::ArrayD;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::Table;

/// The value of an option that is an array.
#[derive(Clone, Debug, PartialEq)]
pub enum ArrayOption {
    /// A file, by its name: FILE.npy or FILE.h5:/dataset, and what else the option reads.
    File(String),
    /// An array in memory.
    Array(Arc<ArrayD<f64>>),
    /// A load of a contact in memory.
    Load(Arc<StoredLoad>),
}

/// A load of a contact, as a file of results has it.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredLoad {
    /// The configuration.
    pub config: Table,
    /// The fields `[x, y]`, and the numbers of the load, by their names.
    pub values: BTreeMap<String, ArrayD<f64>>,
}

/// The arrays of a problem by the keys of their options.
pub type Arrays = BTreeMap<String, ArrayOption>;

/// The text of an array in a configuration.
const ARRAY: &str = "array";

/// The text of a contact in a configuration.
const CONTACT: &str = "contact";

impl ArrayOption {
    /// Returns the name of the file.
    pub fn file(&self) -> Option<&str> {
        if let Self::File(name) = self { Some(name) } else { None }
    }

    /// Returns true for a text in a configuration that stands for an array, or a contact, in memory.
    pub fn is_in_memory(text: &str) -> bool {
        [ARRAY, CONTACT].contains(&text)
    }
}

impl FromStr for ArrayOption {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self::File(text.into()))
    }
}

impl fmt::Display for ArrayOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::File(name) => name,
            Self::Array(_) => ARRAY,
            Self::Load(_) => CONTACT,
        })
    }
}

impl Serialize for ArrayOption {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Reads the name of a file. An array in memory is given beside the table ([`Options`](super::Options)).
impl<'de> Deserialize<'de> for ArrayOption {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(Self::File)
    }
}
