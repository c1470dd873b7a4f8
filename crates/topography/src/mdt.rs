//! NT-MDT (`.mdt`): force and tunnelling microscopes of NT-MDT. Numbers are little-endian.
//!
//! Frames with their lengths and types. Scans (type 0) have three axes with offset, step and unit, and 16-bit counts;
//! frames with several dimensions (type 106) have a calibration of each axis and of the numbers. Spectra, texts and
//! palettes are left out. The first line of a frame is the bottom of the picture.

use super::bytes::{Bytes, Grid, MOST_CHANNELS, Order, Sample, clip, count, factor};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, size};
use super::unit::{Sides, is_length};

pub(crate) const FORMAT: Format = Format { name: "NT-MDT", sniff, open, first_line: FirstLine::Bottom };

/// Positions of the number of the last frame and of the first frame.
const LAST: usize = 12;
const FIRST: usize = 33;

/// Length of the head of a frame.
const HEAD: usize = 22;

/// Types of frames.
const SCAN: u16 = 0;
const DIMENSIONS: u16 = 106;

/// Units of the axes of a scan, from -5 on, and the SI code of the metre.
const UNITS: [&str; 6] = ["m", "cm", "mm", "µm", "nm", "Å"];
const METRE: u64 = 0x101;

/// Names of the signals of a scan.
const SIGNALS: [&str; 4] = ["Height", "DFL", "Lateral F", "Bias V"];

fn sniff(file: &File) -> bool {
    file.starts_with(b"\x01\xb0\x93\xff")
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let all = file.bytes()?;
    let mut bytes = Bytes::new(all, Order::Little);
    bytes.seek(LAST)?;
    let frames = usize::from(bytes.u16()?) + 1;
    bytes.seek(FIRST)?;
    let (mut channels, mut others) = (Vec::new(), Vec::new());
    for number in 0..frames {
        let start = bytes.at();
        let length = bytes.u32()? as usize;
        let kind = bytes.u16()?;
        bytes.seek(start)?;
        let frame = bytes.take(length)?;
        let found = match kind {
            SCAN => scan(frame),
            DIMENSIONS => dimensions(frame, all),
            other => Ok(Err(format!("type {other}"))),
        };
        match found.map_err(|error| format!("frame {number}: {error}"))? {
            Ok(channel) if channels.len() < MOST_CHANNELS => channels.push(channel),
            Ok(_) => return Err(format!("the file has more than {MOST_CHANNELS} maps; it must have fewer")),
            Err(what) if others.len() < 10 => others.push(what),
            Err(_) => {}
        }
    }
    match channels.is_empty() {
        true => Err(format!("the frames are {}; one must be a map in a unit of length", others.join(", "))),
        false => Ok(channels.into()),
    }
}

/// Channel, or else the description of a frame that is not a height map.
type Found<'a> = Result<Channel<'a>, String>;

/// Reads the axis of a scan: offset, step and unit.
fn axis(bytes: &mut Bytes) -> Result<(f64, f64, Option<&'static str>), String> {
    let (offset, step, unit) = (bytes.f32()?, bytes.f32()?, bytes.i16()?);
    let unit = usize::try_from(i32::from(unit) + 5).ok().and_then(|index| UNITS.get(index));
    Ok((offset.into(), step.into(), unit.copied()))
}

/// Reads a frame of type 0.
fn scan(frame: &[u8]) -> Result<Found<'_>, String> {
    let mut bytes = Bytes::new(frame, Order::Little);
    bytes.seek(HEAD - 2)?;
    let variables = usize::from(bytes.u16()?);
    let [(_, dx, x), (_, dy, y), (offset, step, z)] = [axis(&mut bytes)?, axis(&mut bytes)?, axis(&mut bytes)?];
    let signal = usize::from(bytes.u8()?);
    bytes.seek(HEAD + variables)?;
    bytes.skip(2)?;
    let points = [bytes.u16()?, bytes.u16()?];
    let dots = usize::from(bytes.u16()?);
    if dots > 0 {
        bytes.skip(14 + 16 * dots)?;
    }
    let name = SIGNALS.get(signal).map_or_else(|| format!("signal {signal}"), |name| (*name).to_owned());
    let (Some(x), Some(y), Some(z)) = (x, y, z) else { return Ok(Err(format!("{name} without a unit of length"))) };
    let points = [count("the number of columns", points[0])?, count("the number of lines", points[1])?];
    let step = factor("the height of a count", step)?;
    let grid = Grid::lines(points, Sample::I16, Order::Little);
    let data = bytes.take(grid.bytes()?)?;
    let title = match bytes.u32() {
        Ok(length) => bytes.take(length as usize).map(cyrillic).unwrap_or_default(),
        Err(_) => String::new(),
    };
    let map = map(points, [(dx, x), (dy, y)], z)?;
    let name = if title.is_empty() { name } else { format!("{name} ({title})") };
    Channel::of_grid(name, grid, data, map, move |found| step * found + offset).map(Ok)
}

