//! Wyko OPD (`.opd`): interferometers of Wyko, Veeco and Bruker, written by Vision.
//!
//! A directory of blocks, each a name of 16 bytes, a type, a length and a flag, 24 bytes together; the blocks follow in
//! the order of the directory. A block of heights has its numbers of points and bytes before the data, column by column
//! from the bottom. The height is the number times the wavelength divided by `Mult`, in nm; lengths are in mm, and
//! pixels are `Aspect` times as long along y. Undefined points are 32766 and above, in floats 1e38 and above.

use std::rc::Rc;

use super::bytes::{Bytes, Grid, Layout, MOST_CHANNELS, Order, Sample, count};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format = Format { name: "Wyko OPD", sniff, open, first_line: FirstLine::Top };

/// Number of bytes of a directory entry.
const ENTRY: usize = 24;
/// Names of the blocks of heights; other arrays are intensities.
const HEIGHTS: [&str; 5] = ["RAW DATA", "RAW_DATA", "OPD", "Raw", "SAMPLE_DATA"];
/// Texts listed in the details.
const DETAILS: [&str; 8] = ["Title", "Note", "Date", "Time", "InstrumentName", "Objective", "MultResName", "Software"];

fn sniff(file: &File) -> bool {
    file.head().get(2..12) == Some(b"Directory\0")
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let bytes = file.bytes()?;
    let mut entries = Bytes::new(bytes, Order::Little);
    entries.skip(2)?;
    let directory = Entry::read(&mut entries)?;
    if directory.length % ENTRY != 0 || directory.length == 0 {
        return Err(format!("the directory has {} bytes; it must have {ENTRY} for each block", directory.length));
    }
    let number = directory.length / ENTRY - 1;
    let mut blocks = entries;
    blocks.skip(number.saturating_mul(ENTRY))?;

    let mut scale = Scale::default();
    let mut arrays = vec![];
    for _ in 0..number {
        let entry = Entry::read(&mut entries)?;
        let content = blocks.take(entry.length)?;
        if entry.kind == 3 {
            if HEIGHTS.contains(&entry.name.as_str()) && entry.length > 0 {
                arrays.push((entry.name, content));
                if arrays.len() > MOST_CHANNELS {
                    return Err(format!(
                        "the file has more than {MOST_CHANNELS} blocks of heights; it must have fewer"
                    ));
                }
            }
        } else {
            scale.add(&entry, content)?;
        }
    }
    if arrays.is_empty() {
        return Err(format!("the file has no block of heights; it must have one of {}", HEIGHTS.join(", ")));
    }
    let details = Rc::from(std::mem::take(&mut scale.details));
    let mut channels = vec![];
    for (name, content) in arrays {
        channels.push(channel(name, content, &scale, &details)?);
    }
    Ok(channels.into())
}

/// Entry of the directory.
struct Entry {
    name: String,
    kind: i16,
    length: usize,
}

impl Entry {
    fn read(bytes: &mut Bytes) -> Result<Self, String> {
        let (name, kind, length) = (bytes.text(16)?, bytes.i16()?, bytes.i32()?);
        bytes.skip(2)?;
        // A block with a negative length has no bytes.
        Ok(Self { name, kind, length: usize::try_from(length).unwrap_or(0) })
    }
}

/// Blocks that define the meaning of the numbers.
#[derive(Default)]
struct Scale {
    wavelength: Option<f64>,
    mult: Option<f64>,
    aspect: Option<f64>,
    pixel: Option<f64>,
    details: Vec<(String, String)>,
}

impl Scale {
    fn add(&mut self, entry: &Entry, content: &[u8]) -> Result<(), String> {
        let mut bytes = Bytes::new(content, Order::Little);
        let value = |bytes: &mut Bytes| -> Result<Option<f64>, String> {
            Ok(match (entry.kind, entry.length) {
                (6 | 7, 2) => Some(bytes.i16()?.into()),
                (6, 4) => Some(bytes.i32()?.into()),
                (7, 4..) => Some(bytes.f32()?.into()),
                (8, 8..) => Some(bytes.f64()?),
                (12, 4..) => Some(bytes.i32()?.into()),
                _ => None,
            })
        };
        match entry.name.as_str() {
            "Wavelength" => self.wavelength = value(&mut bytes)?,
            "Mult" => self.mult = value(&mut bytes)?,
            "Aspect" => self.aspect = value(&mut bytes)?,
            "Pixel_size" => self.pixel = value(&mut bytes)?,
            name if entry.kind == 5 && DETAILS.contains(&name) && self.details.len() < 2 * DETAILS.len() => {
                let text = bytes.text(content.len())?;
                if !text.is_empty() {
                    self.details.push((name.to_lowercase(), text));
                }
            }
            _ => (),
        }
        Ok(())
    }
}

fn channel<'a>(
    name: String,
    content: &'a [u8],
    scale: &Scale,
    details: &Rc<[(String, String)]>,
) -> Result<Channel<'a>, String> {
    let mut bytes = Bytes::new(content, Order::Little);
    let points = [count("the number of columns", bytes.u16()?)?, count("the number of lines", bytes.u16()?)?];
    let (sample, undefined) = match bytes.u16()? {
        1 => (Sample::U8, f64::INFINITY),
        2 => (Sample::I16, 32766.0),
        4 => (Sample::F32, f64::from(1e38_f32)),
        size => return Err(format!("a height has {size} bytes; it must have 1, 2 or 4")),
    };
    let grid = Grid { points, sample, order: Order::Little, layout: Layout::Columns, backwards: [false, true] };
    let data = bytes.take(grid.bytes()?)?;
    let wavelength = scale.wavelength.ok_or("the file has no block Wavelength; it must have one")?;
    let mult = match (scale.mult, sample) {
        (Some(mult), _) => mult,
        (None, Sample::F32) => 1.0,
        (None, _) => return Err("the file has no block Mult; one with heights as integers must have it".into()),
    };
    let factor = wavelength / mult;
    if !factor.is_finite() || factor == 0.0 {
        return Err(format!("the wavelength over Mult is {factor} nm; it must be finite and not zero"));
    }
    let lengths = scale.pixel.map(|pixel| {
        let [nx, ny] = points.map(|n| n as f64);
        [nx * pixel, if ny == 1.0 { 1.0 } else { ny * pixel * scale.aspect.unwrap_or(1.0) }]
    });
    let is_square = scale.aspect.is_none() && lengths.is_some() && points[1] > 1;
    let notes = is_square.then(|| "the file has no block Aspect; its pixels are taken to be square".into());
    let details = Rc::clone(details);
    let read = move || {
        Ok(Map {
            heights: grid.read(data, |number| if number < undefined { factor * number } else { f64::NAN })?,
            lengths,
            length_unit: lengths.map(|_| "mm".into()),
            height_unit: Some("nm".into()),
            details: details.to_vec(),
            notes: notes.into_iter().collect(),
            ..Map::default()
        })
    };
    Ok(Channel { name, unit: Some("nm".into()), points, read: Box::new(read) })
}
