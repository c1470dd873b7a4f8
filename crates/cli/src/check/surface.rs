//! The surface of a result, as the input of a command.

use std::path::Path;

use gfmd_files::{Checksum, Reader};

use super::{Comparison, words};
use crate::base::{BaseArgs, stored_base};
use crate::failure::Failure;
use crate::source::SourceArgs;

/// Compares the heights of a result with their checksum. Returns the flags of a command that reads them.
///
/// # Errors
/// A file without a surface.
pub(crate) fn stored_surface(reader: &Reader, comparison: &mut Comparison) -> Result<Vec<String>, Failure> {
    let heights: Vec<f64> = reader.values("/surface/height")?;
    if let Ok(stated) = reader.text("/surface", "height_sha256")
        && Checksum::of_numbers(heights) != stated
    {
        comparison.differ("/surface/height", "its checksum does not hold".into());
    }
    let mut words = vec![format!("--surface={}:/surface/height", reader.path().display())];
    if let (Ok(x), Ok(y)) = (reader.number("/surface", "length_x"), reader.number("/surface", "length_y")) {
        words.push(if reader.shape("/surface/height")?.get(1) == Some(&1) {
            format!("--length={x:e}")
        } else {
            format!("--length={x:e},{y:e}")
        });
    }
    Ok(words)
}

/// The flags that repeat a run into `out`. A surface that was read from a file is taken from the result, where it is stored as
/// it was used; a generated one is generated again.
///
/// # Errors
/// A configuration that is not TOML, a file without a surface.
pub(crate) fn flags_again(reader: &Reader, config: &str, out: &Path) -> Result<Vec<String>, Failure> {
    let table: toml::Table = config.parse().map_err(|error| Failure::input("config of the file", error))?;
    let mut flags = match table.contains_key("surface") || table.contains_key("second_surface") {
        true => {
            let mut flags = stored_surface(reader, &mut Comparison::default())?;
            flags.extend(words(config, &[&SourceArgs::names()[..], &BaseArgs::NAMES].concat())?);
            flags
        }
        // Defaults of the flags for files are no flags of a generated surface.
        false => words(config, &BaseArgs::NAMES)?,
    };
    flags.extend(stored_base(reader));
    flags.push(format!("--out={}", out.display()));
    Ok(flags)
}
