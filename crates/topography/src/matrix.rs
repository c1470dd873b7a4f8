//! Text: a matrix of numbers or a list of points, with or without a header of an instrument or program.
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
//! The encoding is UTF-8, UTF-16 or Latin-1. Numbers are separated by blanks, tabs, commas or semicolons; they have a
//! decimal point, or a decimal comma where commas do not separate, and may be quoted. The exponent may be in the style
//! of Fortran (`1.0D+00`, `1.0-105`), and the sign a typographic minus. Lines end with LF, CR LF, or CR. Lines before
//! the first number are a header; a header line that looks like numbers and has as many words as the lines of numbers
//! is refused. The content decides between a matrix, with or without labels, and a list of points.

mod axis;
mod grids;
mod header;
mod labels;
mod number;
mod pairs;
mod points;

use std::borrow::Cow;

use ndarray::{Array2, Axis};

use super::bytes::{clip, lines};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

use header::Header;
use number::{is_ambiguous, is_missing, last_digit, looks_like, number};
use pairs::Pairs;
use points::MOST_COLUMNS;

pub(crate) const FORMAT: Format = Format { name: "text", sniff, open, first_line: FirstLine::Bottom };

/// Reader of a unit of UTF-16 from its two bytes.
type Unit = fn([u8; 2]) -> u16;

/// Byte order marks of UTF-16, and the readers of the units behind them.
const UTF_16: [([u8; 2], Unit); 2] = [([0xff, 0xfe], u16::from_le_bytes), ([0xfe, 0xff], u16::from_be_bytes)];

/// Range of last digits of a column without numbers.
const NO_DIGIT: [f64; 2] = [f64::INFINITY, 0.0];

/// Two words for a point without a height.
const NO_DATA: &str = "no data";

/// Smallest number of labels above the columns.
const FEWEST_LABELS: usize = 3;

fn sniff(file: &File) -> bool {
    UTF_16.iter().any(|(mark, _)| file.starts_with(mark)) || !file.head().contains(&0)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let text = decode(file.bytes()?);
    if let Some(channels) = grids::channels(&text)? {
        return Ok(channels.into());
    }
    let (rows, mut header) = parse(&text)?;
    header.complete(&rows);
    if let [Some(nx), Some(ny)] = header.points
        && let Some(channels) = pixels(&rows, &header, [nx, ny])?
    {
        return Ok(Contents { warnings: header.warning(true).into_iter().collect(), ..channels.into() });
    }
    let channel = header.channel.clone().unwrap_or_default();
    let labelled = if header.has_size() { None } else { labels::labelled(&rows, &header)? };
    let has_titles = labelled.is_none() && !header.has_size() && !header.titles(rows.columns).is_empty();
    let (is_matrix, map) = match labelled {
        Some(map) => (true, map),
        None if header.has_size() => (true, Map { heights: rows.heights()?, ..Map::default() }),
        None => match points::list(&rows, &header)? {
            Some(map) => (false, map),
            None => {
                labels::check(&rows)?;
                (true, Map { heights: rows.heights()?, ..Map::default() })
            }
        },
    };
    let map = if is_matrix { header.sized(map)? } else { map };
    let warnings = header.warning(has_titles && !is_matrix).into_iter().collect();
    let (unit, points) = (map.height_unit.clone(), map.heights.dim().into());
    let channel = Channel { name: channel, unit, points, read: Box::new(move || Ok(map)) };
    Ok(Contents { warnings, ..channel.into() })
}

