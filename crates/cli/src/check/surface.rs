//! The surface of a result, as the input of a command.

use std::path::Path;

use gfmd_files::{Checksum, Reader};

use super::{Comparison, words};
use crate::base::{BaseArgs, stored_base};
use crate::failure::Failure;
use crate::hardness::stored_hardness;
use crate::lower::{LowerArgs, stored_lower};
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

/// The flags of the fields that a result has beside its surface: its base and its hardness.
pub(crate) fn stored_fields(reader: &Reader) -> Vec<String> {
    stored_base(reader).into_iter().chain(stored_lower(reader)).chain(stored_hardness(reader)).collect()
}

/// The keys of a configuration that [`stored_fields`] replaces.
fn beside_surface(reader: &Reader) -> Vec<&'static str> {
    let hardness = stored_hardness(reader).map(|_| "hardness");
    BaseArgs::NAMES.into_iter().chain(LowerArgs::NAMES).chain(hardness).collect()
}

/// The keys of a configuration that [`stored_surface`] and [`stored_fields`] replace.
pub(crate) fn beside_fields(reader: &Reader) -> Vec<&'static str> {
    SourceArgs::names().into_iter().chain(beside_surface(reader)).collect()
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
            flags.extend(words(config, &beside_fields(reader))?);
            flags
        }
        // Defaults of the flags for files are no flags of a generated surface.
        false => words(config, &beside_surface(reader))?,
    };
    flags.extend(stored_fields(reader));
    flags.push(format!("--out={}", out.display()));
    Ok(flags)
}
