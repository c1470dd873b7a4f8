//! Inputs of a run, which no output may replace.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use gfmd_files::is_one_file;
use gfmd_run::failure::Failure;
use gfmd_run::source::file_of;
use toml::{Table, Value};

/// Flags that name an output file.
const WRITTEN: [&str; 3] = ["out", "vtk", "report"];

/// Suffixes of files written beside an output.
const BESIDE: [&str; 5] = ["", ".part", ".journal", ".state", ".checkpoint"];

/// Refuses command lines with an output that is also the file of another word, under any name.
///
/// # Errors
/// Returns an error if an output is an input.
pub fn stay(words: &[OsString]) -> Result<(), Failure> {
    let (mut written, mut read) = (Vec::new(), Vec::new());
    let mut flag = String::new();
    for word in words.iter().skip(1) {
        let text = word.to_string_lossy();
        let (name, value) = match text.strip_prefix("--").map(|name| (name, name.split_once('='))) {
            Some((name, None)) => {
                name.clone_into(&mut flag);
                continue;
            }
            Some((_, Some((name, value)))) => (name.to_owned(), OsString::from(value)),
            None => (std::mem::take(&mut flag), word.clone()),
        };
        if WRITTEN.contains(&&*name) { &mut written } else { &mut read }.push((name, value));
    }
    apart(&written, &read)
}

/// Refuses a table with flags as keys in the same way as [`stay`].
///
/// # Errors
/// Returns an error if an output is an input.
pub fn stay_in(table: &Table) -> Result<(), Failure> {
    let texts = table.iter().filter_map(|(key, value)| match value {
        Value::String(text) => Some((key.clone(), OsString::from(text))),
        _ => None,
    });
    let (written, read): (Vec<_>, Vec<_>) = texts.partition(|(key, _)| WRITTEN.contains(&&**key));
    apart(&written, &read)
}

/// Refuses files to be `written` that are also `read`, each given with its flag, or as the argument if that is empty.
fn apart(written: &[(String, OsString)], read: &[(String, OsString)]) -> Result<(), Failure> {
    for (out, path) in written {
        for (flag, input) in read {
            let beside = BESIDE.map(|end| {
                let mut name = path.clone();
                name.push(end);
                name
            });
            let file = input.to_str().map_or_else(|| PathBuf::from(input), |text| file_of(text).into());
            if !beside.iter().any(|path| is_one_file(Path::new(path), &file)) {
                continue;
            }
            let whose = if flag.is_empty() { String::new() } else { format!(" of --{}", flag.replace('_', "-")) };
            let found = Path::new(path).display();
            return Err(Failure::value(format!("--{out}"), found, format!("another file than the input{whose}")));
        }
    }
    Ok(())
}
