//! Surface data files of ISO 25178-71 and of BCR, as text (`aISO-1.0`, `aBCR-1.0`) or binary (`bISO-1.0`, `bBCR-1.0`).
//!
//! Heights and spacings are in metres; the size is the number of points times the spacing. The first profile of the
//! file is at j = 0.

use ndarray::Array2;

use super::bytes::{Bytes, Grid, Layout, Order, Sample, clip, lines, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format =
    Format { name: "surface data file (SDF)", sniff, open, first_line: FirstLine::Bottom };

/// Length of the binary header.
const HEADER: usize = 81;

/// Length of the two numbers that some instruments add to the header.
const EXTRA_HEADER: usize = 8;

fn sniff(file: &File) -> bool {
    matches!(file.head(), [b'a' | b'b', b'I', b'S', b'O', b'-', ..] | [b'a' | b'b', b'B', b'C', b'R', b'-', ..])
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let bytes = file.bytes()?;
    let channel = if bytes[0] == b'a' { open_text(bytes)? } else { open_binary(bytes)? };
    Ok(channel.into())
}

/// Numbers of a header.
#[derive(Default)]
struct Header {
    points: [usize; 2],
    scale: [f64; 3],
    compression: i64,
    kind: i64,
    check: i64,
    details: Vec<(String, String)>,
}

impl Header {
    fn check(&self) -> Result<(), String> {
        let [nx, ny] = self.points;
        if nx == 0 || ny == 0 {
            return Err(format!("the grid has {nx} by {ny} points; it must have at least one point"));
        }
        for (name, scale) in ["Xscale", "Yscale", "Zscale"].iter().zip(self.scale) {
            positive(name, scale)?;
        }
        for (name, found) in [("Compression", self.compression), ("CheckType", self.check)] {
            if found != 0 {
                return Err(format!("{name} is {found}; it must be 0, since the standard defines no other"));
            }
        }
        Ok(())
    }

    /// Returns the type of the numbers, and the number for an undefined height.
    fn sample(&self) -> Result<(Sample, f64), String> {
        Ok(match self.kind {
            0 => (Sample::U8, f64::NAN),
            1 => (Sample::U16, f64::from(u16::MAX)),
            2 => (Sample::U32, f64::from(u32::MAX)),
            3 => (Sample::F32, f64::NAN),
            4 => (Sample::I8, f64::NAN),
            5 => (Sample::I16, f64::from(i16::MIN)),
            6 => (Sample::I32, f64::from(i32::MIN)),
            7 => (Sample::F64, f64::NAN),
            found => return Err(format!("DataType is {found}; it must be between 0 and 7")),
        })
    }

    fn map(self, heights: Array2<f64>) -> Map {
        let metre = || Some("m".to_owned());
        let lengths = [0, 1].map(|axis| self.points[axis] as f64 * self.scale[axis]);
        Map {
            heights,
            lengths: Some(if self.points[1] == 1 { [lengths[0], 1.0] } else { lengths }),
            length_unit: metre(),
            height_unit: metre(),
            details: self.details,
            ..Map::default()
        }
    }
}

fn open_binary(bytes: &[u8]) -> Result<Channel<'_>, String> {
    let mut at = Bytes::new(bytes, Order::Little);
    at.skip(8)?;
    let mut header = Header::default();
    for (key, length) in [("ManufacID", 10), ("CreateDate", 12), ("ModDate", 12)] {
        header.details.push((key.into(), at.text(length)?));
    }
    header.points = [usize::from(at.u16()?), usize::from(at.u16()?)];
    header.scale = [at.f64()?, at.f64()?, at.f64()?];
    at.skip(8)?; // resolution of the heights
    [header.compression, header.kind, header.check] = [at.u8()?.into(), at.u8()?.into(), at.u8()?.into()];
    header.check()?;
    let (sample, undefined) = header.sample()?;
    let grid =
        Grid { points: header.points, sample, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] };
    let data = &bytes[HEADER..];
    let surplus =
        if bytes.starts_with(b"bISO") && data.len() == grid.bytes()? + EXTRA_HEADER { EXTRA_HEADER } else { 0 };
    let scale = header.scale[2];
    let points = header.points;
    let read = move || {
        let heights = grid.read(&data[surplus..], |z| if z == undefined { f64::NAN } else { z * scale })?;
        Ok(header.map(heights))
    };
    Ok(Channel { name: String::new(), unit: Some("m".into()), points, read: Box::new(read) })
}

