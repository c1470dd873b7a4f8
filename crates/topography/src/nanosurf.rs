//! Nanosurf (`.nid`, `.ezd`): force microscopes of Nanosurf.
//!
//! Sections `[name]` of lines `key=value`; `[DataSet]` lists groups and the sections of their channels. After `#!`
//! follow the integers of all channels, line by line from the bottom of the image. They cover a range of `Dim2Range`
//! starting at `Dim2Min`. The lengths are the ranges of the other two dimensions.

use std::rc::Rc;

use super::bytes::{Bytes, Grid, Layout, MOST_CHANNELS, Order, Sample, clip, count, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::unit::{self, Conversion};

pub(crate) const FORMAT: Format = Format { name: "Nanosurf", sniff, open, first_line: FirstLine::Top };

const MAGIC: &[u8] = b"[DataSet]\r\n";

/// Largest number of lines of the header, and of bytes of a value that are read.
const MOST_LINES: usize = 20_000;
const LONGEST_VALUE: usize = 200;

/// Lines of `[DataSet-Info]` listed in the details, and their names there.
const DETAILS: [(&str, &str); 6] = [
    ("Head type", "instrument"),
    ("Controller S/N", "serial number"),
    ("Date", "date"),
    ("Time", "time"),
    ("Op. mode", "mode"),
    ("Cantilever type", "cantilever"),
];

fn sniff(file: &File) -> bool {
    file.starts_with(MAGIC)
}

/// Lines of the header: section, key, value.
struct Header<'a>(Vec<[&'a [u8]; 3]>);

