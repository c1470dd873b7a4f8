//! Text files: a matrix of numbers, with or without the header of instruments.
//!
//! ```text
//! # Channel: ZSensor
//! # Width: 10.00 µm
//! # Height: 10.00 µm
//! # Value units: m
//! 1.8823e-008    1.8497e-008    ...
//! ```
//!
//! The numbers of a line run along x at constant y: heights\[x, y\] is the number in column x of line y. The encoding
//! is UTF-8 or Latin-1; numbers have a decimal point and are separated by blanks, tabs, commas or semicolons.

use std::borrow::Cow;

use ndarray::Array2;

use super::file::File;
use super::format::{Channel, Contents, Format, Map};
use super::unit::Conversion;

pub(super) const FORMAT: Format = Format { name: "text matrix", sniff: |file| !file.head().contains(&0), open };

/// Words that denote a point without a height.
const MISSING: [&str; 6] = ["nan", "-nan", "na", "bad", "-", "--"];

fn open(file: &File) -> Result<Contents<'_>, String> {
    let (heights, header) = parse(&decode(file.bytes()?))?;
    let points: [usize; 2] = heights.dim().into();
    let sizes = header.sizes(points)?;
    let channel = header.channel.clone().unwrap_or_default();
    let unit = sizes.unit.clone();
    let read = move || {
        let Sizes { unit, lengths, notes } = sizes;
        let length_unit = lengths.and(unit.clone());
        Ok(Map { heights, lengths, length_unit, height_unit: unit, notes, ..Map::default() })
    };
    Ok(Channel { name: channel, unit, points, read: Box::new(read) }.into())
}

/// Decodes UTF-8 if the bytes are valid, else Latin-1, where each byte is the code of its character.
fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.strip_prefix('\u{feff}').unwrap_or(text).into(),
        Err(_) => bytes.iter().copied().map(char::from).collect(),
    }
}

fn parse(text: &str) -> Result<(Array2<f64>, Header), String> {
    let (mut header, mut rows) = (Header::default(), Rows::default());
    for (line, content) in text.lines().enumerate().map(|(index, content)| (index + 1, content.trim())) {
        if let Some(comment) = content.strip_prefix(['#', '%']) {
            header.read(line, comment)?;
        } else if !content.is_empty() {
            rows.push(line, content)?;
        }
    }
    Ok((rows.heights()?, header))
}

/// The numbers of a file, line by line.
#[derive(Default)]
struct Rows {
    values: Vec<f64>,
    columns: usize,
    rows: usize,
    separator: Option<char>,
}

impl Rows {
    fn push(&mut self, line: usize, content: &str) -> Result<(), String> {
        let separator = *self.separator.get_or_insert_with(|| separator(content));
        let before = self.values.len();
        if separator == ' ' {
            for (column, word) in content.split_whitespace().enumerate() {
                self.values.push(number(word, line, column + 1)?);
            }
        } else {
            for (column, word) in content.split(separator).enumerate() {
                self.values.push(number(word.trim(), line, column + 1)?);
            }
            // A separator at the end of a line is ignored, unless a number is missing there.
            let surplus = self.rows == 0 || self.values.len() - before == self.columns + 1;
            if surplus && content.ends_with(separator) {
                self.values.pop();
            }
        }
        let found = self.values.len() - before;
        if self.rows == 0 {
            self.columns = found;
        } else if found != self.columns {
            return Err(format!("line {line} has {found} numbers; it must have {} as the lines before", self.columns));
        }
        self.rows += 1;
        Ok(())
    }

    /// The heights `[x, y]` from lines of constant y; a single line or column is a profile.
    fn heights(self) -> Result<Array2<f64>, String> {
        let Self { values, columns, rows, .. } = self;
        if columns == 3 && is_point_list(&values) {
            return Err(format!(
                "the {rows} lines of three numbers look like points x y z; they must be a matrix, one line per y"
            ));
        }
        let lines = Array2::from_shape_vec((rows, columns), values).map_err(|error| error.to_string())?;
        Ok(if columns == 1 { lines } else { lines.reversed_axes().as_standard_layout().into_owned() })
    }
}

/// The separator of the numbers, found from their first line.
fn separator(content: &str) -> char {
    [';', '\t', ','].into_iter().find(|&separator| content.contains(separator)).unwrap_or(' ')
}

