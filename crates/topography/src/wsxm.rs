//! WSxM (`.stp`, `.top`): force and tunnelling microscopes of Nanotec, and the program WSxM.
//!
//! A text header of sections up to `[Header end]`, then little-endian numbers: floats are heights in the unit of
//! `Z Amplitude`, integers span this amplitude from `Minimum` to `Maximum`. The file begins with the bottom line, and
//! each line with its right end.

use super::bytes::{Bytes, Grid, Order, Sample, clip, count, factor, find, lines, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, details};
use super::unit::{Side, Sides, is_length};

pub(crate) const FORMAT: Format = Format { name: "WSxM", sniff, open, first_line: FirstLine::Bottom };

const END: &[u8] = b"[Header end]";

fn sniff(file: &File) -> bool {
    file.starts_with(b"WSxM file copyright")
}

/// Entries of the header: section, key and value.
struct Header(Vec<(String, String, String)>);

impl Header {
    fn of(text: &str) -> Self {
        let (mut section, mut entries) = (String::new(), Vec::new());
        for line in lines(text).map(str::trim) {
            if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
                section = name.to_owned();
            } else if let Some((key, value)) = line.split_once(':') {
                entries.push((section.clone(), key.trim().to_owned(), value.trim().to_owned()));
            }
        }
        Self(entries)
    }

    fn get(&self, section: &str, key: &str) -> Option<&str> {
        let found = self.0.iter().find(|(within, name, _)| within == section && name == key);
        found.map(|(.., value)| value.as_str()).filter(|value| !value.is_empty())
    }

    fn needed(&self, section: &str, key: &str) -> Result<&str, String> {
        self.get(section, key).ok_or_else(|| format!("the header has no {key} in [{section}]; it must have it"))
    }

    /// Reads a number and its unit, which may be missing.
    fn quantity(&self, section: &str, key: &str) -> Result<Side, String> {
        let value = self.needed(section, key)?;
        let (number, unit) = value.split_once(char::is_whitespace).unwrap_or((value, ""));
        let number =
            number.parse().map_err(|_| format!("{key} is {:?}; it must be a number and a unit", clip(value)))?;
        Ok((number, Some(unit.trim().to_owned()).filter(|unit| !unit.is_empty())))
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let all = file.bytes()?;
    let end = find(all, END).ok_or("the header has no line [Header end]; it must end with one")?;
    let head = text(&all[..end]);
    if lines(&head).nth(1).is_none_or(|line| line.trim() != "SxM Image file") {
        return Err("the second line is not \"SxM Image file\"; the file must hold an image".into());
    }
    let header = Header::of(&head);
    let whole = |key| count(key, header.needed("General Info", key)?.parse().unwrap_or(0));
    let points: [usize; 2] = [whole("Number of columns")?, whole("Number of rows")?];
    let kind = header.get("General Info", "Image Data Type").unwrap_or("short");
    let (sample, is_integer) = match kind {
        "short" => (Sample::I16, true),
        "integer" => (Sample::I32, true),
        "float" => (Sample::F32, false),
        "double" => (Sample::F64, false),
        other => {
            return Err(format!("Image Data Type is {:?}; it must be short, integer, float or double", clip(other)));
        }
    };
    let (amplitude, height_unit) = header.quantity("General Info", "Z Amplitude")?;
    let channel = header.get("General Info", "Acquisition channel").unwrap_or_default();
    if !height_unit.as_deref().is_some_and(is_length) {
        let unit = height_unit.unwrap_or_default();
        return Err(format!("{} is in {:?}; it must be in a unit of length", clip(channel), clip(&unit)));
    }
    let scale = if is_integer { factor("the height of a count", amplitude / range(&header)?)? } else { 1.0 };
    let x = header.quantity("Control", "X Amplitude")?;
    // The field is a square if it has one size.
    let y = if header.get("Control", "Y Amplitude").is_some() {
        header.quantity("Control", "Y Amplitude")?
    } else {
        x.clone()
    };
    positive("X Amplitude", x.0)?;
    positive("Y Amplitude", y.0)?;
    let sides = Sides::of(x, Some(y).filter(|_| points[1] > 1))?;
    let map = Map {
        lengths: Some(sides.lengths),
        length_unit: sides.unit,
        height_unit,
        details: details([("comments", header.get("Miscellaneous", "Comments").unwrap_or_default().to_owned())]),
        notes: sides.notes,
        ..Map::default()
    };
    let mut bytes = Bytes::new(all, Order::Little);
    bytes.seek(end + END.len())?;
    let line_end = all[bytes.at()..].iter().position(|&byte| byte == b'\n').unwrap_or(0);
    bytes.skip(line_end + 1)?;
    let grid = Grid { backwards: [true, false], ..Grid::lines(points, sample, Order::Little) };
    let data = bytes.take(bytes.left())?;
    Channel::of_grid(channel, grid, data, map, move |found| scale * found).map(Into::into)
}

/// Returns the range of the integers.
fn range(header: &Header) -> Result<f64, String> {
    let number = |key| {
        let value = header.needed("Miscellaneous", key)?;
        value.parse::<f64>().map_err(|_| format!("{key} is {:?}; it must be a number", clip(value)))
    };
    let [low, high] = [number("Minimum")?, number("Maximum")?];
    if low == high {
        return Err(format!("Minimum and Maximum are both {low}; integers have heights only if they differ"));
    }
    Ok(high - low)
}
