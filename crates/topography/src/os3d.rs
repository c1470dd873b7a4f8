//! OmniSurf3D (`.os3d`) of Digital Metrology. Numbers are little-endian.
//!
//! The version, the name of the instrument, a date from version 1.1 on, the number of points, their spacing and the
//! origin in µm, and 32-bit floats in µm line by line. Undefined points are below -3e38.

use super::bytes::{Bytes, Grid, Order, Sample, count, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, details, size};

pub(crate) const FORMAT: Format = Format { name: "OmniSurf3D", sniff, open, first_line: FirstLine::Top };

const MAGIC: &[u8] = b"OmniSurf3D";

/// Height above which a point is defined.
const LOWEST: f64 = -3e38;

fn sniff(file: &File) -> bool {
    file.starts_with(MAGIC)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut bytes = Bytes::new(file.bytes()?, Order::Little);
    bytes.skip(MAGIC.len())?;
    let version = [bytes.i32()?, bytes.i32()?];
    if version[0] != 1 {
        return Err(format!("the version is {}.{}; it must be 1.0 or 1.1", version[0], version[1]));
    }
    let instrument = string(&mut bytes)?;
    let date = if version[1] >= 1 { string(&mut bytes)? } else { String::new() };
    let points = [count("the number of columns", bytes.i32()?)?, count("the number of lines", bytes.i32()?)?];
    let spacing = [positive("the spacing along x", bytes.f64()?)?, positive("the spacing along y", bytes.f64()?)?];
    bytes.skip(16)?;
    let unit = Some("µm".to_owned());
    let map = Map {
        lengths: Some(size(points, spacing)),
        length_unit: unit.clone(),
        height_unit: unit,
        details: details([("instrument", instrument), ("date", date)]),
        notes: vec!["the first line of the file is taken as the top of the picture, which is not proven".into()],
        ..Map::default()
    };
    let height = |height| if height < LOWEST { f64::NAN } else { height };
    let data = bytes.take(bytes.left())?;
    Channel::of_grid("", Grid::lines(points, Sample::F32, Order::Little), data, map, height).map(Into::into)
}

/// Reads a text after its length.
fn string(bytes: &mut Bytes) -> Result<String, String> {
    let length = bytes.i32()?;
    let length =
        usize::try_from(length).map_err(|_| format!("a text has {length} characters; it must have 0 or more"))?;
    bytes.text(length)
}
