//! Keyence VK (`.vk3`, `.vk4`, `.vk6`, `.vk7`): laser microscopes of Keyence. Numbers are little-endian.
//!
//! A table of the positions of blocks: the conditions, with the size of a pixel and the height of a count in pm, and up
//! to three images of heights, counts line by line from the top. Versions 6 and 7 have a picture and a zip archive with
//! such a file, and maybe marks of points that were not measured.

use std::borrow::Cow;
use std::ops::Range;
use std::rc::Rc;

use super::bytes::{Bytes, Grid, Order, Sample, count, factor, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, size};
use super::zipped::Zip;

pub(crate) const FORMAT: Format = Format { name: "Keyence VK", sniff, open, first_line: FirstLine::Top };

/// First bytes of a file without an archive, and of a file with one.
const PLAIN: [&[u8]; 2] = [b"VK3_", b"VK4_"];
const ARCHIVED: [&[u8]; 2] = [b"VK6", b"VK7"];

/// Entries of the table of positions: the conditions, the heights.
const TABLE: usize = 12;
const CONDITIONS: usize = 0;
const HEIGHTS: [usize; 3] = [6, 7, 8];

/// Number of the first condition with a scale, and length of the palette of an image.
const SCALES: usize = 42;
const PALETTE: usize = 768;

/// Picometres in a micrometre.
const PICOMETRES: f64 = 1e6;

fn sniff(file: &File) -> bool {
    PLAIN.iter().chain(&ARCHIVED).any(|magic| file.starts_with(magic))
}

/// Bytes of an image within a file that several channels share.
struct Part<'a> {
    whole: Rc<Cow<'a, [u8]>>,
    range: Range<usize>,
}

impl AsRef<[u8]> for Part<'_> {
    fn as_ref(&self) -> &[u8] {
        &self.whole[self.range.clone()]
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let all = file.bytes()?;
    if !ARCHIVED.iter().any(|magic| all.starts_with(magic)) {
        return channels(Cow::Borrowed(all), None).map(Into::into);
    }
    let mut bytes = Bytes::new(all, Order::Little);
    bytes.skip(3)?;
    let picture = bytes.u32()? as usize;
    bytes.skip(picture)?;
    let mut zip = Zip::of(bytes.take(bytes.left())?)?;
    let inner = zip.whole("Vk4File")?;
    let marks = zip.meant("Vk6ImageData").map(|name| zip.whole(&name)).transpose()?;
    let marks = marks.map(|archive| marks_in(&archive)).transpose()?.flatten();
    channels(Cow::Owned(inner), marks).map(Into::into)
}

/// Marks of points that were not measured, line by line.
struct Marks {
    points: [usize; 2],
    is_missing: Vec<bool>,
}

/// Reads the marks in an archive, if it has them.
fn marks_in(archive: &[u8]) -> Result<Option<Marks>, String> {
    let mut zip = Zip::of(archive)?;
    let Some(name) = zip.meant("ErrorImageData") else { return Ok(None) };
    let all = zip.whole(&name)?;
    let mut bytes = Bytes::new(&all, Order::Little);
    let points = [count("the number of columns", bytes.u32()?)?, count("the number of lines", bytes.u32()?)?];
    let (sample, row) = (bytes.u32()?, bytes.u32()? as usize);
    let sample = match sample {
        1 => Sample::U8,
        4 => Sample::F32,
        other => return Err(format!("a mark has {other} bytes; it must have 1 or 4")),
    };
    let mut is_missing = Vec::new();
    for _ in 0..points[1] {
        let row = bytes.take(row)?;
        let marks = row.chunks_exact(sample.size()).take(points[0]);
        if marks.len() < points[0] {
            return Err(format!("a line of marks has {} bytes for {} points", row.len(), points[0]));
        }
        is_missing.extend(marks.map(|mark| sample.decode(mark, Order::Little) > 0.0));
    }
    Ok(Some(Marks { points, is_missing }))
}

