//! Heights from datasets of HDF5 files of any program, such as the surfaces of the contact-mechanics challenge.
//!
//! Every dataset of numbers with one or two dimensions is a channel under its path, except coordinates (dimension
//! scales). Without a name, the only dataset of two dimensions is read, else `/surface`, `/surface/height`, `/heights`,
//! the signal named by NeXus, or the first dataset in a unit of length.
//!
//! The first dimension is x, unless the dimensions are named `y` and `x` (dimension scales, labels, NeXus `axes`), or
//! only that order agrees with the numbers of coordinates. Sizes come from evenly spaced coordinates, in either
//! direction, in the group of the dataset, units from the attribute `units` of each. Values follow from the numbers by
//! the attributes of the CF conventions (`scale_factor`, `_FillValue`, `valid_range`, ...), or by the encoder in the
//! group of a JPK channel. Integers in a unit of length without a scale are refused.
//!
//! In NetCDF-4, which is HDF5, SurfaceTopography writes the size as the attribute `length` of `x` and `y`, the unit as
//! `unit`, and marks undefined points of `heights` in `mask`. Points stored in rows, one after the other, have their
//! places in a dataset `Position_Values` or in the grid pattern of JPK.

use ndarray::Array2;

use super::coordinates::{CONSISTENT, Lattice, evenly_spaced, rising};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, first_height};
use super::packing::{Packing, is_scaling};
use super::unit::{Sides, is_length};
use super::{shaped, two_dimensional};
use crate::stored::Hdf5;

pub(crate) const FORMAT: Format = Format { name: "HDF5", sniff: File::is_hdf5, open, first_line: FirstLine::Bottom };

/// Datasets read by default if there are several.
const USUAL: [&str; 3] = ["/surface", "/surface/height", "/heights"];

/// Datasets with the places of points, which are not heights.
const PLACES: &str = "Position_Values";
const OF_PLACES: [&str; 4] = [PLACES, "Position_Indices", "Spectroscopic_Values", "Spectroscopic_Indices"];

/// Largest number of frames of points stored in rows.
const MOST_FRAMES: usize = 100;

/// Prefix of the attributes of the JPK grid of points.
const GRID: &str = "position-pattern.grid.";

fn open(file: &File) -> Result<Contents<'_>, String> {
    let reader = file.hdf5()?;
    let mut channels = Vec::new();
    let datasets = reader.datasets();
    let places: Vec<String> =
        datasets.iter().filter(|(name, _)| split(name).1 == PLACES).map(|(name, _)| name.clone()).collect();
    for (name, shape) in datasets {
        let (group, own) = split(&name);
        if OF_PLACES.contains(&own) || (own == "mask" && reader.contains(&format!("{group}/heights"))) {
            continue;
        }
        // Errors and amplitudes of JPK are lengths, too, and each channel has a small picture.
        if let Ok(quantity) = reader.text(group, "channel.name")
            && (own == "thumbnail" || !quantity.to_lowercase().contains("height"))
        {
            continue;
        }
        let unit = unit_of(&reader, &name);
        if let Some((frames, places)) = Places::of(&reader, group, &shape, &places)? {
            for frame in 0..frames {
                let (places, dataset, points) = (places.clone(), name.clone(), places.points);
                let name = if frames == 1 { name.clone() } else { format!("{name}/{frame}") };
                let read = Box::new(move || places.read(&file.hdf5()?, &dataset, [frame, frames]));
                channels.push(Channel { unit: unit.clone(), name, points, read });
            }
            continue;
        }
        let Ok(stored) = two_dimensional(&shape) else { continue };
        let axes = Axes::of(&reader, group, own, stored);
        let points = if axes.transposed { [stored[1], stored[0]] } else { stored };
        let dataset = name.clone();
        let read = Box::new(move || read(&file.hdf5()?, &dataset, stored, &axes));
        channels.push(Channel { unit, name, points, read });
    }
    if channels.is_empty() {
        return Err("the file has no dataset of numbers with one or two dimensions; it must have one".into());
    }
    let maps: Vec<usize> = (0..channels.len()).filter(|&k| channels[k].points[1] > 1).collect();
    let named = |name: &str| channels.iter().position(|channel| channel.name == name);
    let usual = || USUAL.iter().find_map(|name| named(name)).or_else(|| named(&signal(&reader)?));
    let default = match maps[..] {
        [only] => Some(only),
        _ => usual().or_else(|| {
            let of_maps = |channel: &Channel| maps.is_empty() || channel.points[1] > 1;
            let all: Vec<usize> = (0..channels.len()).filter(|&k| of_maps(&channels[k])).collect();
            first_height(&channels, &all)
        }),
    };
    Ok(Contents { default, ..channels.into() })
}

