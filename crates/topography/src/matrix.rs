//! Text: a matrix of numbers or a list of points, with or without the header of instruments and programs.
//!
//! ```text
//! # Channel: ZSensor
//! # Width: 10.00 µm
//! # Height: 10.00 µm
//! # Value units: m
//! 1.8823e-008    1.8497e-008    ...
//! ```
//!
//! The numbers of a line of a matrix run along x at constant y: heights\[x, y\] is the number in column x of line y.
//! The encoding is UTF-8, UTF-16 or Latin-1; numbers are separated by blanks, tabs, commas or semicolons and have a
//! decimal point, or a decimal comma where commas do not separate; the exponent may be written as Fortran does
//! (`1.0D+00`, `1.0-105`), and the sign as the minus of typography. Lines end with LF, CR LF, or CR. Lines before the
//! first number are a header; one that looks like numbers and has as many words as the lines of numbers is refused.

mod header;
mod number;
mod points;

use std::borrow::Cow;

use ndarray::Array2;

use super::bytes::lines;
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

use header::{Header, Sizes};
use number::{looks_like, number};

pub(crate) const FORMAT: Format = Format { name: "text", sniff, open, first_line: FirstLine::Bottom };

/// The first bytes of UTF-16 with the lower byte first.
const UTF_16: &[u8] = &[0xff, 0xfe];

fn sniff(file: &File) -> bool {
    file.starts_with(UTF_16) || !file.head().contains(&0)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let text = decode(file.bytes()?);
    let (rows, header) = parse(&text)?;
    let channel = header.channel.clone().unwrap_or_default();
    let list = if header.has_size() { None } else { points::list(&rows, &header)? };
    let map = match list {
        Some(map) => map,
        None => {
            let factor = header.factor;
            let mut heights = rows.heights()?;
            let Sizes { unit, lengths, mut notes } = header.sizes(heights.dim().into())?;
            if let Some(factor) = factor {
                heights.mapv_inplace(|height| height * factor);
                notes.push(format!("heights are the numbers times {factor:e}, the factor in the header"));
            }
            let length_unit = lengths.and(unit.clone());
            Map { heights, lengths, length_unit, height_unit: unit, notes, ..Map::default() }
        }
    };
    let (unit, points) = (map.height_unit.clone(), map.heights.dim().into());
    Ok(Channel { name: channel, unit, points, read: Box::new(move || Ok(map)) }.into())
}

/// Decodes UTF-16 with its mark, UTF-8 if the bytes are valid, else Latin-1, where each byte is the code of its
/// character.
fn decode(bytes: &[u8]) -> Cow<'_, str> {
    if let Some(bytes) = bytes.strip_prefix(UTF_16) {
        let units = bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
        return char::decode_utf16(units).map(|found| found.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => text.strip_prefix('\u{feff}').unwrap_or(text).into(),
        Err(_) => bytes.iter().copied().map(char::from).collect(),
    }
}

fn parse(text: &str) -> Result<(Rows, Header), String> {
    let (mut header, mut rows) = (Header::default(), Rows::default());
    let mut refused = None;
    // The first line above the numbers that looks like numbers, as the count of its words and the error of the first.
    let mut doubtful = None;
    for (line, content) in lines(text).enumerate().map(|(index, content)| (index + 1, content.trim())) {
        if let Some(comment) = content.strip_prefix(['#', '%']) {
            header.read(line, comment)?;
        } else if !content.is_empty() {
            match rows.push(line, content, text) {
                Ok(()) => {}
                // A line that starts with a number is meant as numbers.
                Err(error) if rows.rows > 0 || starts_with_number(content) => return Err(error),
                Err(error) => {
                    if let Some(words) = looks_like_numbers(content) {
                        doubtful.get_or_insert((words, error.clone()));
                    }
                    refused.get_or_insert(error);
                    header.read(line, content)?;
                    header.columns = content.into();
                }
            }
        }
    }
    match refused {
        Some(error) if rows.rows == 0 => return Err(error),
        _ => {}
    }
    match doubtful {
        Some((words, error)) if words == rows.columns => Err(error),
        _ => Ok((rows, header)),
    }
}

/// The number of words of a line all of which look like numbers.
fn looks_like_numbers(content: &str) -> Option<usize> {
    let mut count = 0;
    for word in words(content, separator(content)) {
        if !looks_like(word) {
            return None;
        }
        count += 1;
    }
    Some(count)
}

/// The words of a line. A separator at its end ends the last of them.
fn words(content: &str, separator: char) -> impl Iterator<Item = &str> {
    let content = if separator == ' ' { content } else { content.strip_suffix(separator).unwrap_or(content) };
    content
        .split(move |c: char| if separator == ' ' { c.is_whitespace() } else { c == separator })
        .map(str::trim)
        .filter(move |word| separator != ' ' || !word.is_empty())
}

/// True if the first word of a line is a number.
fn starts_with_number(content: &str) -> bool {
    let word = content.split([' ', '\t', ';', ',']).next().unwrap_or_default();
    word.parse::<f64>().is_ok()
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
    /// Takes a line of numbers; after an error, none of them. The text is the whole file.
    fn push(&mut self, line: usize, content: &str, text: &str) -> Result<(), String> {
        let before = self.values.len();
        let pushed = self.push_numbers(line, content, before);
        if pushed.is_err() {
            self.values.truncate(before);
        } else if self.rows == 1 {
            // As many numbers as the lines can have, so that the memory does not grow beyond them.
            let ends = |end: u8| text.bytes().filter(|&byte| byte == end).count();
            let lines = ends(b'\n').max(ends(b'\r')) + 1;
            self.values.reserve_exact(lines.saturating_mul(self.columns).min(text.len() / 2 + 1));
        }
        pushed
    }

    fn push_numbers(&mut self, line: usize, content: &str, before: usize) -> Result<(), String> {
        let separator = match (self.rows, self.separator) {
            (1.., Some(separator)) => separator,
            _ => *self.separator.insert(separator(content)),
        };
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

    /// The numbers of a column.
    fn column(&self, column: usize) -> impl Iterator<Item = f64> + Clone {
        self.values.iter().copied().skip(column).step_by(self.columns.max(1))
    }

    /// The heights `[x, y]` from lines of constant y; a single line or column is a profile.
    fn heights(self) -> Result<Array2<f64>, String> {
        let Self { values, columns, rows, .. } = self;
        let lines = Array2::from_shape_vec((rows, columns), values).map_err(|error| error.to_string())?;
        Ok(if columns == 1 { lines } else { lines.reversed_axes().as_standard_layout().into_owned() })
    }
}

/// The separator of the numbers, found from their first line. Between blanks, commas are decimal commas.
fn separator(content: &str) -> char {
    match [';', '\t', ','].into_iter().find(|&separator| content.contains(separator)) {
        Some(',') if content.split(',').any(|word| word.trim().contains(char::is_whitespace)) => ' ',
        Some(separator) => separator,
        None => ' ',
    }
}
