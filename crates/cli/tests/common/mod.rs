//! Runs the program as a user would.

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program with `arguments` in `folder`.
pub(crate) fn gfmd(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gfmd")).current_dir(folder).args(arguments).output().expect("the program starts")
}

/// Returns the JSON of the program; fails if the program does.
#[allow(dead_code, reason = "not every test file reads JSON")]
pub(crate) fn json(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let output = gfmd(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{arguments:?}: {error}"))
}
