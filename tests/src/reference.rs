use std::fs::File;
use std::path::{Path, PathBuf};

use gfmd_green::{Complex64, GreenError, Material};
use ndarray::{Array, Dimension};
use ndarray_npy::ReadNpyExt;
use serde_json::Value;

use crate::ValidationError;

/// Folder with the reference files.
#[derive(Clone, Debug)]
pub struct Reference {
    folder: PathBuf,
}

impl Default for Reference {
    /// Returns `data/reference` of this source tree.
    fn default() -> Self {
        Self { folder: Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/reference") }
    }
}

impl Reference {
    /// Takes another folder with files of the same names.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// Returns the path of the file `name`.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Reads a file as JSON.
    ///
    /// # Errors
    /// A file that is missing or is not JSON.
    pub fn json(&self, name: &str) -> Result<Value, ValidationError> {
        let text = std::fs::read_to_string(self.path(name)).map_err(|error| self.refuse(name, error))?;
        serde_json::from_str(&text).map_err(|error| self.refuse(name, error))
    }

    /// Reads a NumPy array of doubles.
    ///
    /// # Errors
    /// A file that is missing or has other contents.
    pub fn array<D: Dimension>(&self, name: &str) -> Result<Array<f64, D>, ValidationError> {
        let file = File::open(self.path(name)).map_err(|error| self.refuse(name, error))?;
        Array::read_npy(file).map_err(|error| self.refuse(name, error))
    }

    /// Returns the rows of a JSON file with `columns` and `rows`.
    pub(crate) fn table(&self, name: &str) -> Result<Vec<Row>, ValidationError> {
        let json = self.json(name)?;
        let rows = |columns: &Value, rows: &Value| -> Option<Vec<Row>> {
            let name_of = |column: &Value| column.as_str().or(column["name"].as_str()).map(str::to_owned);
            let columns: Vec<String> = columns.as_array()?.iter().map(name_of).collect::<Option<_>>()?;
            let row = |row: &Value| -> Option<Row> {
                let values = row.as_array()?;
                // Booleans count as one and zero.
                let number = |value: &Value| value.as_f64().or(value.as_bool().map(f64::from)).unwrap_or(f64::NAN);
                let numbers = columns.iter().cloned().zip(values.iter().map(number)).collect();
                let name = values.first().and_then(Value::as_str).unwrap_or_default().to_owned();
                (values.len() == columns.len()).then_some(Row { name, numbers })
            };
            rows.as_array()?.iter().map(row).collect()
        };
        rows(&json["columns"], &json["rows"]).ok_or_else(|| self.refuse(name, "no columns and rows"))
    }

    fn refuse(&self, name: &str, reason: impl ToString) -> ValidationError {
        ValidationError::Reference { file: self.path(name).display().to_string(), reason: reason.to_string() }
    }
}

/// Row of a table: values by the names of their columns, NaN where the file has no number.
pub(crate) struct Row {
    /// Text in the first column; empty if it is a number.
    pub(crate) name: String,
    numbers: Vec<(String, f64)>,
}

impl Row {
    pub(crate) fn get(&self, column: &str) -> f64 {
        self.numbers.iter().find(|(name, _)| name == column).map_or(f64::NAN, |(_, value)| *value)
    }

    pub(crate) fn complex(&self, column: &str) -> Complex64 {
        Complex64::new(self.get(&format!("Re_{column}")), self.get(&format!("Im_{column}")))
    }

    /// Returns the material from the columns E and nu.
    pub(crate) fn material(&self) -> Result<Material, GreenError> {
        Material::from_young(self.get("E"), self.get("nu"))
    }
}