/// Returns the channels in the columns of lines with one pixel each, as exported by Nanoscope, for the number of points
/// in the header. Returns `None` if the lines form a matrix.
///
/// # Errors
/// Another number of lines; no column in a unit of length.
fn pixels(rows: &Rows, header: &Header, points: [f64; 2]) -> Result<Option<Vec<Channel<'static>>>, String> {
    let [nx, ny] = points;
    let found = [rows.columns as f64, rows.rows as f64];
    if found == points {
        return Ok(None);
    }
    if header.has_size() || found[1] != nx * ny || !(nx >= 1.0 && ny >= 1.0) {
        let [columns, lines] = [rows.columns, rows.rows];
        return Err(format!(
            "there are {lines} lines of {columns} numbers, and the header says {nx} by {ny}; it must be {ny} lines, or \
             a line for each pixel"
        ));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "divisors of the number of lines")]
    let points = [nx as usize, ny as usize];
    let (lengths, length_unit) = header.scan(points).unzip();
    let titles = header.titles(rows.columns);
    let mut channels = Vec::new();
    for (column, title) in titles.iter().enumerate().filter(|(_, title)| title.unit.is_some()) {
        // The first line is the top of the picture.
        let heights = Array2::from_shape_vec([points[1], points[0]], rows.column(column).collect());
        let mut heights = heights.map_err(|error| error.to_string())?.reversed_axes();
        heights.invert_axis(Axis(1));
        let map = Map {
            heights,
            lengths,
            length_unit: length_unit.clone().flatten(),
            height_unit: title.unit.clone(),
            ..Map::default()
        };
        let name = title.name.split('(').next().unwrap_or_default().trim().to_owned();
        channels.push(Channel { name, unit: title.unit.clone(), points, read: Box::new(move || Ok(map)) });
    }
    match channels.is_empty() {
        true => Err(format!("no title of the {} columns has a unit of length; one must have one", rows.columns)),
        false => Ok(Some(channels)),
    }
}

