//! Igor binary waves (`.ibw`): images of Asylum Research, and arrays of Igor Pro, versions 1, 2, 3 and 5, either
//! endian.
//!
//! Version 5 has up to four dimensions, stored with the first running fastest: x, y (from the bottom), and the channel;
//! channel names are the labels of the last. A wave of two dimensions is one image if it is square or both its
//! dimensions are lengths, otherwise a set of curves; older versions have curves only. Asylum Research writes the unit
//! of the first channel for all of them; the unit of a channel then follows from its name.

use std::rc::Rc;

use super::bytes::{Bytes, Grid, Layout, MOST_CHANNELS, Order, Sample, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::unit::{self, Sides};

pub(crate) const FORMAT: Format = Format { name: "Igor binary wave", sniff, open, first_line: FirstLine::Top };

/// Number of bytes of the wave header, in version 5 and before.
const WAVE_5: usize = 320;
const WAVE_2: usize = 110;

/// Prefixes of Asylum's names of height channels.
const HEIGHTS: [&str; 4] = ["Height", "ZSensor", "Deflection", "Amplitude"];

/// Lines of the note listed in the details, and their names there.
const DETAILS: [(&str, &str); 6] = [
    ("MicroscopeModel", "instrument"),
    ("Date", "date"),
    ("Time", "time"),
    ("IgorFileVersion", "version of Igor"),
    ("Version", "version of the software"),
    ("ImagingMode", "mode"),
];

fn sniff(file: &File) -> bool {
    let Some((order, version)) = version(file.head()) else { return false };
    let at = match version {
        5 => 64 + 16,
        3 => 20,
        2 => 16,
        _ => 8,
    };
    let mut bytes = Bytes::new(file.head(), order);
    let known = bytes.seek(at).and_then(|()| bytes.i16()).is_ok_and(|kind| sample(kind).is_some());
    // Waves of texts and of complex numbers are recognised only if the checksum of their headers is correct.
    let headers = if version == 5 { 64 + WAVE_5 } else { at + WAVE_2 };
    known || checksum(bytes, headers).unwrap_or(false)
}

/// Reads byte order and version from the first two bytes.
fn version(head: &[u8]) -> Option<(Order, u8)> {
    match *head.get(..2)? {
        [version @ (1 | 2 | 3 | 5), 0] => Some((Order::Little, version)),
        [0, version @ (1 | 2 | 3 | 5)] => Some((Order::Big, version)),
        _ => None,
    }
}

/// Returns the type of the numbers of a wave; `None` for text and complex numbers.
fn sample(kind: i16) -> Option<Sample> {
    Some(match kind {
        0x02 => Sample::F32,
        0x04 => Sample::F64,
        0x08 => Sample::I8,
        0x10 => Sample::I16,
        0x20 => Sample::I32,
        0x48 => Sample::U8,
        0x50 => Sample::U16,
        0x60 => Sample::U32,
        _ => return None,
    })
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let all = file.bytes()?;
    let Some((order, version)) = version(all) else {
        return Err("the version is unknown; it must be 1, 2, 3 or 5".into());
    };
    let bytes = Bytes::new(all, order);
    let wave = if version == 5 { Wave::version_5(bytes)? } else { Wave::older(bytes, version)? };
    wave.channels(order)
}

/// Wave: entries of its headers, and its numbers before decoding.
struct Wave<'a> {
    sample: Sample,
    /// Number of elements along each dimension, 0 after the last.
    points: [usize; 4],
    spacing: [f64; 2],
    data_unit: String,
    units: [String; 2],
    data: &'a [u8],
    note: String,
    /// Labels of the channels.
    labels: Vec<String>,
    /// True if the checksum of the headers is correct.
    sound: bool,
}

/// Returns true if the sum of the first `count` bytes as 16-bit numbers is 0, as in undamaged headers.
fn checksum(mut bytes: Bytes, count: usize) -> Result<bool, String> {
    bytes.seek(0)?;
    let mut sum = 0_i16;
    for _ in 0..count / 2 {
        sum = sum.wrapping_add(bytes.i16()?);
    }
    Ok(sum == 0)
}

fn size(name: &str, value: i32) -> Result<usize, String> {
    usize::try_from(value).map_err(|_| format!("the size of the {name} is {value}; it must not be negative"))
}

