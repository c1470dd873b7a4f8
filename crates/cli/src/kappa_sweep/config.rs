//! The configuration of a sweep as TOML.

use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

use gfmd_sweep::Config;
use serde::Deserialize;

use gfmd_run::failure::Failure;

/// The configuration of a sweep as it is given.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Configured {
    /// Its contents.
    Contents(toml::Table),
    /// A file.
    File(PathBuf),
}

impl FromStr for Configured {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self::File(text.into()))
    }
}

impl Configured {
    /// Reads the configuration; missing fields are those of the preset `default`.
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

fn parsed(name: &str, text: &str) -> Result<Config, Failure> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let before = &text[..error.span().map_or(0, |span| span.start.min(text.len()))];
        let place = format!("{name}, line {}", 1 + before.matches('\n').count());
        let reason = error.message().replace('\n', ", ");
        Failure::input(&place, field(before).map_or(reason.clone(), |field| format!("{field}: {reason}")))
    })
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
    toml::to_string(config).map_err(|error| Failure::Computation(error.to_string()))
}
