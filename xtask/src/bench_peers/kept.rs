//! Results of an interrupted run, to continue it.

use std::path::Path;

use gfmd_input::failure::Failure;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Reads the results of an earlier run from `file`.
///
/// # Errors
/// A file that cannot be read; an earlier run that differs from `now`, without results yet, in more than `results`.
pub(super) fn read<T: DeserializeOwned>(file: &Path, now: &impl Serialize, results: &[&str]) -> Result<T, Failure> {
    let refused = |why: String| Failure::refused(format!("--resume: {}: {why}", file.display()));
    let parsed = |text: &str| serde_json::from_str(text).map_err(|error| refused(error.to_string()));
    let kept: Value = parsed(&std::fs::read_to_string(file).map_err(|error| refused(error.to_string()))?)?;
    let now: Value = parsed(&gfmd_input::json::to_string(now).map_err(|error| refused(error.to_string()))?)?;
    for (name, value) in now.as_object().into_iter().flatten() {
        if !results.contains(&name.as_str()) && kept.get(name) != Some(value) {
            let found = kept.get(name).unwrap_or(&Value::Null);
            return Err(refused(format!("its {name} is {found}; it must be {value}, as in this run")));
        }
    }
    serde_json::from_value(kept).map_err(|error| refused(error.to_string()))
}
