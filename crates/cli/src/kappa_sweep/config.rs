//! The configuration of a sweep as TOML.

use std::path::Path;

use gfmd_sweep::Config;

use crate::failure::Failure;

/// Reads a file; missing fields are those of the preset `default`.
///
/// # Errors
/// A file that cannot be read, is not TOML, or has an unknown or mistyped field.
pub(super) fn read(path: &Path) -> Result<Config, Failure> {
    let name = path.display();
    let text = gfmd_files::input::text(path).map_err(|error| Failure::input(&name.to_string(), error))?;
    toml::from_str(&text).map_err(|error: toml::de::Error| {
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
