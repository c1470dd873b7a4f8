//! Configuration of a result, read as data: only keys that describe its problem, each with its type.
//!
//! A result may come from a stranger. No key names a file that is written, and no file that a key names is opened. The
//! exception is the input of a `body` result ([`Configuration::file`]); the result has its name a second time, with a
//! checksum.

use clap::Args;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::ResultKind;
use gfmd_input::failure::Failure;
use gfmd_problem::options::flags::{self, keys, line};
use gfmd_problem::options::given::ArrayOption;

/// Keys that affect how a run was shown and kept, but no number of a result. They are left out.
const SHOWN: [&str; 12] = [
    "out",
    "plots",
    "vtk",
    "export_law",
    "export_law_format",
    "resume",
    "checkpoint",
    "compare",
    "draw",
    "levels",
    "deepest",
    "scan",
];

/// Keys of files or parts of files (`hardness` only as a text). Their values are stored in the result and taken from
/// it.
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

/// Longest text of a configuration.
const LONGEST: usize = 1 << 24;

/// Name of a configuration in messages.
const NAME: &str = "config of the file";

/// Returns the keys in results of a command with these flags.
fn keys_of<A: Args>() -> Vec<String> {
    let mut keys = keys::<A>();
    keys.retain(|key| !SHOWN.contains(&key.as_str()));
    keys
}

/// Configuration of a result, with only the keys and values that results of its kind have.
#[derive(Clone, Debug)]
pub struct Configuration {
    table: Table,
}

impl Configuration {
    /// Reads the configuration of a result of this `kind`, from a command with these flags.
    ///
    /// # Errors
    /// Returns an error if the text is not TOML, or for a key or a type that results of this kind do not have.
    pub fn read<A: Args + DeserializeOwned>(kind: ResultKind, text: &str) -> Result<Self, Failure> {
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
        // Files of earlier versions have idle defaults.
        flags::leave_out_idle::<A>(&mut table);
        let config = Self { table };
        config.as_named::<A>()?;
        Ok(config)
    }

    /// Returns the keys and values.
    pub fn into_table(self) -> Table {
        self.table
    }

    /// Returns true if the configuration has this key.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Returns true if the value of this key names a file.
    pub(crate) fn names_a_file(&self, key: &str) -> bool {
        FILES.contains(&key) && self.table.get(key).is_some_and(Value::is_str)
    }

    /// Returns the option that was an array in memory, if there is one; the configuration does not have its values.
    pub fn array(&self) -> Option<&str> {
        let is_array = |key: &&str| self.table.get(*key).and_then(Value::as_str).is_some_and(ArrayOption::is_in_memory);
        FILES.into_iter().find(is_array)
    }

    /// Returns the input of a `body` result.
    pub fn file(&self) -> Option<&str> {
        self.table.get("surface").and_then(Value::as_str)
    }

    /// Returns the problem as it was named, for descriptions only. A stranger chose its files: none of them may be
    /// opened.
    ///
    /// # Errors
    /// Returns an error that names a value of another type.
    pub fn as_named<A: DeserializeOwned>(&self) -> Result<A, Failure> {
        flags::of_table(self.table.clone()).map_err(|reason| Failure::input(NAME, reason))
    }

    /// Returns the problem, or a part of it, without the keys in `except`. Entries that are `stored` in the result
    /// replace keys that name files.
    ///
    /// # Errors
    /// Fails like [`as_named`](Self::as_named).
    pub fn problem<A: DeserializeOwned>(&self, except: &[String], stored: Table) -> Result<A, Failure> {
        let own = |key: &String| !except.contains(key) && !self.names_a_file(key);
        let table = self.table.iter().filter(|(key, _)| own(key)).map(|(key, value)| (key.clone(), value.clone()));
        flags::of_table(table.chain(stored).collect()).map_err(|reason| Failure::input(NAME, reason))
    }

    /// Returns all flags of the run, for display.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        for (key, value) in &self.table {
            let flag = format!("--{}", key.replace('_', "-"));
            match value {
                Value::Boolean(given) => words.extend(given.then_some(flag)),
                Value::Array(lists) if lists.iter().any(Value::is_array) => {
                    let between = match key.as_str() {
                        "param" => "=",
                        "prony" | "law_table" | "hardening_curve" | "compliance" => ":",
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
