//! Header of a text file: the lines above the numbers.

use ndarray::Axis;

use crate::bytes::clip;
use crate::format::Map;
use crate::unit::{Conversion, canonical, is_length};

use super::{Rows, words};

/// Entries of the header, in the spellings of several programs and in German.
#[derive(Debug, Default)]
pub(super) struct Header {
    pub(super) channel: Option<String>,
    /// Factor of the heights.
    pub(super) factor: Option<f64>,
    /// Last line above the numbers, which may name the columns.
    pub(super) columns: String,
    /// Last comment above the numbers that is not an entry.
    comment: String,
    /// True if the third of three columns marks valid points of a profile.
    pub(super) has_validity: bool,
    /// Number of points along x and y.
    pub(super) points: [Option<f64>; 2],
    /// True if the first line is the top of the picture.
    pub(super) is_top_first: bool,
    /// Number for a point without a height.
    pub(super) missing: Option<f64>,
    /// Lines that seem to give size, unit or scale, but are not understood.
    unknown: Vec<String>,
    width: Option<Length>,
    height: Option<Length>,
    pixel: Option<Length>,
    /// Sides of a Nanoscope scan.
    scan: Option<Scan>,
    value_unit: Option<String>,
}

/// Sides of a scan and their unit; the second side may be missing.
#[derive(Clone, Debug)]
struct Scan {
    sides: Vec<f64>,
    unit: Option<String>,
}

/// Meaning of a column according to its title.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    X,
    Y,
    Z,
    Other,
}

/// Title of a column.
#[derive(Clone, Debug)]
pub(super) struct Title {
    pub(super) name: String,
    pub(super) role: Role,
    /// Unit of length.
    pub(super) unit: Option<String>,
}

impl Title {
    fn of(name: &str) -> Self {
        let lower = name.to_lowercase();
        let word = |word: &str| match word.trim_end_matches(|c: char| c.is_ascii_digit()) {
            "x" | "xaxis" | "xpos" | "xposition" | "xcoord" | "xcoordinate" | "lateral" => Some(Role::X),
            "y" | "yaxis" | "ypos" | "yposition" | "ycoord" | "ycoordinate" => Some(Role::Y),
            "z" | "zaxis" | "zpos" | "zposition" | "height" | "heights" | "höhe" | "topography" | "elevation" => {
                Some(Role::Z)
            }
            _ => None,
        };
        let mut words = lower.split(|c: char| !c.is_alphanumeric()).filter(|found| !found.is_empty()).peekable();
        let first = words.peek().copied().and_then(word);
        let role = first.or_else(|| words.filter(|found| found.len() == 1).find_map(word)).unwrap_or(Role::Other);
        Self { name: name.into(), role, unit: unit_in(name) }
    }
}

/// Returns the last unit of length among the words of a text. The word "in" is not an inch here.
fn unit_in(text: &str) -> Option<String> {
    let mut words = text.rsplit(|character: char| !character.is_alphabetic() && character != '~');
    let known = |word: &str| {
        let small = word.to_lowercase();
        let whole = if word.len() > 4 && is_length(&small) { small } else { word.to_owned() };
        (whole != "in" && is_length(&whole)).then_some(whole)
    };
    words.find_map(known)
}

/// Length with its unit, if any.
#[derive(Clone, Debug)]
struct Length {
    value: f64,
    unit: Option<String>,
}

impl std::fmt::Display for Length {
    fn fmt(&self, to: &mut std::fmt::Formatter) -> std::fmt::Result {
        match &self.unit {
            Some(unit) => write!(to, "{} {unit}", self.value),
            None => write!(to, "{}", self.value),
        }
    }
}

/// Value of an entry that may be repeated, but not with another value.
trait Entry: std::fmt::Display {
    /// Returns true if the value has the same meaning as another one.
    fn agrees(&self, other: &Self) -> bool;
}

impl Entry for f64 {
    fn agrees(&self, other: &Self) -> bool {
        (self - other).abs() <= SAME * other.abs()
    }
}

impl Entry for String {
    fn agrees(&self, other: &Self) -> bool {
        canonical(self) == canonical(other)
    }
}