impl<'a> Header<'a> {
    /// Reads the header; also returns the data after it.
    fn read(mut rest: &'a [u8]) -> Result<(Self, &'a [u8]), String> {
        let (mut lines, mut section) = (vec![], &b"DataSet"[..]);
        while !rest.starts_with(b"#!") {
            let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
                return Err("the header has no end; it must end with #!".into());
            };
            let line = rest[..end].trim_ascii();
            rest = &rest[end + 1..];
            if let Some(name) = line.strip_prefix(b"[").and_then(|name| name.strip_suffix(b"]")) {
                section = name;
            } else if let Some(equal) = line.iter().position(|&byte| byte == b'=') {
                lines.push([section, &line[..equal], &line[equal + 1..]]);
                if lines.len() > MOST_LINES {
                    return Err(format!("the header has more than {MOST_LINES} lines; it must have fewer"));
                }
            }
        }
        Ok((Self(lines), &rest[2..]))
    }

    fn get(&self, section: &str, key: &str) -> Option<String> {
        let wanted = [section.as_bytes(), key.as_bytes()];
        let line = self.0.iter().find(|[section, key, _]| [*section, *key] == wanted);
        line.map(|[.., value]| text(&value[..value.len().min(LONGEST_VALUE)]))
    }

    fn need(&self, section: &str, key: &str) -> Result<String, String> {
        self.get(section, key).ok_or_else(|| format!("section {:?} has no {key}; it must have it", clip(section)))
    }

    fn number<T: std::str::FromStr>(&self, section: &str, key: &str) -> Result<T, String> {
        let value = self.need(section, key)?;
        value.parse().map_err(|_| format!("{key} is {:?}; it must be a number", clip(&value)))
    }

    /// Returns the sections of the channels in the order of their data: by group and number. Channels that were not
    /// recorded have no line.
    fn channels(&self) -> Result<Vec<String>, String> {
        let number = |key: &[u8]| -> Option<(usize, usize)> {
            let (group, channel) = std::str::from_utf8(key).ok()?.strip_prefix("Gr")?.split_once("-Ch")?;
            Some((group.parse().ok()?, channel.parse().ok()?))
        };
        let lines = self.0.iter().filter(|[section, ..]| *section == b"DataSet");
        let mut found: Vec<((usize, usize), &[u8])> =
            lines.filter_map(|[_, key, value]| Some((number(key)?, *value))).take(MOST_CHANNELS + 1).collect();
        if found.len() > MOST_CHANNELS {
            return Err(format!("the file has more than {MOST_CHANNELS} channels; it must have fewer"));
        }
        found.sort();
        Ok(found.into_iter().map(|(_, value)| text(&value[..value.len().min(LONGEST_VALUE)])).collect())
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let (header, data) = Header::read(&file.bytes()?[MAGIC.len()..])?;
    let mut data = Bytes::new(data, Order::Little);
    let details = DETAILS.iter().filter_map(|(key, name)| Some(((*name).to_owned(), header.get("DataSet-Info", key)?)));
    let details: Rc<[(String, String)]> = details.collect();
    let (mut channels, mut others) = (vec![], vec![]);
    for section in header.channels()? {
        if header.get(&section, "SaveMode").is_none() {
            continue;
        }
        let name = format!("{} ({})", header.need(&section, "Frame")?, header.need(&section, "Dim2Name")?);
        let grid = grid(&header, &section)?;
        let data = data.take(grid.bytes()?)?;
        let unit = header.need(&section, "Dim2Unit")?;
        if !unit::is_length(&unit) {
            others.push(name);
            continue;
        }
        let range: f64 = header.number(&section, "Dim2Range")?;
        let mut offset: f64 =
            header.get(&section, "Dim2Min").map_or(Ok(0.0), |_| header.number(&section, "Dim2Min"))?;
        if matches!(grid.sample, Sample::I16 | Sample::I32) {
            offset += range / 2.0;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a size is at most 8")]
        let scale = range / 256_f64.powi(grid.sample.size() as i32);
        // Integers are shifted before they are scaled, which saves one rounding of the heights.
        let shift = if scale == 0.0 { 0.0 } else { offset / scale };
        let (length_unit, other_unit) = (header.need(&section, "Dim0Unit")?, header.need(&section, "Dim1Unit")?);
        let (x, y): (f64, f64) = (header.number(&section, "Dim0Range")?, header.number(&section, "Dim1Range")?);
        let y = Conversion::between(&other_unit, &length_unit)?.map_or(y, |conversion| conversion.apply(y));
        let details = Rc::clone(&details);
        let height_unit = Some(unit.clone());
        let read = move || {
            Ok(Map {
                heights: grid.read(data, |integer| scale * (integer + shift))?,
                lengths: Some([x, if grid.points[1] == 1 { 1.0 } else { y }]),
                length_unit: Some(length_unit),
                height_unit,
                details: details.to_vec(),
                ..Map::default()
            })
        };
        channels.push(Channel { name, unit: Some(unit), points: grid.points, read: Box::new(read) });
    }
    if channels.is_empty() {
        others.truncate(10);
        return Err(format!("the channels are {}; one must have a unit of length", others.join(", ")));
    }
    Ok(channels.into())
}

fn grid(header: &Header, section: &str) -> Result<Grid, String> {
    let points = [
        count("Points", header.number::<usize>(section, "Points")?)?,
        count("Lines", header.number::<usize>(section, "Lines")?)?,
    ];
    let value = |key: &str| header.need(section, key);
    let (mode, bits, sign, order) = (value("SaveMode")?, value("SaveBits")?, value("SaveSign")?, value("SaveOrder")?);
    let sample = match (mode.as_str(), bits.as_str(), sign.as_str()) {
        ("Binary", "8", "Unsigned") => Sample::U8,
        ("Binary", "16", "Signed") => Sample::I16,
        ("Binary", "16", _) => Sample::U16,
        ("Binary", "32", "Signed") => Sample::I32,
        ("Binary", "32", _) => Sample::U32,
        _ => {
            let found = clip(&format!("{mode}, {bits} bits, {sign}"));
            return Err(format!("the data are {found}; they must be Binary of 16 or 32 bits"));
        }
    };
    let order = if order == "Intel" { Order::Little } else { Order::Big };
    Ok(Grid { points, sample, order, layout: Layout::Lines, backwards: [false, true] })
}
