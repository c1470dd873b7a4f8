//! Inputs of a run, which no output may replace.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use gfmd_files::is_one_file;
use gfmd_input::failure::Failure;
use gfmd_input::source::file_of;
use gfmd_input::units::Word;
use gfmd_problem::{Words, key, words};
use toml::{Table, Value};

/// Options that name an output file.
const WRITTEN: [&str; 4] = ["out", "vtk", "report", "export_law"];

/// Suffixes of files written beside an output.
const BESIDE: [&str; 5] = ["", ".part", ".journal", ".state", ".checkpoint"];

/// Refuses command lines with an output that is also the file of another word, under any name.
///
/// # Errors
/// Returns an error if an output is an input.
pub fn stay(words: &[Word]) -> Result<(), Failure> {
    let (mut written, mut read) = (Vec::new(), Vec::new());
    for word in words.iter().skip(1) {
        let (option, value) = word.given().unwrap_or(("", word.text()));
        if WRITTEN.contains(&option) { &mut written } else { &mut read }
            .push((option.to_owned(), OsString::from(value)));
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

/// Refuses files to be `written` that are also `read`, each given with its option, or as the argument if that is empty.
fn apart(written: &[(String, OsString)], read: &[(String, OsString)]) -> Result<(), Failure> {
    for (out, path) in written {
        for (option, input) in read {
            let beside = BESIDE.map(|end| {
                let mut name = path.clone();
                name.push(end);
                name
            });
            let file = input.to_str().map_or_else(|| PathBuf::from(input), |text| file_of(text).into());
            if !beside.iter().any(|path| is_one_file(Path::new(path), &file)) {
                continue;
            }
            let whose = if option.is_empty() { Words::default() } else { words![" of ", key(option)] };
            let found = Path::new(path).display();
            return Err(Failure::value(key(out), found, words!["another file than the input", whose]));
        }
    }
    Ok(())
}
