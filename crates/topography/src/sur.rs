//! Digital Surf (`.sur`, `.pro`): surfaces and profiles of MountainsMap and of many instruments, also compressed.
//!
//! A file is a sequence of objects, each a header of 512 bytes, a comment, a private zone, and 16-bit or 32-bit
//! integers line by line. A height is the integer times the spacing along z, in the unit *of that spacing* (the header
//! also names display units). Points that were not measured have the integer `smallest - 2`. The offset along z only
//! moves the whole surface; it is listed in the details and not added. Bytes after the last object give a warning.

use flate2::bufread::ZlibDecoder;
use std::io::Read;

use super::bytes::{Bytes, Grid, Layout, Order, Sample, count};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::unit::{self, Conversion};

pub(crate) const FORMAT: Format = Format { name: "Digital Surf", sniff, open, first_line: FirstLine::Top };

const PLAIN: &[u8] = b"DIGITAL SURF";
const COMPRESSED: &[u8] = b"DSCOMPRESSED";

/// Types of the first object with heights as data, and the objects that hold heights; the others are images.
const TYPES: [(i16, Heights); 9] = [
    (1, Heights::First),
    (2, Heights::First),
    (5, Heights::All),
    (7, Heights::All),
    (8, Heights::All),
    (9, Heights::All),
    (11, Heights::First),
    (13, Heights::First),
    (16, Heights::First),
];

/// Objects of a file that hold heights.
#[derive(Clone, Copy, PartialEq)]
enum Heights {
    First,
    All,
}

fn sniff(file: &File) -> bool {
    file.starts_with(PLAIN) || file.starts_with(COMPRESSED)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut bytes = Bytes::new(file.bytes()?, Order::Little);
    let kind = {
        let mut start = bytes;
        start.skip(18)?;
        start.i16()?
    };
    let Some((_, heights)) = TYPES.iter().find(|(known, _)| *known == kind) else {
        return Err(format!("the data have type {kind}; they must be a surface (2) or a profile (1)"));
    };
    let first = Object::read(&mut bytes)?;
    let objects = match heights {
        Heights::First => 1,
        Heights::All => first.objects,
    };
    let all = first.objects;
    let mut channels = vec![];
    let mut object = first;
    for index in 0..objects {
        if index > 0 {
            object = Object::read(&mut bytes)?;
        }
        if !unit::is_length(&object.units[2]) {
            return Err(format!(
                "object {index} is {:?} in {:?}; it must be a height with a unit of length",
                object.axis, object.units[2]
            ));
        }
        channels.push(object.clone().channel());
    }
    // Objects without heights may follow.
    let (end, found) = (bytes.at(), bytes.at() + bytes.left());
    let is_longer = objects == all && found > end;
    let warnings = is_longer.then(|| {
        format!(
            "the file has {found} bytes, and its heights end at byte {end}; bytes may have been inserted before, which \
             spoils the heights behind them"
        )
    });
    Ok(Contents { warnings: warnings.into_iter().collect(), ..channels.into() })
}

/// Object: entries of its header, and its data before decoding.
#[derive(Clone)]
struct Object<'a> {
    /// Number of objects in the file, from the header of the first.
    objects: usize,
    grid: Grid,
    /// Integer of a point that was not measured.
    missing: Option<f64>,
    spacing: [f64; 3],
    units: [String; 3],
    /// -1 if the heights are stored upside down.
    sign: f64,
    axis: String,
    details: Vec<(String, String)>,
    data: &'a [u8],
    /// Lengths of the compressed streams in `data`.
    streams: Option<Vec<usize>>,
}

