//! TrueMap data files (`.tmd`) of TrueMap and of GelSight. Numbers are little-endian.
//!
//! A line with the version, a comment that ends with a zero byte, the numbers of columns and lines, the size, the
//! origin, and 32-bit floats line by line from the top. Sizes and heights are in mm, as GelSight's own programs read
//! and write them. Undefined points are NaN.

use super::bytes::{Bytes, Grid, Order, Sample, clip, count, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, details};

pub(crate) const FORMAT: Format = Format { name: "TrueMap", sniff, open, first_line: FirstLine::Top };

const MAGIC: &[u8] = b"Binary TrueMap Data File";

/// Length of the line with the version.
const VERSION: usize = 32;

fn sniff(file: &File) -> bool {
    file.starts_with(MAGIC)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let all = file.bytes()?;
    let mut bytes = Bytes::new(all, Order::Little);
    let first = bytes.text(VERSION)?;
    if !first.ends_with("v2.0") {
        return Err(format!("the file begins with {:?}; the version must be v2.0", clip(&first)));
    }
    let end = all[VERSION..].iter().position(|&byte| byte == 0);
    let comment = bytes.take(end.ok_or("the comment has no zero byte at its end; it must have one")?)?;
    bytes.skip(1)?;
    let points = [count("the number of columns", bytes.u32()?)?, count("the number of lines", bytes.u32()?)?];
    let lengths = [positive("the length along x", bytes.f32()?.into())?, f64::from(bytes.f32()?)];
    let lengths = [lengths[0], if points[1] == 1 { 1.0 } else { positive("the length along y", lengths[1])? }];
    let origin = [bytes.f32()?, bytes.f32()?];
    let origin = if origin == [0.0; 2] { String::new() } else { format!("{} mm, {} mm", origin[0], origin[1]) };
    let unit = Some("mm".to_owned());
    let map = Map {
        lengths: Some(lengths),
        length_unit: unit.clone(),
        height_unit: unit,
        details: details([("comment", text(comment)), ("origin, not added", origin)]),
        ..Map::default()
    };
    let data = bytes.take(bytes.left())?;
    Channel::of_grid("", Grid::lines(points, Sample::F32, Order::Little), data, map, |height| height).map(Into::into)
}