/// Returns a map without its heights.
fn map(points: [usize; 2], axes: [(f64, &str); 2], height_unit: &str) -> Result<Map, String> {
    let spacing = [axes[0].0.abs(), axes[1].0.abs()];
    for spacing in spacing {
        factor("the spacing", spacing)?;
    }
    let lengths = size(points, spacing);
    let side = |axis: usize| (lengths[axis], Some(axes[axis].1.to_owned()));
    let sides = Sides::of(side(0), Some(side(1)).filter(|_| points[1] > 1))?;
    Ok(Map {
        lengths: Some(sides.lengths),
        length_unit: sides.unit,
        height_unit: Some(height_unit.to_owned()),
        notes: sides.notes,
        ..Map::default()
    })
}

/// Calibration of an axis or of the numbers of a frame.
struct Calibration {
    name: String,
    unit: Option<String>,
    bias: f64,
    scale: f64,
    points: u64,
    kind: i32,
}

impl Calibration {
    fn read(bytes: &mut Bytes) -> Result<Self, String> {
        let start = bytes.at();
        let total = bytes.u32()? as usize;
        let length = bytes.u32()? as usize;
        let texts = bytes.at().saturating_add(length);
        let lengths = [bytes.u32()? as usize, bytes.u32()? as usize, bytes.u32()? as usize];
        let code = bytes.u64()?;
        bytes.skip(16)?;
        let [bias, scale] = [bytes.f64()?, bytes.f64()?];
        let [first, last] = [bytes.u64()?, bytes.u64()?];
        let kind = bytes.i32()?;
        bytes.seek(texts)?;
        let name = cyrillic(bytes.take(lengths[0])?);
        bytes.skip(lengths[1])?;
        let unit = cyrillic(bytes.take(lengths[2])?);
        bytes.seek(start.saturating_add(total))?;
        let unit = match (unit.as_str(), code) {
            ("", METRE) => Some("m".to_owned()),
            ("", _) => None,
            _ => Some(unit),
        };
        let points = last.checked_sub(first).and_then(|count| count.checked_add(1)).unwrap_or(0);
        Ok(Self { name, unit, bias, scale, points, kind })
    }

    fn length_unit(&self) -> Option<&str> {
        self.unit.as_deref().filter(|unit| is_length(unit))
    }

    fn sample(&self) -> Result<Sample, String> {
        Ok(match self.kind {
            -1 => Sample::I8,
            1 => Sample::U8,
            -2 => Sample::I16,
            2 => Sample::U16,
            -4 => Sample::I32,
            4 => Sample::U32,
            -8 => Sample::I64,
            8 => Sample::U64,
            -5892 => Sample::F32,
            -13320 => Sample::F64,
            other => return Err(format!("the numbers have type {other}; they must be integers or floats")),
        })
    }
}

/// Reads a frame of type 106, whose data are counted from the start of the file.
fn dimensions<'a>(frame: &'a [u8], all: &'a [u8]) -> Result<Found<'a>, String> {
    let mut bytes = Bytes::new(frame, Order::Little);
    bytes.seek(HEAD)?;
    let head = bytes.u32()? as usize;
    bytes.skip(4 + 36)?;
    let mut lengths = [0; 6];
    for length in &mut lengths {
        *length = bytes.u32()? as usize;
    }
    let [data_start, data_length] = [bytes.u32()? as usize, bytes.u32()? as usize];
    bytes.seek(HEAD.saturating_add(head))?;
    let name = cyrillic(bytes.take(lengths[0])?);
    for length in &lengths[1..5] {
        bytes.skip(*length)?;
    }
    bytes.skip(4)?;
    let length = bytes.u32()? as usize;
    let mut variables = Bytes::new(bytes.take(length)?, Order::Little);
    variables.skip(12)?;
    let [axes, measured] = [variables.u32()?, variables.u32()?];
    if (axes, measured) != (2, 1) {
        return Ok(Err(format!("{} of {axes} dimensions and {measured} quantities", clip(&name))));
    }
    let [x, y, z] = [Calibration::read(&mut bytes)?, Calibration::read(&mut bytes)?, Calibration::read(&mut bytes)?];
    let (Some(x_unit), Some(y_unit), Some(z_unit)) = (x.length_unit(), y.length_unit(), z.length_unit()) else {
        return Ok(Err(format!("{} in {:?}", clip(&name), clip(z.unit.as_deref().unwrap_or_default()))));
    };
    let points = [count("the number of columns", x.points)?, count("the number of lines", y.points)?];
    let [scale, bias] = [factor("the height of a count", z.scale)?, z.bias];
    let grid = Grid::lines(points, z.sample()?, Order::Little);
    let mut data = Bytes::new(all, Order::Little);
    data.seek(data_start)?;
    let data = data.take(data_length)?;
    let map = map(points, [(x.scale, x_unit), (y.scale, y_unit)], z_unit)?;
    let name = if name.is_empty() { z.name } else { name };
    Channel::of_grid(name, grid, data, map, move |found| bias + scale * found).map(Ok)
}

/// Decodes a text in Windows-1251.
fn cyrillic(bytes: &[u8]) -> String {
    let character = |byte: &u8| match byte {
        0..=0x7f => char::from(*byte),
        0xb5 => 'µ',
        0xb0 => '°',
        0xa8 => 'Ё',
        0xb8 => 'ё',
        0xc0..=0xff => char::from_u32(0x410 + u32::from(*byte) - 0xc0).unwrap_or(char::REPLACEMENT_CHARACTER),
        _ => char::REPLACEMENT_CHARACTER,
    };
    bytes.iter().take_while(|byte| **byte != 0).map(character).collect::<String>().trim().to_owned()
}
