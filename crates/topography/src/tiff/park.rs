//! Park (`.tiff`): force microscopes of Park Systems.
//!
//! Two tags hold a header and the numbers, both little-endian; the image itself is a picture. The height is gain times
//! (scale times number + offset), in the unit of the header. The first line is the bottom of the picture.

use super::{first_page, pages};
use crate::bytes::{Bytes, Grid, Order, Sample, clip, count, factor, positive};
use crate::file::File;
use crate::format::{Channel, Contents, FirstLine, Format, Map};
use crate::unit::is_length;

pub(crate) const FORMAT: Format = Format {
    name: "Park",
    sniff: |file| first_page(file, |page| page.number(MARK).is_ok_and(|mark| mark == Some(f64::from(MAGIC)))),
    open,
    first_line: FirstLine::Bottom,
};

/// Tags, and the number of the first.
const MARK: u16 = 50432;
const MAGIC: u32 = 0x0e03_1301;
const VERSION: u16 = 50433;
const DATA: u16 = 50434;
const HEADER: u16 = 50435;

/// Second version, which has the type of the numbers.
const SECOND: usize = 0x0100_0002;

fn open(file: &File) -> Result<Contents<'_>, String> {
    let pages = pages(file.bytes()?)?;
    let needed = |tag| pages[0].bytes(tag)?.ok_or_else(|| format!("the file has no tag {tag}; it must have it"));
    let (data, mut header) = (needed(DATA)?, Bytes::new(needed(HEADER)?, Order::Little));
    match header.u32()? {
        0 | 2 => {}
        1 => return Err("the file holds a line; it must hold a map".into()),
        other => return Err(format!("the data have type {other}; they must be a map (0)")),
    }
    let name = wide(header.take(64)?);
    header.seek(100)?;
    let points = [count("the number of columns", header.u32()?)?, count("the number of lines", header.u32()?)?];
    header.seek(136)?;
    if header.u32()? != 0 {
        return Err(
            "the axes are swapped; programs disagree on their order, so the scan must be exported as text".into()
        );
    }
    let lengths = [positive("the length along x", header.f64()?)?, header.f64()?];
    let lengths = [lengths[0], if points[1] == 1 { 1.0 } else { positive("the length along y", lengths[1])? }];
    header.seek(220)?;
    let gain = factor("the gain of the heights", header.f64()?)?;
    let scale = header.f64()?;
    let scale = if scale == 0.0 { 1.0 } else { factor("the scale of the heights", scale)? };
    let offset = header.f64()?;
    let unit = wide(header.take(16)?);
    let mut notes = Vec::new();
    let unit = if unit.is_empty() {
        notes.push("the header has no unit of the heights; it is taken as µm".to_owned());
        "µm".to_owned()
    } else {
        unit
    };
    if !is_length(&unit) {
        return Err(format!("{} is in {:?}; it must be in a unit of length", clip(&name), clip(&unit)));
    }
    let sample = if pages[0].whole(VERSION, 0)? == SECOND {
        header.seek(348)?;
        header.u32()?
    } else {
        0
    };
    let sample = match sample {
        0 => Sample::I16,
        1 => Sample::I32,
        2 => Sample::F32,
        other => return Err(format!("the numbers have type {other}; it must be 0, 1 or 2")),
    };
    let length_unit = Some("µm".to_owned());
    let map = Map { lengths: Some(lengths), length_unit, height_unit: Some(unit), notes, ..Map::default() };
    let grid = Grid::lines(points, sample, Order::Little);
    Channel::of_grid(name, grid, data, map, move |found| gain * (scale * found + offset)).map(Into::into)
}

/// Decodes a text of 16-bit characters, up to the first zero.
fn wide(bytes: &[u8]) -> String {
    let units = bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).take_while(|unit| *unit != 0);
    let text: String = char::decode_utf16(units).map(|found| found.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    text.trim().to_owned()
}