/// Parses a number; NaN for a point without a height.
fn number(word: &str, line: usize, column: usize) -> Result<f64, String> {
    if word.is_empty() || MISSING.contains(&word.to_ascii_lowercase().as_str()) {
        return Ok(f64::NAN);
    }
    word.parse().map_err(|_| {
        let hint = if word.contains(',') { " with a decimal point" } else { "" };
        let word: String = word.chars().take(40).collect();
        format!("line {line}, column {column} is {word:?}; it must be a number{hint}")
    })
}

/// True if rows of three numbers are the points of a lattice: all pairs of the first two coordinates occur.
fn is_point_list(values: &[f64]) -> bool {
    let column = |k: usize| values.iter().skip(k).step_by(3).copied();
    let count = |column: &mut dyn Iterator<Item = f64>| {
        let mut sorted: Vec<f64> = column.collect();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        sorted.len()
    };
    let [x, y] = [count(&mut column(0)), count(&mut column(1))];
    let mut pairs: Vec<[u64; 2]> = column(0).zip(column(1)).map(|(x, y)| [x.to_bits(), y.to_bits()]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    x > 1 && y > 1 && x * y == values.len() / 3 && pairs.len() == x * y
}

/// The header: the comment lines above the numbers.
#[derive(Debug, Default)]
struct Header {
    channel: Option<String>,
    width: Option<Length>,
    height: Option<Length>,
    value_unit: Option<String>,
}

/// A length with its unit, if any.
#[derive(Clone, Debug)]
struct Length {
    value: f64,
    unit: Option<String>,
}

impl Header {
    /// Parses `Key: value`; other comment lines are ignored.
    fn read(&mut self, line: usize, comment: &str) -> Result<(), String> {
        let Some((key, value)) = comment.split_once(':') else { return Ok(()) };
        let value = value.trim();
        match key.trim().to_ascii_lowercase().as_str() {
            "channel" => self.channel = Some(value.into()),
            "width" => self.width = Some(length(line, value)?),
            "height" => self.height = Some(length(line, value)?),
            "value units" | "value unit" => self.value_unit = Some(value.into()),
            _ => {}
        }
        Ok(())
    }

    /// The unit of the heights, and the sizes in this unit.
    fn sizes(&self, [nx, ny]: [usize; 2]) -> Result<Sizes, String> {
        let unit = self.value_unit.clone();
        let mut notes = Vec::new();
        let mut along = |name: &str, length: &Length| match (&length.unit, &unit) {
            (None, None) => Ok(length.value),
            (Some(from), Some(to)) => match Conversion::between(from, to)? {
                None => Ok(length.value),
                Some(conversion) => {
                    let note = format!("lengths converted {conversion}");
                    if !notes.contains(&note) {
                        notes.push(note);
                    }
                    Ok(conversion.apply(length.value))
                }
            },
            (Some(from), None) => Err(format!(
                "the unit of {name} is {from} but the heights have no unit; a line \"# Value units: ...\" must give it"
            )),
            (None, Some(to)) => {
                Err(format!("the unit of the heights is {to} but {name} has no unit; both or neither must have one"))
            }
        };
        let lengths = match (&self.width, &self.height) {
            (Some(width), Some(height)) if nx > 1 && ny > 1 => Some([along("Width", width)?, along("Height", height)?]),
            // The length of a profile is the longer of the two; the shorter is one pixel or zero.
            (Some(one), Some(other)) => Some([along("Width", one)?.max(along("Height", other)?), 1.0]),
            (Some(one), None) | (None, Some(one)) if ny == 1 => Some([along("the length", one)?, 1.0]),
            (None, None) => None,
            _ => return Err("only one of Width and Height is given; both or neither must be given".into()),
        };
        Ok(Sizes { unit, lengths, notes })
    }
}

/// The unit of heights and lengths, the lengths, and their conversions.
struct Sizes {
    unit: Option<String>,
    lengths: Option<[f64; 2]>,
    notes: Vec<String>,
}

/// Parses a length with or without a unit, such as `10.00 µm`.
fn length(line: usize, text: &str) -> Result<Length, String> {
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    let (value, unit) = text.split_at(end);
    let value =
        value.parse().map_err(|_| format!("the length in line {line} is {text:?}; it must have the form 10.00 µm"))?;
    let unit = unit.trim();
    Ok(Length { value, unit: (!unit.is_empty()).then(|| unit.into()) })
}
