//! The configuration of a sweep as TOML.

use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

use gfmd_sweep::Config;
use gfmd_unit::{Quantity, Units};
use serde::Deserialize;
use toml::{Table, Value};

use gfmd_input::failure::Failure;

/// The configuration of a sweep as it is given.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Configured {
    /// Its contents.
    Contents(Table),
    /// A file.
    File(PathBuf),
}

impl FromStr for Configured {
    type Err = Infallible;

    /// Reads the name of a file; a text of several lines is the configuration itself.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text.contains('\n').then(|| text.parse()) {
            Some(Ok(table)) => Self::Contents(table),
            _ => Self::File(text.into()),
        })
    }
}

impl Configured {
    /// Reads the configuration as a table, with its name in messages.
    ///
    /// # Errors
    /// A file that cannot be read, or is not TOML.
    pub(crate) fn table(&self) -> Result<(String, Table), Failure> {
        match self {
            Self::Contents(table) => Ok(("config".into(), table.clone())),
            Self::File(path) => {
                let name = path.display().to_string();
                let text = gfmd_files::input::text(path).map_err(|error| Failure::input(&name, error))?;
                let table = text.parse().map_err(|error: toml::de::Error| {
                    let before = &text[..error.span().map_or(0, |span| span.start.min(text.len()))];
                    let line = 1 + before.matches('\n').count();
                    Failure::input(format!("{name}, line {line}"), error.message().replace('\n', ", "))
                })?;
                Ok((name, table))
            }
        }
    }

    /// Reads the configuration; missing fields come from the preset `default`.
    ///
    /// # Errors
    /// A file that cannot be read, or is not TOML; an unknown or mistyped field.
    pub(super) fn read(&self) -> Result<Config, Failure> {
        match self {
            Self::Contents(table) => {
                parsed("config", &toml::to_string(table).map_err(|error| Failure::input("config", error))?)
            }
            Self::File(path) => {
                let name = path.display().to_string();
                parsed(&name, &gfmd_files::input::text(path).map_err(|error| Failure::input(&name, error))?)
            }
        }
    }
}

/// The moduli of a body, by their fields: numbers, and the first ones of lists. Only their ratios matter.
const MODULI: [&str; 4] = ["young", "base_young", "layers", "second_body"];

fn parsed(name: &str, text: &str) -> Result<Config, Failure> {
    if let Ok(mut table) = text.parse::<Table>()
        && bare(name, &mut table)?
    {
        // This text has other lines than the file.
        let text = toml::to_string(&table).map_err(|error| Failure::input(name, error))?;
        return of_text(&text, |_| name.to_owned());
    }
    of_text(text, |before| format!("{name}, line {}", 1 + before.matches('\n').count()))
}

/// The configuration in a text; `place` names the place behind the part of a text before an error.
fn of_text(text: &str, place: impl Fn(&str) -> String) -> Result<Config, Failure> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let before = &text[..error.span().map_or(0, |span| span.start.min(text.len()))];
        let reason = error.message().replace('\n', ", ");
        Failure::input(place(before), field(before).map_or(reason.clone(), |field| format!("{field}: {reason}")))
    })
}

/// Puts moduli in Pa in place of those with a unit; true if there are some.
///
/// # Errors
/// A quantity with a unit that is no modulus.
fn bare(name: &str, config: &mut Table) -> Result<bool, Failure> {
    let mut found = false;
    for (group, fields) in config {
        let Value::Table(fields) = fields else { continue };
        for (key, value) in fields {
            let field = format!("{group}.{key}");
            found |= bare_in(name, &field, value, group == "body" && MODULI.contains(&key.as_str()))?;
        }
    }
    Ok(found)
}

/// [`bare`] for the value of a field, or an entry of it.
fn bare_in(name: &str, field: &str, value: &mut Value, is_modulus: bool) -> Result<bool, Failure> {
    match value {
        Value::String(text) => {
            let refuse = |error: String| Failure::input(format!("{name}: {field}"), format!("{text:?}: {error}"));
            let quantity = match Quantity::parse(text) {
                Ok(Some(quantity)) => quantity,
                Err(error) if is_modulus => return Err(refuse(error.to_string())),
                _ => return Ok(false),
            };
            if !is_modulus {
                let reason = "a sweep has no unit of length: its cell has length 1, body heights are relative to it, \
                              and loads and surfaces are ratios; only moduli may have a unit";
                return Err(Failure::input(format!("{name}: {field} is {text:?}"), reason));
            }
            let units = Units::new(Some("m"), Some(Units::PASCAL));
            let pascals = units.value(&quantity, "stress").map_err(|error| refuse(error.to_string()))?;
            *value = Value::Float(pascals);
            Ok(true)
        }
        Value::Array(entries) => {
            // The modulus comes first; the entries of `layers` are lists.
            let mut found = false;
            for (index, entry) in entries.iter_mut().enumerate() {
                let is_modulus = is_modulus && (index == 0 || entry.is_array());
                found |= bare_in(name, field, entry, is_modulus)?;
            }
            Ok(found)
        }
        _ => Ok(false),
    }
}

/// The dotted name of the field whose value begins where `before` ends.
fn field(before: &str) -> Option<String> {
    let (rest, line) = before.rsplit_once('\n').unwrap_or(("", before));
    let key = line.trim_end().strip_suffix('=')?.trim();
    let table = rest.lines().rev().find_map(|line| line.trim().strip_prefix('[')?.split(']').next());
    Some(table.map_or(key.into(), |table| format!("{}.{key}", table.trim())))
}

/// Writes the configuration as TOML, so that the run can be repeated from it.
///
/// # Errors
/// None for values that were read from TOML.
pub(super) fn text(config: &Config) -> Result<String, Failure> {
    toml::to_string(config).map_err(|error| Failure::computation(error.to_string()))
}
