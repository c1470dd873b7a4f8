//! Molecular Imaging (`.mi`): force microscopes of Agilent and Keysight.
//!
//! Lines of a key of 14 characters and a value, with a section for each channel after its line `bufferLabel`, up to the
//! line `data`; then 16-bit or 32-bit integers, channel by channel, line by line from the bottom of the image. The
//! height is the integer times `bufferRange` divided by the range of the integers, in `bufferUnit`; lengths are in
//! metres.

use std::rc::Rc;

use super::bytes::{Bytes, Grid, Layout, MOST_CHANNELS, Order, Sample, clip, count, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::unit;

pub(crate) const FORMAT: Format = Format { name: "Molecular Imaging", sniff, open, first_line: FirstLine::Top };

/// Number of characters of a key.
const KEY: usize = 14;
/// Largest number of bytes of a value that are read.
const LONGEST_VALUE: usize = 200;

fn sniff(file: &File) -> bool {
    file.starts_with(b"fileType      ")
}

/// Entries of the section of a channel.
#[derive(Default)]
struct Section {
    label: String,
    range: Option<f64>,
    unit: String,
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut rest = file.bytes()?;
    let (mut points, mut lengths, mut details, mut sections) = ([0; 2], [0.0; 2], vec![], Vec::<Section>::new());
    let kind = loop {
        let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
            return Err("the header has no line data; it must end with one".into());
        };
        let (line, after) = (&rest[..end], &rest[end + 1..]);
        rest = after;
        let (key, value) = line.split_at(line.len().min(KEY));
        let (key, value) = (text(key), text(&value[..value.len().min(LONGEST_VALUE)]));
        let number = || value.parse::<f64>().map_err(|_| format!("{key} is {:?}; it must be a number", clip(&value)));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "no grid has as many points as u32"
        )]
        let points_of = |name: &str| match number()? {
            whole if whole.fract() == 0.0 => count(name, whole as u32),
            found => Err(format!("{name} is {found}; it must be a whole number")),
        };
        match (key.as_str(), sections.last_mut()) {
            ("data", _) => break value,
            ("fileType", _) if value != "Image" => {
                return Err(format!("the file is of type {:?}; it must be an Image", clip(&value)));
            }
            ("xPixels", _) => points[0] = points_of("xPixels")?,
            ("yPixels", _) => points[1] = points_of("yPixels")?,
            ("xLength", _) => lengths[0] = number()?,
            ("yLength", _) => lengths[1] = number()?,
            ("bufferLabel", _) => {
                if sections.len() == MOST_CHANNELS {
                    return Err(format!("the file has more than {MOST_CHANNELS} channels; it must have fewer"));
                }
                sections.push(Section { label: value, ..Section::default() });
            }
            ("bufferRange", Some(section)) => section.range = Some(number()?),
            ("bufferUnit", Some(section)) => section.unit = value,
            ("dateAcquired" | "mode" | "version" | "comment", None) if details.len() < 8 && !value.is_empty() => {
                details.push((key, value));
            }
            _ => (),
        }
    };
    let (sample, whole) = match kind.as_str() {
        "BINARY_32" => (Sample::I32, 2_147_483_648.0),
        "BINARY" | "" => (Sample::I16, 32768.0),
        other => return Err(format!("the data are {:?}; they must be BINARY or BINARY_32", clip(other))),
    };
    let grid = Grid { points, sample, order: Order::Little, layout: Layout::Lines, backwards: [false, true] };
    let size = grid.bytes()?;
    let details: Rc<[(String, String)]> = details.into();
    let mut data = Bytes::new(rest, Order::Little);
    let (mut channels, mut others) = (vec![], vec![]);
    for Section { label, range, unit } in sections {
        let data = data.take(size)?;
        if !unit::is_length(&unit) {
            others.push(label);
            continue;
        }
        let scale =
            range.ok_or_else(|| format!("the channel {} has no bufferRange; it must have one", clip(&label)))? / whole;
        let details = Rc::clone(&details);
        let height_unit = Some(unit.clone());
        let read = move || {
            let [lx, ly] = lengths;
            Ok(Map {
                heights: grid.read(data, |integer| scale * integer)?,
                lengths: Some([lx, if points[1] == 1 { 1.0 } else { ly }]),
                length_unit: Some("m".into()),
                height_unit,
                details: details.to_vec(),
                ..Map::default()
            })
        };
        channels.push(Channel { name: label, unit: Some(unit), points, read: Box::new(read) });
    }
    if channels.is_empty() {
        others.truncate(10);
        return Err(format!("the channels are {}; one must have a unit of length", others.join(", ")));
    }
    Ok(channels.into())
}