impl Entry for Length {
    fn agrees(&self, other: &Self) -> bool {
        match (&self.unit, &other.unit) {
            (None, None) => self.value.agrees(&other.value),
            (Some(from), Some(to)) if canonical(from) == canonical(to) => self.value.agrees(&other.value),
            (Some(from), Some(to)) => {
                let conversion = Conversion::between(from, to).ok().flatten();
                conversion.is_some_and(|conversion| conversion.apply(self.value).agrees(&other.value))
            }
            _ => false,
        }
    }
}

/// Relative difference of numbers that counts as rounding.
const SAME: f64 = 1e-9;

/// Sets an entry.
///
/// # Errors
/// An entry that a line before gives with another value.
fn once<T: Entry>(entry: &mut Option<T>, value: T, line: usize, name: &str) -> Result<(), String> {
    match entry {
        Some(before) if !value.agrees(before) => Err(format!(
            "line {line} says that the {name} is {}, and a line before says {}; both must agree",
            clip(&value.to_string()),
            clip(&before.to_string())
        )),
        _ => {
            *entry = Some(value);
            Ok(())
        }
    }
}

/// Unit of heights and lengths, the lengths, and notes on conversions.
struct Sizes {
    unit: Option<String>,
    lengths: Option<[f64; 2]>,
    notes: Vec<String>,
}

impl Header {
    /// Parses `Key: value`, `key=value`, or `key,value,unit`, with or without quotes; other lines are ignored.
    pub(super) fn read(&mut self, line: usize, content: &str, is_comment: bool) -> Result<(), String> {
        self.has_validity |= content.eq_ignore_ascii_case("X;Y;valid");
        let content = content.trim().trim_matches('"').trim_start_matches(['\\', '*', '@']);
        if self.read_fields(line, content)? || self.read_entry(line, content)? {
            return Ok(());
        }
        if is_comment && content.chars().any(char::is_alphanumeric) {
            content.clone_into(&mut self.comment);
        }
        if tells(content) && self.unknown.len() < MOST_UNKNOWN {
            self.unknown.push(clip(content));
        }
        Ok(())
    }

