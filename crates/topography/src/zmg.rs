//! Zeta (`.zmg`): microscopes of Zeta Instruments, KLA. Numbers are little-endian.
//!
//! The number of points, their spacing and the height of a count in µm, a comment, and 16-bit counts line by line from
//! the top.

use super::bytes::{Bytes, Grid, Order, Sample, count, factor, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, details, size};

pub(crate) const FORMAT: Format = Format { name: "Zeta", sniff, open, first_line: FirstLine::Top };

const MAGIC: &[u8] = b"Zeta-Instruments";

fn sniff(file: &File) -> bool {
    file.starts_with(MAGIC)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut bytes = Bytes::new(file.bytes()?, Order::Little);
    bytes.seek(85)?;
    let points = [count("the number of columns", bytes.u32()?)?, count("the number of lines", bytes.u32()?)?];
    bytes.skip(4)?;
    let spacing = ["the spacing along x", "the spacing along y"];
    let spacing = [positive(spacing[0], bytes.f32()?.into())?, positive(spacing[1], bytes.f32()?.into())?];
    let scale = factor("the height of a count", bytes.f32()?.into())?;
    bytes.skip(8)?;
    let length = bytes.u32()? as usize;
    bytes.skip(84)?;
    let comment = bytes.text(length)?;
    let unit = Some("µm".to_owned());
    let map = Map {
        lengths: Some(size(points, spacing)),
        length_unit: unit.clone(),
        height_unit: unit,
        details: details([("comment", comment)]),
        notes: vec!["counts above 32767 are read without a sign, as two of three programs do".into()],
        ..Map::default()
    };
    let data = bytes.take(bytes.left())?;
    let grid = Grid::lines(points, Sample::U16, Order::Little);
    Channel::of_grid("", grid, data, map, move |found| scale * found).map(Into::into)
}
