//! Zygo MetroPro (`.dat`): interferometers of Zygo. Numbers are big-endian.
//!
//! A header of 834 or 4096 bytes, 16-bit intensities, then the phases as 32-bit integers, line by line. The height in
//! metres is `phase * S * O * lambda / R` with the scale factor S, the obliquity O, the wavelength lambda, and R =
//! 4096, 32768 or 131072 depending on the phase resolution; it is negative if the sign is set. Undefined points are
//! 2147483640 and above. The spacing is the same along x and y; zero means unknown.

use super::bytes::{Bytes, Grid, Layout, Order, Sample, count};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format = Format { name: "Zygo MetroPro", sniff, open, first_line: FirstLine::Top };

/// First bytes and length of the header of each version.
const VERSIONS: [([u8; 4], u32); 3] =
    [([0x88, 0x1b, 0x03, 0x6f], 834), ([0x88, 0x1b, 0x03, 0x70], 834), ([0x88, 0x1b, 0x03, 0x71], 4096)];

const FIRST_UNDEFINED: f64 = 2_147_483_640.0;

fn sniff(file: &File) -> bool {
    VERSIONS.iter().any(|(magic, _)| file.starts_with(magic))
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut bytes = Bytes::new(file.bytes()?, Order::Big);
    let magic = bytes.take(4)?;
    let expected = VERSIONS.iter().find(|(start, _)| start == magic).map_or(0, |(_, length)| *length);
    bytes.seek(6)?;
    let header = bytes.u32()?;
    if header != expected {
        return Err(format!("the header has {header} bytes; it must have {expected}"));
    }
    bytes.seek(52)?;
    let intensities = [bytes.u16()?, bytes.u16()?, bytes.u16()?];
    bytes.seek(68)?;
    let points = [count("the number of columns", bytes.u16()?)?, count("the number of lines", bytes.u16()?)?];
    bytes.seek(80)?;
    let comment = bytes.text(82)?;
    bytes.seek(164)?;
    let [scale, wavelength] = [f64::from(bytes.f32()?), f64::from(bytes.f32()?)];
    bytes.skip(4)?;
    let obliquity = f64::from(bytes.f32()?);
    bytes.skip(4)?;
    let spacing = f64::from(bytes.f32()?);
    bytes.seek(218)?;
    let resolution = match bytes.i16()? {
        0 => 4096.0,
        1 => 32768.0,
        2 => 131_072.0,
        other => return Err(format!("the resolution of the phase has number {other}; it must be 0, 1 or 2")),
    };
    bytes.seek(232)?;
    let sign = if bytes.i16()? == 0 { 1.0 } else { -1.0 };
    bytes.seek(242)?;
    let serial = bytes.u16()?;
    let (objective, part) = (bytes.text(12)?, bytes.text(40)?);
    bytes.seek(12)?;
    let date = bytes.text(30)?;

    let factor = sign * scale * obliquity * wavelength / resolution;
    if !factor.is_finite() || factor == 0.0 {
        return Err(format!("the height of a unit of phase is {factor} m; it must be finite and not zero"));
    }
    bytes.seek(header as usize)?;
    bytes.skip(2 * intensities.into_iter().map(usize::from).product::<usize>())?;
    let grid = Grid { points, sample: Sample::I32, order: Order::Big, layout: Layout::Lines, backwards: [false; 2] };
    let data = bytes.take(grid.bytes()?)?;
    let [nx, ny] = points.map(|n| n as f64);
    let lengths = (spacing > 0.0).then_some([spacing * nx, if ny == 1.0 { 1.0 } else { spacing * ny }]);
    let details = [
        ("part", part),
        ("comment", comment),
        ("objective", objective),
        ("date of the software", date),
        ("serial number", if serial == 0 { String::new() } else { serial.to_string() }),
    ];
    let details = details.into_iter().filter(|(_, value)| !value.is_empty());
    let details = details.map(|(key, value)| (key.to_owned(), value)).collect();
    let read = move || {
        Ok(Map {
            heights: grid.read(data, |phase| if phase < FIRST_UNDEFINED { factor * phase } else { f64::NAN })?,
            lengths,
            length_unit: lengths.map(|_| "m".into()),
            height_unit: Some("m".into()),
            details,
            ..Map::default()
        })
    };
    Ok(Channel { name: "phase".into(), unit: Some("m".into()), points, read: Box::new(read) }.into())
}
