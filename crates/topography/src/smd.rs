//! Softgauges of ISO 5436-2 (`.smd`): profiles.
//!
//! Records that end with the byte 03: axes with their numbers of points, units and scales, details, numbers one a line,
//! and a checksum, which is not verified. The spacing belongs to an axis of increments; other axes are not read.

use super::bytes::{MOST_CHANNELS, clip, count, factor, lines, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format = Format { name: "ISO 5436-2", sniff, open, first_line: FirstLine::Bottom };

/// Byte at the end of a record.
const END: u8 = 3;

fn sniff(file: &File) -> bool {
    file.starts_with(b"'ISO 5436")
}

/// Axis: its kind, number of points, unit and scale, the type of its numbers, and its spacing.
struct Axis<'a> {
    kind: &'a str,
    points: usize,
    unit: &'a str,
    scale: f64,
    spacing: Option<&'a str>,
}

impl<'a> Axis<'a> {
    /// Reads the line of an axis with this name.
    fn read(head: &'a str, name: &str) -> Result<Self, String> {
        let quoted = format!("'{name}'");
        let line = lines(head).map(str::trim).find(|line| line.starts_with(&quoted));
        let line = line.ok_or_else(|| format!("the head has no line of the axis {name}; it must have one"))?;
        let words: Vec<&str> = line.split_whitespace().map(|word| word.trim_matches('\'')).collect();
        let [_, kind, points, unit, scale, _, rest @ ..] = &words[..] else {
            return Err(format!("the line {:?} has fewer than 6 words; it must have at least as many", clip(line)));
        };
        let points = count("the number of points", points.parse::<usize>().unwrap_or(0))?;
        let scale =
            scale.parse().map_err(|_| format!("the scale of {name} is {:?}; it must be a number", clip(scale)))?;
        let scale = factor("the scale of an axis", scale)?;
        Ok(Self { kind, points, unit, scale, spacing: rest.first().copied() })
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut records = file.bytes()?.split(|&byte| byte == END);
    let head = text(records.next().unwrap_or_default());
    if !lines(&head).any(|line| line.trim_start().starts_with("'PRF'")) {
        return Err("the file holds no profile (PRF); it must hold one".into());
    }
    let [x, z] = [Axis::read(&head, "CX")?, Axis::read(&head, "CZ")?];
    if (x.kind, z.kind) != ("I", "A") {
        return Err(format!(
            "the axes x and z have the kinds {:?} and {:?}; they must be I, increments, and A",
            clip(x.kind),
            clip(z.kind)
        ));
    }
    let spacing = x.spacing.and_then(|word| word.parse::<f64>().ok()).unwrap_or(0.0);
    let spacing = positive("the spacing", x.scale * spacing)?;
    let details = records.next().map(text).unwrap_or_default();
    let detail = |line: &str| {
        line.split_once('\'')
            .and_then(|(_, rest)| rest.split_once('\''))
            .map(|(key, rest)| (key.trim().to_lowercase(), rest.trim().trim_matches('\'').to_owned()))
    };
    let map = Map {
        lengths: Some([spacing * x.points as f64, 1.0]),
        length_unit: Some(x.unit.to_owned()),
        height_unit: Some(z.unit.to_owned()),
        details: lines(&details).filter_map(detail).take(MOST_CHANNELS.min(64)).collect(),
        notes: vec![
            "the layout is taken from the standard, without a file of another program; the checksum is not verified"
                .into(),
        ],
        ..Map::default()
    };
    let numbers = records.next().unwrap_or_default();
    let (points, scale, unit) = (z.points, z.scale, map.height_unit.clone());
    // Each number has at least one digit and an end of line.
    if points != x.points || points > numbers.len() / 2 + 1 {
        return Err(format!("the axes have {} and {points} points, and {} bytes of numbers", x.points, numbers.len()));
    }
    let read = move || {
        let mut heights = Vec::new();
        for word in text(numbers).split_whitespace() {
            let number = word.parse::<f64>();
            heights.push(scale * number.map_err(|_| format!("a height is {:?}; it must be a number", clip(word)))?);
        }
        let found = heights.len();
        let heights = ndarray::Array2::from_shape_vec((points, 1), heights);
        Ok(Map { heights: heights.map_err(|_| format!("there are {found} heights; there must be {points}"))?, ..map })
    };
    Ok(Channel { name: String::new(), unit, points: [points, 1], read: Box::new(read) }.into())
}