fn kind(number: i16) -> Result<Sample, String> {
    sample(number).ok_or_else(|| format!("the wave has type {number}; it must be one of real numbers"))
}

impl<'a> Wave<'a> {
    fn version_5(mut bytes: Bytes<'a>) -> Result<Self, String> {
        let sound = checksum(bytes, 64 + WAVE_5)?;
        bytes.skip(4)?;
        let wave_size = size("wave", bytes.i32()?)?;
        let (formula, note) = (size("formula", bytes.i32()?)?, size("note", bytes.i32()?)?);
        let data_unit_size = size("unit", bytes.i32()?)?;
        let (mut unit_sizes, mut label_sizes) = ([0; 4], [0; 4]);
        for length in unit_sizes.iter_mut().chain(&mut label_sizes) {
            *length = size("labels", bytes.i32()?)?;
        }
        bytes.seek(64 + 16)?;
        let sample = kind(bytes.i16()?)?;
        bytes.seek(64 + 68)?;
        let mut points = [0; 4];
        for number in &mut points {
            *number = size("dimension", bytes.i32()?)?;
        }
        let spacing = [bytes.f64()?, bytes.f64()?];
        bytes.seek(64 + 148)?;
        let mut data_unit = bytes.text(4)?;
        let mut units = [bytes.text(4)?, bytes.text(4)?];
        bytes.seek(64 + WAVE_5)?;
        let data = bytes.take(wave_size.saturating_sub(WAVE_5))?;
        bytes.skip(formula)?;
        let note = bytes.text(note)?;
        let long = bytes.text(data_unit_size)?;
        if !long.is_empty() {
            data_unit = long;
        }
        for (dimension, length) in unit_sizes.into_iter().enumerate() {
            let long = bytes.text(length)?;
            if let (Some(unit), false) = (units.get_mut(dimension), long.is_empty()) {
                *unit = long;
            }
        }
        let dimension = if points[2] == 0 && points[1] != points[0] { 1 } else { 2 };
        let mut labels = vec![];
        for (index, length) in label_sizes.into_iter().enumerate() {
            let block = bytes.take(length)?;
            if index == dimension {
                // The first label names the dimension itself.
                labels = block.chunks_exact(32).skip(1).take(MOST_CHANNELS).map(text).collect();
            }
        }
        Ok(Self { sample, points, spacing, data_unit, units, data, note, labels, sound })
    }

    fn older(mut bytes: Bytes<'a>, version: u8) -> Result<Self, String> {
        let header = match version {
            1 => 8,
            2 => 16,
            _ => 20,
        };
        let sound = checksum(bytes, header + WAVE_2)?;
        bytes.skip(2)?;
        let wave_size = size("wave", bytes.i32()?)?;
        let note = if version == 1 { 0 } else { size("note", bytes.i32()?)? };
        bytes.seek(header)?;
        let sample = kind(bytes.i16()?)?;
        bytes.seek(header + 34)?;
        let (data_unit, unit) = (bytes.text(4)?, bytes.text(4)?);
        let points = [size("dimension", bytes.i32()?)?, 0, 0, 0];
        bytes.skip(2)?;
        let spacing = [bytes.f64()?, 1.0];
        bytes.seek(header + WAVE_2)?;
        let data = bytes.take(wave_size.saturating_sub(WAVE_2 + 16))?;
        let note = if note == 0 {
            String::new()
        } else {
            bytes.skip(16)?;
            bytes.text(note)?
        };
        Ok(Self { sample, points, spacing, data_unit, units: [unit, String::new()], data, note, labels: vec![], sound })
    }

