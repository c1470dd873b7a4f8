//! Report of the fields in a file.

use gfmd_check::result::{Configuration, ResultKind};
use gfmd_files::{FileError, Reader};
use gfmd_input::failure::Failure;

use super::{Args, Level, Plane, Report, Side, Slice};

/// Reads the report of the fields in a file. Nothing is computed: all numbers come from the file.
///
/// # Errors
/// Returns an error if the file is not a result of `body`, or lacks a number at a depth.
pub fn stored(reader: &Reader) -> Result<Report, Failure> {
    let refuse = |error: FileError| Failure::refused(error.to_string());
    let text = reader.text("/", "config").map_err(refuse)?;
    let args: Args = Configuration::read::<Args>(ResultKind::Body, &text)?.as_named()?;
    let path = |name: &str| format!("/fields/{name}");
    let values = |name: &str| reader.values::<f64>(&path(name)).map_err(refuse);
    let unit = |name: &str, kind: &str| reader.text(&path(name), "units").ok().filter(|unit| unit != kind);
    let points = |name: &str| reader.number("/fields", name).map(|points| points as usize).map_err(refuse);
    let depths = values("depth")?;
    let at_depths = |name: &str| {
        let (found, all) = (values(name)?, depths.len());
        let wrong = || Failure::input(path(name), format!("it has {} values; it must have {all}", found.len()));
        if found.len() == all { Ok(found) } else { Err(wrong()) }
    };
    let sides = if reader.contains(&path("side")) { at_depths("side")? } else { vec![0.0; depths.len()] };
    let side = |side: f64| match side {
        0.0 => None,
        _ => Some(if side > 0.0 { Side::Above } else { Side::Below }),
    };
    let [displacement, von_mises, energy] = Level::NUMBERS.map(|(name, ..)| at_depths(name));
    let (displacement, von_mises, energy) = (displacement?, von_mises?, energy?);
    let level = |index: usize| Level {
        max_displacement: displacement[index],
        max_von_mises: von_mises[index],
        mean_energy_density: energy[index],
        ..Level::at(Plane { depth: depths[index], side: side(sides[index]) })
    };
    let slice = reader.text("/fields", "slice").ok().map(|text| text.parse::<Slice>());
    let slice = slice.transpose().map_err(|reason| Failure::input("/fields@slice", reason))?;
    let &[lx, ly] = &args.size[..] else {
        return Err(Failure::input("config of the file", "size must be two lengths"));
    };
    Ok(Report {
        n: [points("points_x")?, points("points_y")?],
        size: [lx, ly],
        unit: unit("depth", "length"),
        stress_unit: unit("mean_traction", "stress"),
        surface: args.surface.as_ref().map_or_else(|| "the wave".into(), ToString::to_string),
        mean_traction: values("mean_traction")?,
        slice,
        levels: (0..depths.len()).map(level).collect(),
        comparison: None,
        out: None,
        plots: Vec::new(),
    })
}