/// Lists the heights of a file of version 3 or 4.
fn channels(all: Cow<'_, [u8]>, marks: Option<Marks>) -> Result<Vec<Channel<'_>>, String> {
    let all = Rc::new(all);
    if !PLAIN.iter().any(|magic| all.starts_with(magic)) {
        return Err("the member Vk4File does not begin with VK3_ or VK4_; it must".into());
    }
    let mut table = Bytes::new(&all, Order::Little);
    let mut block = |entry: usize| {
        table.seek(TABLE + 4 * entry)?;
        table.u32()
    };
    let mut conditions = Bytes::new(&all, Order::Little);
    conditions.seek(block(CONDITIONS)? as usize)?;
    let length = conditions.u32()? as usize;
    if length < 4 * (SCALES + 3) {
        return Err(format!("the conditions have {length} bytes; they must have at least {}", 4 * (SCALES + 3)));
    }
    let date = [conditions.u32()?, conditions.u32()?, conditions.u32()?];
    let date = format!("{:04}-{:02}-{:02}", date[0], date[1], date[2]);
    conditions.skip(4 * (SCALES - 4))?;
    let mut scale = || conditions.u32().map(|found| f64::from(found) / PICOMETRES);
    let spacing = [positive("the spacing along x", scale()?)?, positive("the spacing along y", scale()?)?];
    let scale = factor("the height of a count", scale()?)?;
    let marks = marks.map(Rc::new);
    let mut channels = Vec::new();
    for (number, entry) in HEIGHTS.into_iter().enumerate() {
        let at = block(entry)? as usize;
        if at == 0 {
            continue;
        }
        let (grid, range) = image(&all, at)?;
        let (unit, points) = (Some("µm".to_owned()), grid.points);
        let map = Map {
            lengths: Some(size(points, spacing)),
            length_unit: unit.clone(),
            height_unit: unit,
            details: vec![("date".into(), date.clone())],
            ..Map::default()
        };
        let data = Part { whole: Rc::clone(&all), range };
        let plain = Channel::of_grid(format!("Height {}", number + 1), grid, data, map, move |found| scale * found)?;
        channels.push(match &marks {
            Some(marks) if marks.points != points => {
                let [mx, my] = marks.points;
                return Err(format!("there are {mx} by {my} marks for {} by {} heights", points[0], points[1]));
            }
            Some(marks) => marked(plain, Rc::clone(marks)),
            None => plain,
        });
    }
    match channels.is_empty() {
        true => Err("the file has no image of heights; it must have one".into()),
        false => Ok(channels),
    }
}

/// Reads the head of an image. Returns its points and the place of its counts.
fn image(all: &[u8], at: usize) -> Result<(Grid, Range<usize>), String> {
    let mut bytes = Bytes::new(all, Order::Little);
    bytes.seek(at)?;
    let points = [count("the number of columns", bytes.u32()?)?, count("the number of lines", bytes.u32()?)?];
    let sample = match bytes.u32()? {
        8 => Sample::U8,
        16 => Sample::U16,
        32 => Sample::U32,
        other => return Err(format!("a height has {other} bits; it must have 8, 16 or 32")),
    };
    let (compression, length) = (bytes.u32()?, bytes.u32()? as usize);
    if compression != 0 {
        return Err(format!("the heights are compressed by method {compression}; they must not be compressed"));
    }
    let grid = Grid::lines(points, sample, Order::Little);
    if length != grid.bytes()? {
        let needed = grid.bytes()?;
        return Err(format!("the heights have {length} bytes; {} by {} points need {needed}", points[0], points[1]));
    }
    bytes.skip(8 + PALETTE)?;
    let start = bytes.at();
    bytes.skip(length)?;
    Ok((grid, start..bytes.at()))
}

/// Removes the heights of points that were not measured from a channel.
fn marked(channel: Channel<'_>, marks: Rc<Marks>) -> Channel<'_> {
    let read = move || {
        let mut map = (channel.read)()?;
        let columns = marks.points[0];
        for (k, _) in marks.is_missing.iter().enumerate().filter(|(_, is_missing)| **is_missing) {
            map.heights[[k % columns, k / columns]] = f64::NAN;
        }
        map.notes.push(
            "points marked in ErrorImageData are undefined, as in Gwyddion; other programs ignore the marks".into(),
        );
        Ok(map)
    };
    Channel { read: Box::new(read), ..channel }
}