    fn channels(self, order: Order) -> Result<Contents<'a>, String> {
        let [nx, ny, layers, more] = self.points;
        if more != 0 {
            return Err(format!("the wave has four dimensions, {:?}; it must have at most three", self.points));
        }
        let lengths = self.units.iter().all(|unit| unit::is_length(unit));
        let is_image = ny != 0 && (layers != 0 || nx == ny || lengths);
        let (points, number) = match (is_image, layers, ny) {
            (true, layers, _) => ([nx, ny], layers.max(1)),
            (false, _, curves) => ([nx, 1], curves.max(1)),
        };
        if number > MOST_CHANNELS {
            return Err(format!("the wave has {number} channels; it must have at most {MOST_CHANNELS}"));
        }
        let grid = Grid { points, sample: self.sample, order, layout: Layout::Lines, backwards: [false, is_image] };
        let size = grid.bytes()?;
        if size.saturating_mul(number) > self.data.len() {
            return Err(format!(
                "the {number} channels of {} by {} points have {} bytes; they must have {size} each",
                points[0],
                points[1],
                self.data.len()
            ));
        }
        let details: Rc<[(String, String)]> = details(&self.note).into();
        let (mut channels, mut others) = (vec![], vec![]);
        for index in 0..number {
            let name = self.labels.get(index).cloned().unwrap_or_default();
            let unit = match self.labels.get(index) {
                Some(name) if !self.note.is_empty() => asylum_unit(name, &self.note),
                _ => Some(self.data_unit.clone()),
            };
            let Some(unit) = unit.filter(|unit| unit.is_empty() || unit::is_length(unit)) else {
                others.push(name);
                continue;
            };
            let data = &self.data[index * size..][..size];
            channels.push(self.channel(name, unit, grid, data, Rc::clone(&details)));
        }
        if channels.is_empty() {
            return Err(format!("the channels are {}; one must be a height", others.join(", ")));
        }
        Ok(channels.into())
    }

    fn channel(
        &self,
        name: String,
        unit: String,
        grid: Grid,
        data: &'a [u8],
        details: Rc<[(String, String)]>,
    ) -> Channel<'a> {
        let [nx, ny] = grid.points;
        let [dx, dy] = self.spacing.map(f64::abs);
        let unit = Some(unit).filter(|unit| !unit.is_empty());
        let mut sides = self.units.iter().map(|unit| Some(unit.clone()).filter(|unit| !unit.is_empty()));
        let mut side = |length: f64| (length, sides.next().flatten());
        let x = side(dx * nx as f64);
        let sides = Sides::of(x, (ny > 1).then(|| side(dy * ny as f64)));
        let warning = (!self.sound).then(|| "the checksum of the header is wrong".to_owned());
        let (height_unit, points) = (unit.clone(), grid.points);
        let read = move || {
            let Sides { lengths, unit: length_unit, notes } = sides?;
            let heights = grid.read(data, |height| height)?;
            // Igor gives every wave a spacing of 1 without a unit, which means an unknown size.
            let is_set = length_unit.is_some() || [dx, if ny == 1 { 1.0 } else { dy }] != [1.0; 2];
            let lengths = is_set.then_some(lengths);
            let (details, warnings) = (details.to_vec(), warning.into_iter().collect());
            Ok(Map { heights, lengths, length_unit, height_unit, details, notes, warnings })
        };
        Channel { name, unit, points, read: Box::new(read) }
    }
}

/// Returns the value of a line `key: value` of a note.
fn line<'a>(note: &'a str, key: &str) -> Option<&'a str> {
    note.split(['\r', '\n'])
        .find_map(|line| line.split_once(':').filter(|(name, _)| name.trim() == key))
        .map(|(_, v)| v.trim())
}

fn details(note: &str) -> Vec<(String, String)> {
    let found = DETAILS.iter().filter_map(|(key, name)| Some(((*name).to_owned(), line(note, key)?.to_owned())));
    found.filter(|(_, value)| !value.is_empty()).collect()
}

/// Returns the unit of an Asylum Research channel: the value of a line `<name>Unit` of the note, or metres if the name
/// denotes a height. The name has a suffix for modulation and direction, and can have a prefix.
fn asylum_unit(name: &str, note: &str) -> Option<String> {
    let base = match name.rfind("Mod") {
        Some(at) if name[at + 3..].bytes().all(|byte| byte.is_ascii_digit()) => &name[..at],
        _ => name,
    };
    let base = base.strip_suffix("Trace").or_else(|| base.strip_suffix("Retrace")).unwrap_or(base);
    if let Some(unit) = line(note, &format!("{base}Unit")) {
        return Some(unit.to_owned()).filter(|unit| !unit.is_empty());
    }
    let base = base.strip_prefix("DAC").or_else(|| base.strip_prefix("Nap")).unwrap_or(base);
    HEIGHTS.iter().any(|height| base.starts_with(height)).then(|| "m".into())
}
