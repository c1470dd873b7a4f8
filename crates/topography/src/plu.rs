//! Sensofar PLu (`.plu`, `.apx`): confocal microscopes of Sensofar, before PLUX. Numbers are little-endian.
//!
//! A date, a comment, the calibration and the settings in 500 bytes, then each layer: its numbers of points, 32-bit
//! floats in µm line by line, two limits, and images of three bytes per point. Undefined points have the height
//! 1000001.

use super::bytes::{Bytes, Grid, Layout, Order, Sample, count};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format = Format { name: "Sensofar PLu", sniff, open, first_line: FirstLine::Top };

const UNDEFINED: f64 = 1_000_001.0;

/// Type number of topographies; other types are profiles and images.
const TOPOGRAPHY: u32 = 3;

/// Returns true if the file starts with a date, such as `Fri Mar 10 16:35:59 2023`, in a field of 128 bytes.
fn sniff(file: &File) -> bool {
    let head = file.head();
    let is_date = head.len() >= 500
        && head[..24].iter().all(|byte| byte.is_ascii_graphic() || *byte == b' ')
        && (head[13], head[16]) == (b':', b':')
        && head[20..24].iter().all(u8::is_ascii_digit);
    is_date && head[24..128].iter().all(|&byte| byte == 0)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut bytes = Bytes::new(file.bytes()?, Order::Little);
    let date = bytes.text(128)?;
    bytes.skip(4)?;
    let comment = bytes.text(256)?;
    bytes.skip(4 * 4)?;
    let pixel = [f64::from(bytes.f32()?), f64::from(bytes.f32()?)];
    bytes.skip(4 * 4)?;
    let kind = bytes.u32()?;
    if kind != TOPOGRAPHY {
        return Err(format!("the data have type {kind}; they must be a topography ({TOPOGRAPHY})"));
    }
    bytes.seek(488 + 1)?;
    let layers = bytes.u8()?;
    bytes.skip(2)?;
    let images = usize::from(bytes.u8()?);
    bytes.seek(500)?;
    let mut channels = vec![];
    for layer in 0..layers {
        let ny = count("the number of lines", bytes.u32()?)?;
        let points = [count("the number of columns", bytes.u32()?)?, ny];
        let grid =
            Grid { points, sample: Sample::F32, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] };
        let data = bytes.take(grid.bytes()?)?;
        let details = [("date", date.clone()), ("comment", comment.clone())];
        let read = move || {
            let unit = Some("µm".to_owned());
            let [nx, ny] = points.map(|n| n as f64);
            let details = details.into_iter().filter(|(_, value)| !value.is_empty());
            Ok(Map {
                heights: grid.read(data, |height| if height == UNDEFINED { f64::NAN } else { height })?,
                lengths: Some([pixel[0] * nx, if ny == 1.0 { 1.0 } else { pixel[1] * ny }]),
                length_unit: unit.clone(),
                height_unit: unit,
                details: details.map(|(key, value)| (key.to_owned(), value)).collect(),
                ..Map::default()
            })
        };
        channels
            .push(Channel { name: format!("layer{layer}"), unit: Some("µm".into()), points, read: Box::new(read) });
        if layer + 1 < layers {
            bytes.skip(8)?;
            bytes.skip(points[0].saturating_mul(points[1]).saturating_mul(3 * images))?;
        }
    }
    if channels.is_empty() {
        return Err("the file has no layer; it must have one".into());
    }
    Ok(channels.into())
}
