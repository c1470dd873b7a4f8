//! The configuration of a result, read as data: the keys that describe its problem, each with its type, and no others.
//!
//! A result may come from a stranger. No key names a file that is written, and no file is opened that a key names, but
//! the input of a result of `body`, which [`Configuration::file`] returns and whose name the result has a second time,
//! with a checksum.

use clap::Args;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::Kind;
use crate::failure::Failure;
use gfmd_problem::options::flags::{self, keys, line};
use gfmd_problem::options::given::ArrayOption;

/// Keys that say how a run was shown and kept, and change no number of a result. They are left out.
const SHOWN: [&str; 10] =
    ["out", "plots", "vtk", "resume", "checkpoint", "compare", "draw", "levels", "deepest", "scan"];

/// Keys of files or parts of them, whose values stand in the result, from which they are taken; of `hardness` a text
/// alone.
pub const FILES: [&str; 9] = [
    "surface",
    "channel",
    "second_surface",
    "base_displacement",
    "base_traction",
    "lower_surface",
    "hardness",
    "mask",
    "traction",
];

/// The longest text of a configuration.
const LONGEST: usize = 1 << 24;

/// The name of a configuration in messages.
const NAME: &str = "config of the file";

/// The keys of the results of a command with these flags.
fn keys_of<A: Args>() -> Vec<String> {
    let mut keys = keys::<A>();
    keys.retain(|key| !SHOWN.contains(&key.as_str()));
    keys
}

/// The configuration of a result, of keys and values that the results of its kind have.
#[derive(Clone, Debug)]
pub struct Configuration {
    table: Table,
}

impl Configuration {
    /// Reads the configuration of a result of a `kind`, of a command with these flags.
    ///
    /// # Errors
    /// A text that is not TOML; a key that results of this kind do not have; a value of another type.
    pub fn read<A: Args + DeserializeOwned>(kind: Kind, text: &str) -> Result<Self, Failure> {
        let refuse = |reason: String| Failure::input(NAME, reason);
        if text.len() > LONGEST {
            return Err(refuse(format!("it has {} bytes; it must have at most {LONGEST}", text.len())));
        }
        let mut table: Table = text.parse().map_err(|error: toml::de::Error| refuse(line(error.message())))?;
        let keys = keys_of::<A>();
        table.retain(|key, _| !SHOWN.contains(&key));
        if let Some(key) = table.keys().find(|key| !keys.contains(key)) {
            return Err(refuse(format!("{} is no key of a result of {}", flags::quoted(key), kind.name())));
        }
        // Files of earlier versions have them.
        flags::leave_out_idle::<A>(&mut table);
        let config = Self { table };
        config.as_named::<A>()?;
        Ok(config)
    }

    /// The keys and values.
    pub fn into_table(self) -> Table {
        self.table
    }

    /// True if the configuration has this key.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// True if the value of this key names a file.
    pub(crate) fn names_a_file(&self, key: &str) -> bool {
        FILES.contains(&key) && self.table.get(key).is_some_and(Value::is_str)
    }

    /// The option that was an array in memory, if there is one: the configuration does not have its values.
    pub fn array(&self) -> Option<&str> {
        let is_array = |key: &&str| self.table.get(*key).and_then(Value::as_str).is_some_and(ArrayOption::is_in_memory);
        FILES.into_iter().find(is_array)
    }

    /// The input of a result of `body`.
    pub fn file(&self) -> Option<&str> {
        self.table.get("surface").and_then(Value::as_str)
    }

    /// The problem as it was named, to be described. The files in it are those that a stranger names: none may be
    /// opened.
    ///
    /// # Errors
    /// A value of another type, which is named.
    pub fn as_named<A: DeserializeOwned>(&self) -> Result<A, Failure> {
        flags::of_table(self.table.clone()).map_err(|reason| Failure::input(NAME, reason))
    }

    /// The problem, or a part of it, without the keys in `except`, and without those that name files, in place of which
    /// there are those that are `stored` in the result.
    ///
    /// # Errors
    /// The errors of [`as_named`](Self::as_named).
    pub fn problem<A: DeserializeOwned>(&self, except: &[String], stored: Table) -> Result<A, Failure> {
        let own = |key: &String| !except.contains(key) && !self.names_a_file(key);
        let table = self.table.iter().filter(|(key, _)| own(key)).map(|(key, value)| (key.clone(), value.clone()));
        flags::of_table(table.chain(stored).collect()).map_err(|reason| Failure::input(NAME, reason))
    }

    /// All flags of the run, to be shown.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        for (key, value) in &self.table {
            let flag = format!("--{}", key.replace('_', "-"));
            match value {
                Value::Boolean(given) => words.extend(given.then_some(flag)),
                Value::Array(lists) if lists.iter().any(Value::is_array) => {
                    let between = match key.as_str() {
                        "param" => "=",
                        "prony" | "law_table" | "compliance" => ":",
                        _ => ",",
                    };
                    words.extend(
                        lists
                            .iter()
                            .filter_map(Value::as_array)
                            .map(|list| format!("{flag}={}", joined(list, between))),
                    );
                }
                Value::Array(values) => words.push(format!("{flag}={}", joined(values, ","))),
                value => words.push(format!("{flag}={}", text(value))),
            }
        }
        words
    }
}

fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), Into::into)
}

fn joined(values: &[Value], between: &str) -> String {
    values.iter().map(text).collect::<Vec<_>>().join(between)
}
