//! The surface of a result, as the input of a command.

use gfmd_contact::Boundary;
use gfmd_files::{Checksum, Reader};

use super::{Comparison, Configuration, parsed};
use crate::base::{BaseArgs, stored_base};
use crate::failure::Failure;
use crate::hardness::stored_hardness;
use crate::lower::{LowerArgs, stored_lower};
use crate::session::Session;
use crate::source::{SourceArgs, Surface};

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

/// The flags of the fields that a result has beside its surface: its base, the surface below, and its hardness.
///
/// # Errors
/// A configuration that names such a field, which the result does not have.
pub(crate) fn stored_fields(reader: &Reader, config: &Configuration) -> Result<Vec<String>, Failure> {
    let (base, lower, hardness) = (stored_base(reader), stored_lower(reader), stored_hardness(reader));
    let needed = [
        (BaseArgs::NAMES.iter().any(|key| config.has(key)), base.is_empty(), "/base"),
        (LowerArgs::NAMES.iter().any(|key| config.has(key)), lower.is_none(), "/lower/height"),
        (config.names_a_file("hardness"), hardness.is_none(), "/surface/hardness"),
    ];
    if let Some((.., path)) = needed.into_iter().find(|(is_named, is_missing, _)| *is_named && *is_missing) {
        return Err(Failure::input("config of the file", format!("it names the field {path}, which the file has not")));
    }
    Ok(base.into_iter().chain(lower).chain(hardness).collect())
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

/// The flags that repeat a run. A surface that was made from a file or an array is taken from the result, where it is stored as
/// it was used; a generated one, which has a number of points, is generated again.
///
/// # Errors
/// A file without a surface.
pub(crate) fn flags_again(reader: &Reader, config: &Configuration) -> Result<Vec<String>, Failure> {
    let mut flags = match is_generated(config) {
        // Defaults of the flags for files are no flags of a generated surface.
        true => config.words(&beside_surface(reader)),
        false => {
            let mut flags = stored_surface(reader, &mut Comparison::default())?;
            flags.extend(config.words(&beside_fields(reader)));
            flags
        }
    };
    flags.extend(stored_fields(reader, config)?);
    Ok(flags)
}

/// The unit of the heights of a group, as the file has it; `None` for any consistent unit.
pub(crate) fn stored_unit(reader: &Reader, group: &str) -> Option<String> {
    reader.text(&format!("{group}/height"), "units").ok().filter(|unit| unit != "length")
}

/// True if the heights of a result were generated, and no file had a part in them.
fn is_generated(config: &Configuration) -> bool {
    config.has("n") && !config.has("surface") && !config.has("second_surface")
}

/// Generates the surfaces of a result again, if they were generated, and compares heights and words.
///
/// # Errors
/// A configuration that makes no surface, a file without one.
pub(crate) fn regenerated(
    reader: &Reader,
    config: &Configuration,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    if !is_generated(config) {
        return Ok(());
    }
    let source: SourceArgs = parsed(&config.words_of(&SourceArgs::names()))?;
    let boundary: Boundary = config.text("boundary").parse().unwrap_or(Boundary::Periodic);
    let upper = source.bounded(boundary, session)?;
    same(reader, "/surface", &upper, comparison)?;
    let lower: LowerArgs = parsed(&config.words_of(&LowerArgs::NAMES))?;
    match lower.read(&source, &upper, session)? {
        Some(lower) => same(reader, "/lower", &lower, comparison),
        None => Ok(()),
    }
}

fn same(reader: &Reader, group: &str, made: &Surface, comparison: &mut Comparison) -> Result<(), Failure> {
    let path = format!("{group}/height");
    let (stored, made_of) = (reader.shape(&path)?, made.grid.points());
    if stored != made_of {
        comparison.differ(&path, format!("its shape is {stored:?}; that of the configuration is {made_of:?}"));
        return Ok(());
    }
    let heights: Vec<f64> = made.heights.iter().copied().collect();
    comparison.values(&path, &reader.values::<f64>(&path)?, &heights, 0.0);
    let lengths = ["length_x", "length_y"].map(|name| reader.number(group, name).unwrap_or(f64::NAN));
    comparison.values(&format!("{group}@length"), &lengths, &made.grid.lengths(), 0.0);
    for (part, name, made) in [(group, "description", made.description.as_str()), (&path, "units", made.unit())] {
        let stored = reader.text(part, name).unwrap_or_default();
        if stored != made {
            comparison.differ(&format!("{part}@{name}"), format!("it is {stored:?}; it must be {made:?}"));
        }
    }
    Ok(())
}
