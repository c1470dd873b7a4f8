//! Runs the program as a user would.

use std::path::Path;
use std::process::{Command, Output};

/// A sweep of seconds.
#[allow(dead_code, reason = "not every test file makes a sweep")]
pub(crate) const SWEEP: &str = "
[points]
eps_t_inv = [1.0, 2.0]
eps_f_inv = [4, 8]
eps_c_inv = [4, 8]
centre = [2, 4, 4]
[loads]
p_star = [0.02, 0.05]
[statistics]
realisations = 2
[fit]
p_star = 0.05
alpha_c = 1
resamples = 20
";

/// Runs the program with `arguments` in `folder`, under the emulator that `GFMD_EMULATOR` names, if any.
pub(crate) fn gfmd(folder: &Path, arguments: &[&str]) -> Output {
    let emulator = std::env::var("GFMD_EMULATOR").unwrap_or_default();
    let mut words: Vec<&str> = emulator.split_whitespace().chain([env!("CARGO_BIN_EXE_gfmd")]).collect();
    Command::new(words.remove(0)).args(words).current_dir(folder).args(arguments).output().expect("the program starts")
}

/// Returns the JSON of the program; fails if the program does.
#[allow(dead_code, reason = "not every test file reads JSON")]
pub(crate) fn json(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let output = gfmd(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{arguments:?}: {error}"))
}