/// Decodes UTF-16 with its mark, UTF-8 if the bytes are valid, else Latin-1, where each byte is a character code.
fn decode(bytes: &[u8]) -> Cow<'_, str> {
    if let Some((bytes, unit)) = UTF_16.iter().find_map(|(mark, unit)| Some((bytes.strip_prefix(mark)?, unit))) {
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
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
    // First line above the numbers that looks like numbers: its number of words and the error.
    let mut doubtful = None;
    for (line, content) in lines(text).enumerate().map(|(index, content)| (index + 1, content.trim())) {
        if let Some(comment) = content.strip_prefix(['#', '%']).filter(|_| !starts_with_missing(content)) {
            header.read(line, comment, true)?;
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
                    header.read(line, content, false)?;
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
        Some((words, error)) if words == rows.columns => return Err(error),
        _ => {}
    }
    if rows.above.is_none() {
        rows.pairs.check(rows.columns)?;
    }
    if let Some(missing) = header.missing {
        rows.values.iter_mut().filter(|value| **value == missing).for_each(|value| *value = f64::NAN);
    }
    Ok((rows, header))
}

/// Returns true if the first word denotes a point without a height, such as `#N/A`, and does not begin a comment.
fn starts_with_missing(content: &str) -> bool {
    content.starts_with('#') && content.split([' ', '\t', ';', ',']).next().is_some_and(is_missing)
}

/// Returns the number of words of a line if all of them look like numbers.
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

/// Splits a line into words. A separator at its end is dropped.
fn words(content: &str, separator: char) -> impl Iterator<Item = &str> {
    let content = if separator == ' ' { content } else { content.strip_suffix(separator).unwrap_or(content) };
    fields(content, separator)
}

/// Splits a line at separators and removes quotes; quoted separators do not split. Any number of blanks separates.
fn fields(content: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut is_quoted = false;
    let has_quotes = content.contains('"');
    content
        .split(move |c: char| {
            is_quoted ^= has_quotes && c == '"';
            !is_quoted && if separator == ' ' { c.is_whitespace() } else { c == separator }
        })
        .map(move |word| {
            let word = word.trim();
            let inside = || word.strip_prefix('"').and_then(|word| word.strip_suffix('"'));
            if has_quotes { inside().map_or(word, str::trim) } else { word }
        })
        .filter(move |word| separator != ' ' || !word.is_empty())
}

/// Returns true if the first word of a line is a number.
fn starts_with_number(content: &str) -> bool {
    let word = content.split([' ', '\t', ';', ',']).next().unwrap_or_default();
    word.trim_matches('"').parse::<f64>().is_ok()
}

/// Numbers of a file, line by line.
#[derive(Default)]
struct Rows {
    values: Vec<f64>,
    columns: usize,
    rows: usize,
    separator: Option<char>,
    /// Smallest and largest unit of the last digit in each of the first columns, ignoring zeros.
    digits: Vec<[f64; 2]>,
    /// True if the first line begins with a separator.
    has_empty_corner: bool,
    /// Whole numbers that may have decimal commas.
    pairs: Pairs,
    /// Numbers above the columns except the first.
    above: Option<Vec<f64>>,
}

impl Rows {
    /// Adds a line of numbers, or none of them after an error; `text` is the whole file.
    fn push(&mut self, line: usize, content: &str, text: &str) -> Result<(), String> {
        let before = self.values.len();
        let mut pushed = self.push_numbers(line, content, before);
        if pushed.is_err() && self.separator == Some(' ') && content.to_lowercase().contains(NO_DATA) {
            self.values.truncate(before);
            pushed = self.push_numbers(line, &content.to_lowercase().replace(NO_DATA, "nan"), before);
        }
        if pushed.is_err() {
            self.values.truncate(before);
        } else if self.rows == 1 {
            // Reserves the largest possible number of values, so that memory does not grow further.
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
        if self.rows == 0 {
            self.digits.clear();
            self.pairs = Pairs::default();
            self.has_empty_corner = content.starts_with(separator);
        }
        for (column, word) in fields(content, separator).enumerate() {
            if separator == ',' && is_ambiguous(word) {
                return Err(format!(
                    "line {line}, column {} is {:?}, whose comma may be decimal or group digits; it must be a point, \
                     or left out",
                    column + 1,
                    clip(word)
                ));
            }
            let number = number(word, line, column + 1)?;
            self.values.push(number);
            if separator == ',' {
                self.pairs.add(line, column, word);
            }
            if column < MOST_COLUMNS && number.is_finite() && number != 0.0 {
                let digit = last_digit(word);
                self.digits.resize(self.digits.len().max(column + 1), NO_DIGIT);
                let [fine, coarse] = self.digits[column];
                self.digits[column] = [fine.min(digit), coarse.max(digit)];
            }
        }
        // A separator at the end of a line is ignored, unless a number is missing there.
        let surplus = self.rows == 0 || self.values.len() - before == self.columns + 1;
        if separator != ' ' && surplus && content.ends_with(separator) {
            self.values.pop();
        }
        let mut found = self.values.len() - before;
        // The first line holds labels of all columns except the first.
        if self.rows == 1 && self.above.is_none() && found == self.columns + 1 && self.columns >= FEWEST_LABELS {
            let labels: Vec<f64> = self.values.drain(..before).collect();
            if !axis::Axis::is_progression(&labels, [0.0; 2]) {
                self.values.splice(..0, labels);
                return Err(self.ragged(line, found));
            }
            (self.above, self.rows) = (Some(labels), 0);
            found = self.values.len();
        }
        if self.rows == 0 {
            self.columns = found;
        } else if found != self.columns {
            return Err(self.ragged(line, found));
        }
        self.rows += 1;
        Ok(())
    }

    fn ragged(&self, line: usize, found: usize) -> String {
        format!("line {line} has {found} numbers; it must have {} as the lines before", self.columns)
    }

    /// Returns the smallest and largest unit of the last digit in a column; 0 if unknown.
    fn digit(&self, column: usize) -> [f64; 2] {
        self.digits.get(column).copied().filter(|digits| *digits != NO_DIGIT).unwrap_or_default()
    }

    /// Returns the smallest and largest unit of the last digits of all columns.
    fn all_digits(&self) -> [f64; 2] {
        let all = self.digits.iter().filter(|digits| **digits != NO_DIGIT);
        all.copied().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
    }

    /// Returns the numbers of a column.
    fn column(&self, column: usize) -> impl Iterator<Item = f64> + Clone {
        self.values.iter().copied().skip(column).step_by(self.columns.max(1))
    }

    /// Returns the heights `[x, y]` from lines of constant y; a single line or column is a profile.
    fn heights(self) -> Result<Array2<f64>, String> {
        let Self { values, columns, rows, .. } = self;
        let lines = Array2::from_shape_vec((rows, columns), values).map_err(|error| error.to_string())?;
        Ok(if columns == 1 { lines } else { lines.reversed_axes().as_standard_layout().into_owned() })
    }
}

/// Finds the separator of the numbers from their first line. Between blanks, commas are decimal commas.
fn separator(content: &str) -> char {
    let outside = |separator: char| content.split('"').step_by(2).any(|part| part.contains(separator));
    match [';', '\t', ','].into_iter().find(|&separator| outside(separator)) {
        Some(',')
            if content.split(',').any(|word| word.trim().contains(char::is_whitespace) && !content.contains('"')) =>
        {
            ' '
        }
        Some(separator) => separator,
        None => ' ',
    }
}
