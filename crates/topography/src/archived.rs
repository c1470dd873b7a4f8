//! Heights from datasets of HDF5 files of any program, such as the surfaces of the contact-mechanics challenge.
//!
//! Every dataset of numbers with one or two dimensions is a channel under its path, except coordinates (dimension
//! scales). Without a name, the only dataset of two dimensions is read, or `/surface`, `/surface/height`, `/heights`.
//! Sizes come from evenly spaced coordinates `x` and `y` in the group of the dataset, units from the attributes `units`
//! of each.
//!
//! In NetCDF-4, which is HDF5, SurfaceTopography writes the size as the attribute `length` of `x` and `y`, the unit as
//! `unit`, and marks undefined points of `heights` in `mask`.

use super::coordinates::{CONSISTENT, lengths};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::unit::Sides;
use super::{shaped, two_dimensional};
use crate::stored::Hdf5;

pub(crate) const FORMAT: Format = Format { name: "HDF5", sniff: File::is_hdf5, open, first_line: FirstLine::Bottom };

/// The datasets that are read by default, if there are several.
const USUAL: [&str; 3] = ["/surface", "/surface/height", "/heights"];

fn open(file: &File) -> Result<Contents<'_>, String> {
    let reader = file.hdf5()?;
    let mut channels = Vec::new();
    for (name, shape) in reader.datasets() {
        let Ok(points) = two_dimensional(&shape) else { continue };
        if name.strip_suffix("/mask").is_some_and(|group| reader.contains(&format!("{group}/heights"))) {
            continue;
        }
        let dataset = name.clone();
        let read = Box::new(move || read(&file.hdf5()?, &dataset, points));
        channels.push(Channel { unit: unit(&reader, &name), name, points, read });
    }
    if channels.is_empty() {
        return Err("the file has no dataset of numbers with one or two dimensions; it must have one".into());
    }
    let maps: Vec<usize> = (0..channels.len()).filter(|&k| channels[k].points[1] > 1).collect();
    let usual = || USUAL.iter().find_map(|name| channels.iter().position(|channel| channel.name == *name));
    let default = match (&maps[..], channels.len()) {
        ([only], _) => Some(*only),
        ([], 1) => Some(0),
        _ => usual(),
    };
    Ok(Contents { channels, default })
}

/// Reads the heights of a dataset, and the lengths from evenly spaced coordinates `x` and `y` in its group, if any.
fn read(reader: &Hdf5, dataset: &str, points: [usize; 2]) -> Result<Map, String> {
    let values = reader.values(dataset)?;
    let mut heights = shaped(points, values)?;
    let group = dataset.rsplit_once('/').map_or("", |(group, _)| group);
    let mask = format!("{group}/mask");
    if dataset.ends_with("/heights") && reader.contains(&mask) {
        let mask = shaped(points, reader.values(&mask)?)?;
        heights.zip_mut_with(&mask, |height, mark| {
            if *mark != 0.0 {
                *height = f64::NAN;
            }
        });
    }
    let written = |axis: &str| reader.number_if_any(&format!("{group}/{axis}"), "length");
    let found = match (written("x")?, written("y")?, points[1]) {
        (Some(x), _, 1) => Some([x, 1.0]),
        (Some(x), Some(y), _) => Some([x, y]),
        _ => lengths(|name| reader.contains(name).then(|| reader.values(name)), dataset, points)?,
    };
    let height_unit = unit(reader, dataset);
    let Some(found) = found else { return Ok(Map { heights, height_unit, ..Map::default() }) };
    let along = |axis: &str, length| (length, unit(reader, &format!("{group}/{axis}")));
    let y = (points[1] > 1).then(|| along("y", found[1]));
    let Sides { lengths, unit, notes } = Sides::of(along("x", found[0]), y)?;
    Ok(Map { heights, lengths: Some(lengths), length_unit: unit, height_unit, notes, ..Map::default() })
}

/// The unit of a dataset; "length" and "1" denote any consistent unit.
fn unit(reader: &Hdf5, dataset: &str) -> Option<String> {
    let unit = reader.text(dataset, "units").or_else(|_| reader.text(dataset, "unit"));
    unit.ok().filter(|unit| !CONSISTENT.contains(&unit.as_str()))
}