/// Splits the path of a dataset into its group and name.
fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('/').unwrap_or(("", path))
}

/// Returns `group` and the groups around it, up to the root.
fn around(group: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(group), |group| group.rsplit_once('/').map(|(outer, _)| outer))
}

/// Follows the NeXus attributes `default` and `signal` from the root to a dataset.
fn signal(reader: &Hdf5) -> Option<String> {
    let mut group = String::new();
    for _ in 0..8 {
        let path = if group.is_empty() { "/" } else { &group };
        match (reader.text(path, "default"), reader.text(path, "signal")) {
            (_, Ok(signal)) => return Some(format!("{group}/{signal}")),
            (Ok(default), Err(_)) => group = format!("{group}/{}", default.trim_matches('/')),
            (Err(_), Err(_)) => return None,
        }
    }
    None
}

/// Dimensions of a dataset.
struct Axes {
    /// True if the first dimension is y.
    transposed: bool,
    /// Paths of the coordinates x and y, if any.
    coordinates: [Option<String>; 2],
}

impl Axes {
    /// Finds the dimensions of a dataset of numbers with this shape, `[n, 1]` for a profile.
    fn of(reader: &Hdf5, group: &str, name: &str, shape: [usize; 2]) -> Self {
        let mut names = reader.dimensions(group, name);
        if names.iter().all(Option::is_none) {
            names = nexus_axes(reader, group);
        }
        if names.len() != if shape[1] == 1 { 1 } else { 2 } {
            names = Vec::new();
        }
        names.resize(2, None);
        let usual = ["x", "y"].map(|axis| Some(format!("{group}/{axis}")).filter(|path| reader.contains(path)));
        let is = |dimension: usize, axis: &str| {
            names[dimension].as_deref().is_some_and(|path| split(path).1.eq_ignore_ascii_case(axis))
        };
        let long = |axis: usize, points: usize| {
            usual[axis].as_deref().is_some_and(|path| reader.shape(path).is_ok_and(|shape| shape == [points]))
        };
        let is_map = shape[1] > 1;
        let by_length = || {
            let unnamed = names.iter().all(Option::is_none);
            unnamed && shape[0] != shape[1] && long(0, shape[1]) && long(1, shape[0])
        };
        let transposed = is_map && ((is(0, "y") && is(1, "x")) || by_length());
        if transposed {
            names.swap(0, 1);
        }
        let coordinate = |axis: usize| {
            let named = names[axis].clone().filter(|path| reader.contains(path));
            // Numbers of points, angles and times along an axis do not give a size.
            let is_size = |path: &String| unit_of(reader, path).is_some_and(|unit| is_length(&unit));
            let usual = usual[axis].clone();
            if named == usual { usual } else { named.filter(is_size).or(usual) }
        };
        Self { transposed, coordinates: [coordinate(0), coordinate(1)] }
    }

    /// Returns the size from the coordinates, with a negative length along an axis of falling coordinates.
    fn sides(&self, reader: &Hdf5, points: [usize; 2]) -> Result<Option<Sides>, String> {
        let length = |axis: usize| -> Result<Option<f64>, String> {
            let Some(path) = &self.coordinates[axis] else { return Ok(None) };
            if let Some(length) = reader.number_if_any(path, "length")? {
                return Ok(Some(length));
            }
            if reader.shape(path)? != [points[axis]] {
                return Ok(None);
            }
            let values = reader.physical(path)?;
            let largest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            evenly_spaced(&values, points[axis], path, reader.packing(path)?.rounding(largest))
        };
        let side =
            |axis: usize, length| (length, self.coordinates[axis].as_deref().and_then(|path| unit_of(reader, path)));
        Ok(match (length(0)?, points[1]) {
            (None, _) => None,
            (Some(x), 1) => Some(Sides::of(side(0, x), None)?),
            (Some(x), _) => match length(1)? {
                Some(y) => Some(Sides::of(side(0, x), Some(side(1, y)))?),
                None => None,
            },
        })
    }
}

/// Returns the names of the dimensions in the NeXus attribute `axes` of a group: several texts, or one with colons.
fn nexus_axes(reader: &Hdf5, group: &str) -> Vec<Option<String>> {
    let group_path = if group.is_empty() { "/" } else { group };
    let axes = reader.attribute(group_path, "axes").ok().and_then(|axes| axes.read_strings().ok()).unwrap_or_default();
    let names: Vec<&str> = match &axes[..] {
        [one] => one.trim_matches(['[', ']']).split([':', ',']).collect(),
        several => several.iter().map(String::as_str).collect(),
    };
    let path =
        |name: &str| Some(name.trim()).filter(|name| !matches!(*name, "" | ".")).map(|name| format!("{group}/{name}"));
    names.into_iter().map(path).collect()
}

