//! Alicona AL3D (`.al3d`): focus variation microscopes.
//!
//! Tags of 52 bytes (20 for the key, 30 for the value, and an end of line), then 32-bit floats at an offset given by a
//! tag, line by line, with each line padded to a multiple of 8 bytes. Heights and pixel sizes are in metres. Undefined
//! points are NaN or a value given by a tag.

use std::io::Read;

use super::bytes::{Bytes, Grid, Layout, Order, Sample, count};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format = Format { name: "Alicona AL3D", sniff, open, first_line: FirstLine::Top };

const MAGIC: &[u8] = b"AliconaImaging\0\r\n";

/// Relative deviation from the value of undefined points that counts as rounding of its text.
const ROUNDING_OF_TEXT: f32 = 1.5e-7;

/// Tags listed in the details, and their names there.
const DETAILS: [(&str, &str); 4] = [
    ("CreatingApplication", "software"),
    ("ObjectiveName", "objective"),
    ("CreationDate", "date"),
    ("Comment", "comment"),
];

fn sniff(file: &File) -> bool {
    file.starts_with(MAGIC)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let bytes = file.bytes()?;
    let mut rest = Bytes::new(bytes, Order::Little);
    rest.skip(MAGIC.len())?;
    let mut tags = Tags(vec![]);
    let mut left = 2;
    while left > 0 {
        let tag = (rest.text(20)?, rest.text(30)?);
        if rest.take(2)? != b"\r\n" {
            return Err(format!("the tag {:?} does not end with a new line; each tag must", tag.0));
        }
        left -= 1;
        match tag.0.as_str() {
            "TagCount" if tags.0.len() == 1 => {
                left = tag.1.parse().map_err(|_| format!("TagCount is {:?}; it must be a number", tag.1))?;
            }
            "Cols" | "Rows" | "DepthImageOffset" | "InvalidPixelValue" | "PixelSizeXMeter" | "PixelSizeYMeter"
            | "Version" => {
                tags.set(tag);
            }
            key if DETAILS.iter().any(|(name, _)| *name == key) => tags.set(tag),
            _ => (),
        }
    }
    let points = [count("Cols", tags.number::<usize>("Cols")?)?, count("Rows", tags.number::<usize>("Rows")?)?];
    let [nx, ny] = points;
    let pixel = [tags.number::<f64>("PixelSizeXMeter")?, tags.number::<f64>("PixelSizeYMeter")?];
    #[expect(clippy::cast_possible_truncation, reason = "the heights have single precision")]
    let invalid = tags.number::<f64>("InvalidPixelValue")? as f32;
    let grid = Grid { points, sample: Sample::F32, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] };
    grid.bytes()?;
    rest.seek(tags.number("DepthImageOffset")?)?;
    let line = (4 * nx).next_multiple_of(8);
    let data = rest.take(line.saturating_mul(ny))?;
    let details = DETAILS.iter().filter_map(|(key, name)| Some(((*name).to_owned(), tags.get(key)?.to_owned())));
    let details: Vec<(String, String)> = details.filter(|(_, value)| !value.is_empty()).collect();
    let read = move || {
        let is_invalid = |height: f32| (height - invalid).abs() < ROUNDING_OF_TEXT * invalid.abs() || height == invalid;
        let heights = grid.decode(Lines { data, line, used: 4 * nx, at: 0 }, |height| {
            #[expect(clippy::cast_possible_truncation, reason = "the heights have single precision")]
            let single = height as f32;
            if is_invalid(single) { f64::NAN } else { height }
        })?;
        let unit = Some("m".to_owned());
        let lengths = [nx as f64 * pixel[0], if ny == 1 { 1.0 } else { ny as f64 * pixel[1] }];
        Ok(Map {
            heights,
            lengths: Some(lengths),
            length_unit: unit.clone(),
            height_unit: unit,
            details,
            ..Map::default()
        })
    };
    Ok(Channel { name: "depth".into(), unit: Some("m".into()), points, read: Box::new(read) }.into())
}

/// Tags as keys and values.
struct Tags(Vec<(String, String)>);

impl Tags {
    /// Adds a tag, replacing an earlier one with the same key.
    fn set(&mut self, tag: (String, String)) {
        self.0.retain(|(key, _)| *key != tag.0);
        self.0.push(tag);
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, String> {
        let text = self.get(key).ok_or_else(|| format!("the file has no tag {key}; it must have one"))?;
        text.parse().map_err(|_| format!("{key} is {text:?}; it must be a number"))
    }
}

/// Reader of the used bytes of padded lines.
struct Lines<'a> {
    data: &'a [u8],
    /// Number of bytes of a line, and number of used bytes.
    line: usize,
    used: usize,
    at: usize,
}

impl Read for Lines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let column = self.at % self.line;
        let count = buffer.len().min(self.used - column).min(self.data.len().saturating_sub(self.at));
        buffer[..count].copy_from_slice(&self.data[self.at..self.at + count]);
        self.at += count;
        if self.at % self.line == self.used {
            self.at += self.line - self.used;
        }
        Ok(count)
    }
}
