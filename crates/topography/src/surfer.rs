//! Binary grids of Surfer, Golden Software (`.grd`), of version 6 (`DSBB`) and 7 (`DSRB`). Numbers are little-endian.
//!
//! Version 6 has the number of points and the positions of the first and last of them, and 32-bit floats; version 7 has
//! sections with their numbers and lengths, the spacings, and 64-bit floats. The first line has the lowest y. The file
//! has no units. Grids as text (`DSAA`) are read with other texts.

use super::bytes::{Bytes, Grid, Order, Sample, count, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, size};
use super::sentinel;

pub(crate) const FORMAT: Format = Format { name: "Surfer", sniff, open, first_line: FirstLine::Bottom };

/// Smallest number of a blank point in version 6.
const BLANK: f64 = 1.701_41e38;

fn sniff(file: &File) -> bool {
    file.starts_with(b"DSBB") || file.starts_with(b"DSRB")
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let bytes = Bytes::new(file.bytes()?, Order::Little);
    if file.starts_with(b"DSBB") { open_6(bytes) } else { open_7(bytes) }
}

/// Opens a grid of version 6.
fn open_6(mut bytes: Bytes) -> Result<Contents, String> {
    bytes.skip(4)?;
    let points = [count("the number of columns", bytes.i16()?)?, count("the number of lines", bytes.i16()?)?];
    let mut spacing = [0.0; 2];
    for (axis, spacing) in spacing.iter_mut().enumerate() {
        let [low, high] = [bytes.f64()?, bytes.f64()?];
        if points[axis] < 2 {
            return Err(format!("the grid is {} x {} points; it must be at least 2 x 2", points[0], points[1]));
        }
        *spacing = positive("the spacing", (high - low) / (points[axis] - 1) as f64)?;
    }
    let range = [bytes.f64()?, bytes.f64()?];
    let map = Map { lengths: Some(size(points, spacing)), ..Map::default() };
    let height = |height| if height >= BLANK { f64::NAN } else { height };
    let data = bytes.take(bytes.left())?;
    Channel::of_grid("", Grid::lines(points, Sample::F32, Order::Little), data, map, height)
        .map(|channel| within(range, channel).into())
}

/// Returns a channel that warns about heights outside a range.
fn within(range: [f64; 2], Channel { name, unit, points, read }: Channel) -> Channel {
    let read = Box::new(move || {
        let mut map = read()?;
        map.warnings.extend(sentinel::outside(&map.heights, range, [0.0; 2]));
        Ok(map)
    });
    Channel { name, unit, points, read }
}

/// Opens a grid of version 7.
fn open_7(mut bytes: Bytes) -> Result<Contents, String> {
    let mut section = |name: &[u8; 4]| -> Result<Bytes, String> {
        while bytes.left() > 0 {
            let found = bytes.take(4)?;
            let length = bytes.i32()?;
            let length =
                usize::try_from(length).map_err(|_| format!("a section has {length} bytes; it must have 0 or more"))?;
            // The data may end early, which is reported with the number of heights.
            let length = if found == b"DATA" { length.min(bytes.left()) } else { length };
            let content = bytes.take(length)?;
            if found == name {
                return Ok(Bytes::new(content, Order::Little));
            }
        }
        Err(format!("the file has no section {}; it must have it", String::from_utf8_lossy(name)))
    };
    let version = section(b"DSRB")?.i32()?;
    let mut grid = section(b"GRID")?;
    let lines = count("the number of lines", grid.i32()?)?;
    let points = [count("the number of columns", grid.i32()?)?, lines];
    grid.skip(16)?;
    let spacing = [positive("the spacing along x", grid.f64()?)?, positive("the spacing along y", grid.f64()?)?];
    let range = [grid.f64()?, grid.f64()?];
    let [rotation, blank] = [grid.f64()?, grid.f64()?];
    if rotation != 0.0 {
        return Err(format!("the grid is turned by {rotation}; it must not be turned"));
    }
    let is_blank: fn(f64, f64) -> bool = match version {
        1 => |height, blank| height >= blank,
        2 => |height, blank| height == blank,
        other => return Err(format!("the version of the grid is {other}; it must be 1 or 2")),
    };
    let mut data = section(b"DATA")?;
    let map = Map { lengths: Some(size(points, spacing)), ..Map::default() };
    let height = move |height| if is_blank(height, blank) { f64::NAN } else { height };
    let data = data.take(data.left())?;
    Channel::of_grid("", Grid::lines(points, Sample::F64, Order::Little), data, map, height)
        .map(|channel| within(range, channel).into())
}
