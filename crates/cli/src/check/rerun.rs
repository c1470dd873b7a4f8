//! A run that is repeated from the configuration in its file.

use std::path::Path;

use clap::{Args, FromArgMatches};
use gfmd_files::Reader;

use super::Comparison;
use crate::failure::Failure;
use crate::session::Session;

/// Scalars that differ between identical runs.
const VOLATILE: [&str; 1] = ["seconds"];

/// The flags of a configuration, in the order of the file. Keys in `except` are left out.
///
/// # Errors
/// A configuration that is not TOML.
pub(crate) fn words(config: &str, except: &[&str]) -> Result<Vec<String>, Failure> {
    let table: toml::Table = config.parse().map_err(|error| Failure::input("config of the file", error))?;
    let mut words = Vec::new();
    for (key, value) in table.iter().filter(|(key, _)| !except.contains(&key.as_str())) {
        let flag = format!("--{}", key.replace('_', "-"));
        match value {
            toml::Value::Boolean(true) => words.push(flag),
            toml::Value::Boolean(false) => {}
            // The values of a repeated flag: NAME=VALUE pairs, or lists of numbers.
            toml::Value::Array(lists) if lists.first().is_some_and(toml::Value::is_array) => {
                for list in lists.iter().filter_map(toml::Value::as_array) {
                    let between = if list.first().is_some_and(toml::Value::is_str) { "=" } else { "," };
                    words.push(format!("{flag}={}", list.iter().map(text).collect::<Vec<_>>().join(between)));
                }
            }
            toml::Value::Array(values) => {
                words.push(format!("{flag}={}", values.iter().map(text).collect::<Vec<_>>().join(",")));
            }
            value => words.push(format!("{flag}={}", text(value))),
        }
    }
    Ok(words)
}

fn text(value: &toml::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), Into::into)
}

/// Parses the flags of a command.
///
/// # Errors
/// Words that are no flags of the command.
pub(crate) fn parsed<A: Args + FromArgMatches>(words: &[String]) -> Result<A, Failure> {
    let command = A::augment_args(clap::Command::new("gfmd").no_binary_name(true));
    // A default that is written out may be refused beside other flags.
    let is_default = |word: &&String| {
        let (flag, value) = word.trim_start_matches('-').split_once('=').unwrap_or((word, ""));
        let argument = command.get_arguments().find(|argument| argument.get_long() == Some(flag));
        argument.is_some_and(|argument| argument.get_default_values() == [value])
    };
    let words: Vec<&String> = words.iter().filter(|word| !is_default(word)).collect();
    let parsed = command.try_get_matches_from(words).and_then(|matches| A::from_arg_matches(&matches));
    parsed.map_err(|error| {
        Failure::input(
            "config of the file",
            error.to_string().lines().map(str::trim).take(2).collect::<Vec<_>>().join(" "),
        )
    })
}

/// A file whose run is repeated.
pub(crate) struct Rerun<'a> {
    pub(crate) reader: &'a Reader,
    pub(crate) config: &'a str,
    pub(crate) session: &'a Session,
}

impl Rerun<'_> {
    /// Runs the command again, which writes the file that it is given, and compares all variables.
    ///
    /// # Errors
    /// A run that cannot be repeated.
    pub(crate) fn compare(
        &self,
        command: &str,
        comparison: &mut Comparison,
        again: fn(&Reader, &str, &Path, &Session) -> Result<bool, Failure>,
    ) -> Result<(), Failure> {
        let failed = |error: std::io::Error| Failure::Computation(format!("cannot make a folder: {error}"));
        let folder = tempfile::tempdir().map_err(failed)?;
        let out = folder.path().join(format!("{command}.h5"));
        if !again(self.reader, self.config, &out, self.session)? {
            return Ok(());
        }
        let second = Reader::open(&out)?;
        all(self.reader, &second, "", comparison)
    }
}

/// Compares the variables of two files, group by group.
pub(crate) fn all(first: &Reader, second: &Reader, group: &str, comparison: &mut Comparison) -> Result<(), Failure> {
    let names = |reader: &Reader| reader.names(if group.is_empty() { "/" } else { group });
    let (stored, found) = (names(first), names(second));
    for name in stored.iter().chain(found.iter().filter(|name| !stored.contains(name))) {
        let path = format!("{group}/{name}");
        match (first.contains(&path), second.contains(&path)) {
            (false, false) => all(first, second, &path, comparison)?,
            (true, true) if VOLATILE.contains(&name.as_str()) => {}
            (true, true) => variable(first, second, &path, comparison)?,
            (true, false) => comparison.differ(&path, "it is not in the file of the second run".into()),
            (false, true) => comparison.differ(&path, "it is only in the file of the second run".into()),
        }
    }
    Ok(())
}

fn variable(first: &Reader, second: &Reader, path: &str, comparison: &mut Comparison) -> Result<(), Failure> {
    let (a, b) = (first.shape(path)?, second.shape(path)?);
    if a != b {
        comparison.differ(path, format!("its shape is {a:?}; recomputed is {b:?}"));
        return Ok(());
    }
    match (first.values::<f64>(path), second.values::<f64>(path)) {
        (Ok(stored), Ok(found)) => comparison.values(path, &stored, &found, 0.0),
        _ => {
            if first.texts(path)? != second.texts(path)? {
                comparison.differ(path, "its text differs".into());
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_becomes_flags() {
        let config = "young = 1.0\np_star = [0.01, -0.5]\nflip = true\ndetrend = \"none\"\nquiet = false\nheight = inf\n\
                      param = [[\"gamma\", 1e-4], [\"range\", 0.003]]\n";
        let found = words(config, &["young"]).unwrap();
        let expected = [
            "--p-star=0.01,-0.5",
            "--flip",
            "--detrend=none",
            "--height=inf",
            "--param=gamma=0.0001",
            "--param=range=0.003",
        ];
        let mut sorted = found.clone();
        sorted.sort();
        let mut wanted: Vec<String> = expected.map(Into::into).into();
        wanted.sort();
        assert_eq!(sorted, wanted);
        assert!(words("young = ", &[]).is_err());
    }
}
