//! NanoFocus (`.nms`): confocal microscopes of NanoFocus. Numbers are little-endian.
//!
//! A header of 3468 bytes with the lowest and highest count and their heights in µm, the number of points, and their
//! spacing in nm; 16-bit counts line by line, and a byte of intensity for each point if the header says so. A point
//! with the intensity zero was not measured.

use super::bytes::{Bytes, Grid, Order, Sample, count, factor, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, details, size};

pub(crate) const FORMAT: Format = Format { name: "NanoFocus", sniff, open, first_line: FirstLine::Top };

const HEADER: usize = 3468;

fn sniff(file: &File) -> bool {
    file.head().get(32..41) == Some(b"OM_MS_2.0")
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut bytes = Bytes::new(file.bytes()?, Order::Little);
    let kinds = [("the type of the numbers", bytes.i32()?, 2), ("the type of the data", bytes.i32()?, 1)];
    for (name, found, known) in kinds {
        if found != known {
            return Err(format!("{name} is {found}; it must be {known}, an area of 16-bit counts"));
        }
    }
    let [low, high] = [f64::from(bytes.i32()?), f64::from(bytes.i32()?)];
    let [bottom, top] = [bytes.f64()?, bytes.f64()?];
    let scale = factor("the height of a count", (top - bottom) / (high - low))?;
    bytes.seek(1076)?;
    let date = bytes.text(32)?;
    bytes.seek(1368)?;
    let points = [count("the number of columns", bytes.u32()?)?, count("the number of lines", bytes.u32()?)?];
    let spacing = [positive("the spacing along x", bytes.f64()?)?, positive("the spacing along y", bytes.f64()?)?];
    bytes.seek(1416)?;
    let has_intensity = bytes.i32()? != 0;
    bytes.seek(HEADER)?;
    let grid = Grid::lines(points, Sample::U16, Order::Little);
    let data = bytes.take(grid.bytes()?)?;
    let intensities = if has_intensity { bytes.take(grid.bytes()? / 2)? } else { &[] };
    let unit = Some("µm".to_owned());
    let map = Map {
        lengths: Some(size(points, spacing.map(|spacing| spacing * 1e-3))),
        length_unit: unit.clone(),
        height_unit: unit.clone(),
        details: details([("date", date)]),
        notes: vec!["the first line of the file is taken as the top of the picture, which is not proven".into()],
        ..Map::default()
    };
    let read = move || {
        let mut heights = grid.read(data, |found| bottom + scale * (found - low))?;
        for (k, _) in intensities.iter().enumerate().filter(|(_, intensity)| **intensity == 0) {
            heights[[k % points[0], k / points[0]]] = f64::NAN;
        }
        Ok(Map { heights, ..map })
    };
    Ok(Channel { name: String::new(), unit, points, read: Box::new(read) }.into())
}
