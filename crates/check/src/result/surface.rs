//! Problem of a result, with the surface and the fields stored in it.

use clap::Args;
use gfmd_contact::Boundary;
use gfmd_files::{Checksum, Reader};
use serde::de::DeserializeOwned;
use toml::Table;

use super::comparison::Comparison;
use super::configuration::Configuration;
use gfmd_input::base::{BaseArgs, stored_base};
use gfmd_input::failure::Failure;
use gfmd_input::hardness::stored_hardness;
use gfmd_input::lower::{LowerArgs, stored_lower};
use gfmd_input::session::Session;
use gfmd_input::source::{SourceArgs, Surface};
use gfmd_problem::options::flags::keys;

/// Compares the heights of a result with their checksum.
///
/// # Errors
/// Returns an error if the file has no surface.
pub fn compare_heights(reader: &Reader, comparison: &mut Comparison) -> Result<(), Failure> {
    let heights: Vec<f64> = reader.values("/surface/height")?;
    if let Ok(stated) = reader.text("/surface", "height_sha256")
        && Checksum::of_numbers(heights) != stated
    {
        comparison.differ("/surface/height", "its checksum does not hold".into());
    }
    Ok(())
}

/// Returns the problem of a result with its stored surface and fields, whatever their origin.
///
/// # Errors
/// Returns an error if the file has no surface, or lacks a field that the configuration names.
pub fn stored_problem<A: Args + DeserializeOwned>(reader: &Reader, config: &Configuration) -> Result<A, Failure> {
    let mut stored = stored_fields(reader, config)?;
    stored.insert("surface".into(), format!("{}:/surface/height", reader.path().display()).into());
    if let (Ok(x), Ok(y)) = (reader.number("/surface", "size_x"), reader.number("/surface", "size_y")) {
        let is_line = reader.shape("/surface/height")?.get(1) == Some(&1);
        stored.insert("size".into(), if is_line { vec![x] } else { vec![x, y] }.into());
    }
    let of_source = keys::<SourceArgs>().into_iter().filter(|key| key != "stress_unit");
    let replaced: Vec<String> = of_source.chain(BESIDE.map(Into::into)).collect();
    config.problem(&replaced, stored)
}

/// Returns the problem of a result, to be solved again. A surface from a file or an array is taken from the result,
/// where it is stored as it was used. A generated one, which has a number of points, is generated again.
///
/// # Errors
/// Fails like [`stored_problem`].
pub fn repeated_problem<A: Args + DeserializeOwned>(reader: &Reader, config: &Configuration) -> Result<A, Failure> {
    match is_generated(config) {
        true => config.problem(&BESIDE.map(Into::into), stored_fields(reader, config)?),
        false => stored_problem(reader, config),
    }
}

/// Keys of stored fields other than the surface.
const BESIDE: [&str; 4] = ["base_displacement", "base_traction", "lower_surface", "lower_seed"];

/// Returns the names of the fields stored beside the surface: base, lower surface, and hardness.
fn stored_fields(reader: &Reader, config: &Configuration) -> Result<Table, Failure> {
    let (base, lower, hardness) = (stored_base(reader), stored_lower(reader), stored_hardness(reader));
    let needed = [
        (BaseArgs::NAMES.iter().any(|key| config.has(key)), base.is_none(), "/base"),
        (LowerArgs::NAMES.iter().any(|key| config.has(key)), lower.is_none(), "/lower/height"),
        (config.names_a_file("hardness"), hardness.is_none(), "/surface/hardness"),
    ];
    if let Some((.., path)) = needed.into_iter().find(|(is_named, is_missing, _)| *is_named && *is_missing) {
        return Err(Failure::input("config of the file", format!("it names the field {path}, which is missing")));
    }
    Ok(base.into_iter().chain(lower).chain(hardness).map(|(key, name)| (key.into(), name.into())).collect())
}

/// Returns true if the heights of a result were generated without any file.
fn is_generated(config: &Configuration) -> bool {
    config.has("n") && !config.has("surface") && !config.has("second_surface")
}

/// Generates the surfaces of a result again, if they were generated, and compares heights and words.
///
/// # Errors
/// Returns an error if the configuration makes no surface, or if the file has none.
pub fn regenerated(
    reader: &Reader,
    config: &Configuration,
    boundary: Boundary,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    if !is_generated(config) {
        return Ok(());
    }
    let source: SourceArgs = config.problem(&[], Table::new())?;
    let upper = source.bounded(boundary, session)?;
    same(reader, "/surface", &upper, comparison)?;
    let lower: LowerArgs = config.problem(&[], Table::new())?;
    match lower.read(&source, &upper, session)? {
        Some(lower) => same(reader, "/lower", &lower, comparison),
        None => Ok(()),
    }
}

fn same(reader: &Reader, group: &str, made: &Surface, comparison: &mut Comparison) -> Result<(), Failure> {
    let path = format!("{group}/height");
    let (stored, made_of) = (reader.shape(&path)?, made.grid.points());
    if stored != made_of {
        comparison.differ(&path, format!("its shape is {stored:?}; the configuration gives {made_of:?}"));
        return Ok(());
    }
    let heights: Vec<f64> = made.heights.iter().copied().collect();
    comparison.values(&path, &reader.values::<f64>(&path)?, &heights, 0.0);
    let lengths = ["size_x", "size_y"].map(|name| reader.number(group, name).unwrap_or(f64::NAN));
    comparison.values(&format!("{group}@length"), &lengths, &made.grid.lengths(), 0.0);
    for (part, name, made) in [(group, "description", made.description.as_str()), (&path, "units", made.unit())] {
        let stored = reader.text(part, name).unwrap_or_default();
        if stored != made {
            comparison.differ(&format!("{part}@{name}"), format!("it is {stored:?}; it must be {made:?}"));
        }
    }
    Ok(())
}