    /// Parses `key,value,unit`, the form of Keyence tables. Returns false for another line.
    fn read_fields(&mut self, line: usize, content: &str) -> Result<bool, String> {
        let separator = [';', '\t', ','].into_iter().find(|&separator| content.contains(separator)).unwrap_or(',');
        let fields: Vec<&str> = content.split(separator).map(|field| field.trim().trim_matches('"')).collect();
        let [key, value, rest @ ..] = &fields[..] else { return Ok(false) };
        let count = || value.parse().map(Some).map_err(|_| format!("line {line} says {value:?}; it must be a number"));
        match key.to_lowercase().as_str() {
            key if key.contains("xy") && rest.first().is_some_and(|unit| is_length(unit)) => {
                once(&mut self.pixel, length(line, &format!("{value} {}", rest[0]))?, line, "pixel size")?;
                self.is_top_first = true;
            }
            "horizontal" | "horizont." => self.points[0] = count()?,
            "vertical" | "vertikal" => self.points[1] = count()?,
            "unit" | "einheit" => once(&mut self.value_unit, (*value).into(), line, "unit")?,
            "output image data" | "bilddatenausg." | "data name" if !value.is_empty() => {
                if !["height", "höhe"].iter().any(|height| value.to_lowercase().contains(height)) {
                    return Err(format!("line {line} says that the data are {value:?}; they must be heights"));
                }
            }
            "minimum value" | "maximum value" | "minimum" | "maximum" => {}
            // Unit of the heights in another language.
            _ if self.is_top_first && self.value_unit.is_none() && rest.is_empty() && is_length(value) => {
                self.value_unit = Some((*value).into());
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Parses `Key: value` or `key=value`. Returns false for another line or an unknown key.
    fn read_entry(&mut self, line: usize, content: &str) -> Result<bool, String> {
        let Some((key, value)) = content.split_once([':', '=']) else { return Ok(false) };
        let value = value.trim();
        let number = || value.parse().ok();
        match key.trim().to_lowercase().as_str() {
            "channel" | "kanal" => once(&mut self.channel, value.into(), line, "channel")?,
            "width" | "breite" | "x-length" => once(&mut self.width, length(line, value)?, line, "width")?,
            "height" | "höhe" | "y-length" => once(&mut self.height, length(line, value)?, line, "height")?,
            "pixel size" => once(&mut self.pixel, length(line, value)?, line, "pixel size")?,
            "value units" | "value unit" | "z-unit" | "exported image units" => {
                once(&mut self.value_unit, value.into(), line, "unit")?;
            }
            "samps/line" => self.points[0] = number().or(self.points[0]),
            "lines" => self.points[1] = number().or(self.points[1]),
            "scan size" => {
                let mut words = value.split_whitespace().peekable();
                let mut sides = Vec::new();
                while let Some(side) = words.next_if(|word| word.parse::<f64>().is_ok()) {
                    sides.extend(side.parse::<f64>());
                }
                self.scan = Some(Scan { sides, unit: words.next().map(str::to_owned) });
            }
            "nodata_value" | "nodata" | "nodata value" | "no data value" | "missing value" | "missing_value"
            | "_fillvalue"
                if number().is_some() =>
            {
                once(&mut self.missing, number().unwrap_or_default(), line, "number of missing points")?;
            }
            key => {
                let conversion = key.strip_prefix("height conversion factor (->");
                let Some(unit) = conversion.and_then(|rest| rest.trim().strip_suffix(')')) else { return Ok(false) };
                once(&mut self.factor, length(line, value)?.value, line, "factor")?;
                once(&mut self.value_unit, unit.trim().into(), line, "unit")?;
            }
        }
        Ok(true)
    }

    /// Completes the number of scan lines from the number of pixels, if the header gives only the points per line.
    pub(super) fn complete(&mut self, rows: &Rows) {
        if let [Some(nx), None] = self.points
            && nx >= 1.0
            && rows.rows as f64 % nx == 0.0
            && rows.columns as f64 != nx
        {
            self.points[1] = Some(rows.rows as f64 / nx);
        }
    }

    pub(super) fn has_size(&self) -> bool {
        self.width.is_some() || self.height.is_some() || self.pixel.is_some()
    }

    /// Returns true if only the comment above the numbers can name the columns.
    pub(super) fn titles_are_comment(&self) -> bool {
        self.columns.is_empty()
    }

    /// Returns the titles of the columns, from the line above the numbers, such as `x in µm, y in µm`, or from a
    /// comment that names x. A comment, or a line separated by blanks, must have a title for each column.
    pub(super) fn titles(&self, columns: usize) -> Vec<Title> {
        let above = titles(&self.columns, columns);
        if !self.columns.is_empty() {
            return above;
        }
        let found = titles(&self.comment, columns);
        let names_x = found.len() == columns && found.iter().any(|title| title.role == Role::X);
        if names_x { found } else { Vec::new() }
    }

    /// Returns a warning with the lines that seem to give size, unit or scale, but are not understood.
    pub(super) fn warning(&self, titles_are_used: bool) -> Option<String> {
        let used = [&self.columns, &self.comment].map(|line| clip(line.trim().trim_matches('"')));
        let unknown = self.unknown.iter().filter(|line| !(titles_are_used && used.contains(line)));
        let listed: Vec<String> = unknown.map(|line| format!("{line:?}")).collect();
        (!listed.is_empty()).then(|| {
            format!("the head has lines that are not used: {}; give size and unit with the file", listed.join(", "))
        })
    }

    /// Returns the sides and unit of a Nanoscope scan with `points`; without a second side the pixels are square.
    pub(super) fn scan(&self, [nx, ny]: [usize; 2]) -> Option<([f64; 2], Option<String>)> {
        let Scan { sides, unit } = self.scan.as_ref()?;
        let x = *sides.first()?;
        Some(([x, sides.get(1).copied().unwrap_or(x * ny as f64 / nx as f64)], unit.clone()))
    }

    /// Returns the map with the size of the header, or its own if the header has none, and the unit of the header.
    ///
    /// # Errors
    /// Only part of the sizes or units; another number of points.
    pub(super) fn sized(&self, mut map: Map) -> Result<Map, String> {
        let points: [usize; 2] = map.heights.dim().into();
        for (said, found) in self.points.iter().zip(points) {
            if let Some(said) = said.filter(|said| *said != found as f64) {
                return Err(format!(
                    "the matrix has {found} numbers on a side, and the header says {said}; both must agree"
                ));
            }
        }
        let Sizes { unit, lengths, notes } = self.sizes(points)?;
        let scan = self.scan(points).filter(|_| lengths.is_none() && unit.is_some());
        if let Some(factor) = self.factor {
            map.heights.mapv_inplace(|height| height * factor);
            map.notes.push(format!("heights are the numbers times {factor:e}, the factor in the header"));
        }
        if self.is_top_first {
            map.heights.invert_axis(Axis(1));
        }
        (map.lengths, map.length_unit) = match (lengths, scan) {
            (Some(lengths), _) => (Some(lengths), unit.clone()),
            (None, Some((lengths, unit))) => (Some(lengths), unit),
            (None, None) => (map.lengths, map.length_unit.take()),
        };
        map.height_unit = unit;
        map.notes.extend(notes);
        Ok(map)
    }

    /// Returns the unit of the heights, and the sizes in this unit.
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
        let lengths = match (&self.width, &self.height, &self.pixel) {
            (Some(width), Some(height), _) if nx > 1 && ny > 1 => {
                Some([along("Width", width)?, along("Height", height)?])
            }
            // The length of a profile is the larger of the two; the smaller is one pixel or zero.
            (Some(one), Some(other), _) => Some([along("Width", one)?.max(along("Height", other)?), 1.0]),
            (Some(one), None, _) | (None, Some(one), _) if ny == 1 => Some([along("the length", one)?, 1.0]),
            (None, None, Some(pixel)) => {
                let pixel = along("pixel size", pixel)?;
                Some([pixel * nx as f64, if ny == 1 { 1.0 } else { pixel * ny as f64 }])
            }
            (None, None, None) => None,
            _ => return Err("only one of Width and Height is given; both or neither must be given".into()),
        };
        Ok(Sizes { unit, lengths, notes })
    }
}

/// Splits a line into titles. Titles separated by blanks must match the number of columns.
fn titles(line: &str, columns: usize) -> Vec<Title> {
    let line = line.trim();
    let separator = [';', '\t', ','].into_iter().find(|&separator| line.contains(separator)).unwrap_or(' ');
    if separator != ' ' {
        return words(line, separator).map(Title::of).collect();
    }
    // A unit belongs to the title before it: `x (µm)`, `x in µm`.
    let mut names: Vec<String> = Vec::new();
    for word in words(line, ' ') {
        let bare = word.trim_matches(|c: char| !c.is_alphabetic() && c != '~');
        let is_unit = word.starts_with(['(', '[', '/']) || word.eq_ignore_ascii_case("in") || is_length(bare);
        match names.last_mut() {
            Some(name) if is_unit => *name = format!("{name} {word}"),
            _ => names.push(word.into()),
        }
    }
    if names.len() == columns { names.iter().map(|name| Title::of(name)).collect() } else { Vec::new() }
}

/// Largest number of header lines listed in a warning.
const MOST_UNKNOWN: usize = 8;

/// Returns true for a line that seems to give size, unit, scale or missing points: one of their words with a number or
/// a unit of length, or an entry with a number.
fn tells(line: &str) -> bool {
    const WORDS: [&str; 26] = [
        "size",
        "scale",
        "unit",
        "length",
        "width",
        "height",
        "spacing",
        "pixel",
        "resolution",
        "nodata",
        "no data",
        "missing",
        "invalid",
        "factor",
        "calibration",
        "increment",
        "step",
        "range",
        "cell",
        "pitch",
        "sampling",
        "delta",
        "einheit",
        "breite",
        "höhe",
        "skal",
    ];
    let lower = line.to_lowercase();
    let has_number = lower.chars().any(|c| c.is_ascii_digit());
    let has_unit = unit_in(line).is_some();
    let short = |word: &str| matches!(word, "dx" | "dy" | "dz" | "x" | "y" | "z");
    let named = WORDS.iter().any(|word| lower.contains(word))
        || lower.split(|c: char| !c.is_alphanumeric()).any(short) && line.contains([':', '=']);
    // Entry with a number as its value.
    let entry = line.split_once([':', '=']).and_then(|(_, value)| value.split_whitespace().next());
    named && (has_number || has_unit) || entry.is_some_and(|value| value.parse::<f64>().is_ok())
}

/// Parses a length with or without a unit, such as `10.00 µm`.
fn length(line: usize, text: &str) -> Result<Length, String> {
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    let (value, unit) = text.split_at(end);
    let value = value
        .parse()
        .or_else(|_| value.replacen(',', ".", 1).parse())
        .map_err(|_| format!("the length in line {line} is {:?}; it must have the form 10.00 µm", clip(text)))?;
    let unit = unit.trim();
    Ok(Length { value, unit: (!unit.is_empty()).then(|| unit.into()) })
}