fn open_text(bytes: &[u8]) -> Result<Channel<'_>, String> {
    let mut sections = bytes.split(|&byte| byte == b'*');
    let (Some(head), Some(data)) = (sections.next(), sections.next()) else {
        return Err("the file has no line \"*\" between header and heights; it must have one".into());
    };
    let mut header = Header::default();
    for line in lines(&text(head)).map(str::trim).filter(|line| !line.starts_with(';')) {
        let Some((key, value)) = line.split_once(['=', ' ', '\t']) else { continue };
        header.set(key.trim(), value.trim_start_matches(['=', ' ', '\t']).trim())?;
    }
    header.check()?;
    header.sample()?;
    if let Some(trailer) = sections.next() {
        let lines = text(trailer);
        let entries = lines.lines().filter_map(|line| line.trim().strip_prefix('<')?.split_once('>'));
        for (key, rest) in entries.take(64) {
            let value = rest.split('<').next().unwrap_or_default();
            header.details.push((key.trim().into(), value.trim().into()));
        }
    }
    let [nx, ny] = header.points;
    // Every number takes at least two bytes, including its separator.
    if nx.checked_mul(ny).is_none_or(|points| points > data.len() / 2 + 1) {
        return Err(format!("the grid has {nx} by {ny} points; the {} bytes of the heights are too few", data.len()));
    }
    let points = header.points;
    let read = move || {
        let text = text(data);
        let mut words = text.split_whitespace();
        let mut heights = Array2::zeros((nx, ny));
        for k in 0..nx * ny {
            let word = words.next().ok_or_else(|| format!("the file has {k} heights; it must have {}", nx * ny))?;
            heights[[k % nx, k / nx]] = height(word, k)? * header.scale[2];
        }
        match words.next() {
            Some(word) => Err(format!("{:?} follows the heights; a line \"*\" must end them", clip(word))),
            None => Ok(header.map(heights)),
        }
    };
    Ok(Channel { name: String::new(), unit: Some("m".into()), points, read: Box::new(read) })
}

impl Header {
    /// Reads a line of a text header; other keys are details.
    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        let wrong = || format!("{key} is {:?}; it must be a number", clip(value));
        let float = || value.parse::<f64>().map_err(|_| wrong());
        let whole = || value.parse::<usize>().map_err(|_| wrong());
        let small = || value.parse::<i64>().map_err(|_| wrong());
        match key.to_ascii_lowercase().as_str() {
            "numpoints" => self.points[0] = whole()?,
            "numprofiles" => self.points[1] = whole()?,
            "xscale" => self.scale[0] = float()?,
            "yscale" => self.scale[1] = float()?,
            "zscale" => self.scale[2] = float()?,
            "compression" => self.compression = small()?,
            "datatype" => self.kind = small()?,
            "checktype" => self.check = small()?,
            "zresolution" => {}
            _ if !value.is_empty() && self.details.len() < 64 => self.details.push((key.into(), value.into())),
            _ => {}
        }
        Ok(())
    }
}

/// Parses a height; NaN for an undefined one.
fn height(word: &str, k: usize) -> Result<f64, String> {
    if word.eq_ignore_ascii_case("bad") {
        return Ok(f64::NAN);
    }
    word.parse().map_err(|_| format!("height {} is {:?}; it must be a number or BAD", k + 1, clip(word)))
}