/// Reads the heights of a dataset, and the lengths from its coordinates, if any.
fn read(reader: &Hdf5, dataset: &str, stored: [usize; 2], axes: &Axes) -> Result<Map, String> {
    let (group, own) = split(dataset);
    let (packing, height_unit) = scale(reader, dataset)?;
    let mut heights = shaped(stored, reader.values(dataset)?)?;
    heights.mapv_inplace(|number| packing.value(number));
    let mask = format!("{group}/mask");
    if own == "heights" && reader.contains(&mask) {
        let mask = shaped(stored, reader.values(&mask)?)?;
        heights.zip_mut_with(&mask, |height, mark| {
            if *mark != 0.0 {
                *height = f64::NAN;
            }
        });
    }
    if axes.transposed {
        heights = heights.reversed_axes();
    }
    let sides = axes.sides(reader, heights.dim().into())?;
    let mut notes = unapplied(&packing);
    let Some(Sides { mut lengths, unit, notes: of_sides }) = sides else {
        return Ok(Map { heights, height_unit, notes, ..Map::default() });
    };
    notes.extend(of_sides);
    notes.extend(rising(&mut heights, &mut lengths));
    Ok(Map { heights, lengths: Some(lengths), length_unit: unit, height_unit, notes, ..Map::default() })
}

/// Returns a note on attributes that are not applied to floats.
fn unapplied(packing: &Packing) -> Vec<String> {
    let names = packing.unknown.join(", ");
    if names.is_empty() { Vec::new() } else { vec![format!("the heights are taken as stored, not changed by {names}")] }
}

/// Returns the conversion of the numbers of a dataset to heights, and their unit.
///
/// # Errors
/// Integers without a scale; two scales.
fn scale(reader: &Hdf5, dataset: &str) -> Result<(Packing, Option<String>), String> {
    let (group, _) = split(dataset);
    let packing = reader.packing(dataset)?;
    let unit = unit_of(reader, dataset);
    let kind = reader.kind(dataset)?;
    if let Some(encoder) = Encoder::of(reader, group)? {
        if kind.is_float || packing.is_known() {
            let also = if kind.is_float { "floats" } else { "a scale of its own" };
            return Err(format!(
                "{dataset} has {also} beside the encoder of {group}; it must have integers without one"
            ));
        }
        return Ok((Packing::linear(kind, encoder.multiplier, encoder.offset)?, unit));
    }
    packing.check(dataset, unit.as_deref())?;
    if !kind.is_float && !packing.is_known() {
        for group in around(group) {
            let group = if group.is_empty() { "/" } else { group };
            let scaling = |attribute: &hdf5_reader::Attribute| is_scaling(&attribute.name);
            if let Some(found) = reader.attributes(group)?.iter().find(|attribute| scaling(attribute)) {
                let write = "write the heights as floats, or scale_factor and add_offset at the dataset";
                return Err(format!(
                    "{dataset} has integers and the group {group} the attribute {}: {write}",
                    found.name
                ));
            }
        }
    }
    Ok((packing, unit))
}

/// Scale of a JPK channel, in attributes of its group: height = multiplier times number + offset.
struct Encoder {
    multiplier: f64,
    offset: f64,
    unit: Option<String>,
}

impl Encoder {
    /// Reads the scale of physical values, or else the scale of the signal.
    fn of(reader: &Hdf5, group: &str) -> Result<Option<Self>, String> {
        for encoder in ["net-encoder.scaling", "encoder.scaling"] {
            let number = |name: &str| reader.number_if_any(group, &format!("{encoder}.{name}"));
            let Some(multiplier) = number("multiplier")? else { continue };
            let kind = reader.text(group, &format!("{encoder}.type")).unwrap_or_else(|_| "linear".into());
            if kind != "linear" {
                return Err(format!("{group}: {encoder}.type is {kind:?}; it must be linear"));
            }
            let unit = reader.text(group, &format!("{encoder}.unit.unit")).ok();
            return Ok(Some(Self { multiplier, offset: number("offset")?.unwrap_or(0.0), unit }));
        }
        Ok(None)
    }
}

/// Places of points that are stored in rows, one after the other.
#[derive(Clone)]
struct Places {
    points: [usize; 2],
    /// Dataset with the place of each row; without one, x runs fastest.
    values: Option<String>,
    lengths: Option<[f64; 2]>,
    unit: Option<String>,
}