impl<'a> Object<'a> {
    fn read(bytes: &mut Bytes<'a>) -> Result<Self, String> {
        let compressed = match bytes.take(12)? {
            PLAIN => false,
            COMPRESSED => true,
            other => return Err(format!("an object starts with {other:?}; it must start with \"DIGITAL SURF\"")),
        };
        let format = bytes.u16()?;
        if format != 0 {
            return Err(format!("the byte order has number {format}; it must be 0, that of PCs"));
        }
        let number = bytes.i16()?;
        bytes.skip(2 + 2)?;
        let (name, operator) = (bytes.text(30)?, bytes.text(30)?);
        let channels = bytes.i16()?;
        let acquisition = bytes.i16()?;
        bytes.skip(2)?;
        let special = bytes.i16()?;
        bytes.skip(2 + 4 + 4)?;
        let sample = match bytes.i16()? {
            16 => Sample::I16,
            32 => Sample::I32,
            bits => return Err(format!("a height has {bits} bits; it must have 16 or 32")),
        };
        let smallest = bytes.i32()?;
        bytes.skip(4)?;
        let points =
            [count("the number of points of a line", bytes.i32()?)?, count("the number of lines", bytes.i32()?)?];
        let total = bytes.i32()?;
        if usize::try_from(total).ok() != points[0].checked_mul(points[1]) {
            return Err(format!("the number of points is {total}; it must be {} times {}", points[0], points[1]));
        }
        let spacing = [f64::from(bytes.f32()?), f64::from(bytes.f32()?), f64::from(bytes.f32()?)];
        bytes.skip(2 * 16)?;
        let axis = bytes.text(16)?;
        let units = [unit_text(bytes)?, unit_text(bytes)?, unit_text(bytes)?];
        bytes.skip(3 * 16 + 3 * 4 + 2)?;
        let inversion = bytes.i16()?;
        bytes.skip(2 + 12)?;
        let mut date = [0; 6];
        for part in &mut date {
            *part = bytes.i16()?;
        }
        bytes.skip(2 + 4)?;
        bytes.skip(4 + 6)?;
        let (comment_size, private_size) = (bytes.u16()?, bytes.u16()?);
        bytes.skip(128 + 2 * 4)?;
        let offset = bytes.f32()?;
        bytes.skip(4 + 4 + 13 + 13)?;
        let comment = bytes.text(comment_size.into())?;
        bytes.skip(private_size.into())?;

        // The numbers 2 and 3 also mirror the surface, left to right and upside down.
        let backwards = [inversion == 2, inversion == 3];
        let grid = Grid { points, sample, order: Order::Little, layout: Layout::Lines, backwards };
        let (data, streams) = if compressed { streams(bytes, grid)? } else { (bytes.take(grid.bytes()?)?, None) };
        let [second, minute, hour, day, month, year] = date;
        let mut details: Vec<(String, String)> = [("object", name), ("operator", operator), ("comment", comment)]
            .into_iter()
            .filter(|(_, value)| !value.is_empty())
            .map(|(key, value)| (key.to_owned(), value))
            .collect();
        if year > 0 {
            let date = format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}");
            details.push(("date".into(), date));
        }
        if let Some(acquisition) = usize::try_from(acquisition).ok().and_then(|kind| ACQUISITION.get(kind)) {
            details.push(("acquisition".into(), (*acquisition).into()));
        }
        if offset != 0.0 {
            details.push(("offset of the heights, not added".into(), format!("{offset} {}", units[2])));
        }
        Ok(Self {
            objects: usize::from(number.max(1).unsigned_abs()) * usize::from(channels.max(1).unsigned_abs()),
            grid,
            missing: (special == 1).then(|| f64::from(smallest) - 2.0),
            spacing,
            units,
            sign: if matches!(inversion, 1..=3) { -1.0 } else { 1.0 },
            axis,
            details,
            data,
            streams,
        })
    }

    fn channel(self) -> Channel<'a> {
        Channel {
            name: self.axis.clone(),
            unit: Some(self.units[2].clone()),
            points: self.grid.points,
            read: Box::new(move || self.map()),
        }
    }

    fn map(self) -> Result<Map, String> {
        let scale = self.sign * self.spacing[2];
        let height = |value: f64| if Some(value) == self.missing { f64::NAN } else { scale * value };
        let heights = match &self.streams {
            None => self.grid.read(self.data, height)?,
            Some(streams) => {
                let mut rest = self.data;
                let mut decoders = streams.iter().map(move |&length| {
                    let (stream, after) = rest.split_at(length);
                    rest = after;
                    ZlibDecoder::new(stream)
                });
                self.grid.inflate(self.data.len(), Chain { now: decoders.next(), later: decoders }, height)?
            }
        };
        let [nx, ny] = self.grid.points;
        let [dx, dy, _] = self.spacing;
        let [unit_x, unit_y, unit_z] = self.units;
        let mut lengths = [dx * nx as f64, 1.0];
        if ny > 1 {
            let length = dy * ny as f64;
            let conversion = Conversion::between(&unit_y, &unit_x)?;
            lengths[1] = conversion.map_or(length, |conversion| conversion.apply(length));
        }
        Ok(Map {
            heights,
            lengths: Some(lengths),
            length_unit: Some(unit_x),
            height_unit: Some(unit_z),
            details: self.details,
            ..Map::default()
        })
    }
}

const ACQUISITION: [&str; 11] = [
    "unknown",
    "stylus",
    "optical gauge",
    "thermocouple",
    "unknown",
    "stylus with skid",
    "AFM",
    "STM",
    "video",
    "interferometer",
    "structured light",
];

/// Reads a unit. Old files write the micro sign in an MS-DOS code page, where it has the byte of the letter `æ`.
fn unit_text(bytes: &mut Bytes) -> Result<String, String> {
    Ok(match bytes.text(16)?.as_str() {
        "æm" => "µm".into(),
        unit => unit.into(),
    })
}

/// Takes the compressed data of an object: the number of streams, the sizes of each before and after, the streams.
fn streams<'a>(bytes: &mut Bytes<'a>, grid: Grid) -> Result<(&'a [u8], Option<Vec<usize>>), String> {
    let number = bytes.u32()? as usize;
    let mut directory = Bytes::new(bytes.take(number.saturating_mul(8))?, Order::Little);
    let (mut raw, mut compressed, mut lengths) = (0_usize, 0_usize, vec![]);
    for _ in 0..number {
        raw = raw.saturating_add(directory.u32()? as usize);
        let length = directory.u32()? as usize;
        compressed = compressed.saturating_add(length);
        lengths.push(length);
    }
    let needed = grid.bytes()?;
    if raw != needed {
        return Err(format!("the compressed heights have {raw} bytes; they must have {needed}"));
    }
    Ok((bytes.take(compressed)?, Some(lengths)))
}

/// Streams read one after the other.
struct Chain<R, I> {
    now: Option<R>,
    later: I,
}

impl<R: Read, I: Iterator<Item = R>> Read for Chain<R, I> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        while let Some(stream) = &mut self.now {
            let count = stream.read(buffer)?;
            if count > 0 || buffer.is_empty() {
                return Ok(count);
            }
            self.now = self.later.next();
        }
        Ok(0)
    }
}