impl Places {
    /// Finds the number of frames and the places of the points of a dataset in `group`, if they are stored in rows.
    fn of(reader: &Hdf5, group: &str, shape: &[usize], places: &[String]) -> Result<Option<(usize, Self)>, String> {
        let (rows, frames) = match *shape {
            [rows] => (rows, 1),
            [rows, frames] if frames <= MOST_FRAMES => (rows, frames),
            _ => return Ok(None),
        };
        for group in around(group) {
            let path = if group.is_empty() { "/" } else { group };
            let number = |name: &str| reader.number_if_any(path, &format!("{GRID}{name}"));
            if let (Some(nx), Some(ny)) = (number("ilength")?, number("jlength")?)
                && nx * ny == rows as f64
                && nx >= 2.0
                && ny >= 2.0
            {
                let points = whole(nx).zip(whole(ny)).map(|(x, y)| [x, y]);
                let points =
                    points.ok_or_else(|| format!("{path}: the grid has {nx} by {ny} points; both must be whole"))?;
                let lengths = number("ulength")?.zip(number("vlength")?).map(|(x, y)| [x, y]);
                let found = Self { points, values: None, lengths, unit: lengths.map(|_| "m".into()) };
                return Ok(Some((frames, found)));
            }
            let values = format!("{group}/{PLACES}");
            if places.contains(&values) && reader.shape(&values)? == [rows, 2] {
                let [x, y] = Self::axes(reader, &values)?;
                if x.count.checked_mul(y.count) != Some(rows) {
                    return Err(format!("{values} has {rows} places on {} by {}; they must fill it", x.count, y.count));
                }
                if x.count < 2 || y.count < 2 {
                    return Ok(None);
                }
                let unit = unit_of(reader, &values).filter(|unit| is_length(unit));
                let lengths = unit.as_ref().map(|_| [x.step * x.count as f64, y.step * y.count as f64]);
                let found = Self { points: [x.count, y.count], values: Some(values), lengths, unit };
                return Ok(Some((frames, found)));
            }
        }
        Ok(None)
    }

    /// Returns the lattices of x and y.
    fn axes(reader: &Hdf5, values: &str) -> Result<[Lattice; 2], String> {
        let places: Vec<f64> = reader.physical(values)?;
        let axis = |axis: usize| Lattice::of(places.iter().skip(axis).step_by(2).copied());
        let both = axis(0).zip(axis(1)).map(|(x, y)| [x, y]);
        both.ok_or_else(|| format!("{values} has places that are on no lattice; they must be on one"))
    }

    /// Reads a frame of a dataset.
    fn read(&self, reader: &Hdf5, dataset: &str, [frame, frames]: [usize; 2]) -> Result<Map, String> {
        let (packing, height_unit) = scale(reader, dataset)?;
        let values: Vec<f64> = reader.values(dataset)?;
        let mut notes = unapplied(&packing);
        let [nx, ny] = self.points;
        let mut heights = Array2::from_elem((nx, ny), f64::NAN);
        let numbers = values.iter().skip(frame).step_by(frames);
        if let Some(values) = &self.values {
            let [x, y] = Self::axes(reader, values)?;
            let places: Vec<f64> = reader.physical(values)?;
            let mut seen = Array2::from_elem((nx, ny), false);
            for (place, number) in places.chunks_exact(2).zip(numbers) {
                let place = [x.index(place[0]), y.index(place[1])];
                if std::mem::replace(&mut seen[place], true) {
                    return Err(format!("{values} has the place {place:?} twice; each point must have its own"));
                }
                heights[place] = packing.value(*number);
            }
            if self.lengths.is_none() {
                notes.push(format!("{values} has no unit of length; the size is not read (it may be given)"));
            }
        } else {
            for (row, number) in numbers.enumerate().take(nx * ny) {
                heights[[row % nx, row / nx]] = packing.value(*number);
            }
        }
        let (lengths, length_unit) = (self.lengths, self.unit.clone());
        Ok(Map { heights, lengths, length_unit, height_unit, notes, ..Map::default() })
    }
}

/// Converts a number to a count if it is a whole number.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number that is not negative")]
fn whole(number: f64) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0 && number < 1e9).then_some(number as usize)
}

/// Returns the unit of a dataset, or of its encoder if it has one; "length" and "1" denote any consistent unit.
fn unit_of(reader: &Hdf5, dataset: &str) -> Option<String> {
    let (group, _) = split(dataset);
    let of_encoder = || Encoder::of(reader, group).ok().flatten().and_then(|encoder| encoder.unit);
    let own = || reader.text(dataset, "units").or_else(|_| reader.text(dataset, "unit")).ok();
    of_encoder().or_else(own).filter(|unit| !CONSISTENT.contains(&unit.trim()))
}
