//! The header of a text file: the lines above the numbers.

use crate::bytes::clip;
use crate::unit::{Conversion, is_length};

/// The entries of the header, in the spellings of several programs and in German.
#[derive(Debug, Default)]
pub(super) struct Header {
    pub(super) channel: Option<String>,
    /// The factor of the heights.
    pub(super) factor: Option<f64>,
    /// The last line above the numbers, which may name the columns.
    pub(super) columns: String,
    /// True if the third of three columns says whether a point of a profile is valid.
    pub(super) has_validity: bool,
    width: Option<Length>,
    height: Option<Length>,
    pixel: Option<Length>,
    value_unit: Option<String>,
}

/// A length with its unit, if any.
#[derive(Clone, Debug)]
struct Length {
    value: f64,
    unit: Option<String>,
}

/// The unit of heights and lengths, the lengths, and their conversions.
pub(super) struct Sizes {
    pub(super) unit: Option<String>,
    pub(super) lengths: Option<[f64; 2]>,
    pub(super) notes: Vec<String>,
}

impl Header {
    /// Parses `Key: value` or `key=value`; other lines are ignored.
    pub(super) fn read(&mut self, line: usize, content: &str) -> Result<(), String> {
        self.has_validity |= content.eq_ignore_ascii_case("X;Y;valid");
        let Some((key, value)) = content.split_once([':', '=']) else { return Ok(()) };
        let value = value.trim();
        match key.trim().to_lowercase().as_str() {
            "channel" | "kanal" => self.channel = Some(value.into()),
            "width" | "breite" | "x-length" => self.width = Some(length(line, value)?),
            "height" | "höhe" | "y-length" => self.height = Some(length(line, value)?),
            "pixel size" => self.pixel = Some(length(line, value)?),
            "value units" | "value unit" | "z-unit" => self.value_unit = Some(value.into()),
            key => {
                let conversion = key.strip_prefix("height conversion factor (->");
                if let Some(unit) = conversion.and_then(|rest| rest.trim().strip_suffix(')')) {
                    self.factor = Some(length(line, value)?.value);
                    self.value_unit = Some(unit.trim().into());
                }
            }
        }
        Ok(())
    }

    pub(super) fn has_size(&self) -> bool {
        self.width.is_some() || self.height.is_some() || self.pixel.is_some()
    }

    /// The unit of length of each column, from the line above the numbers, such as `x in µm, y in µm`. Names may
    /// contain blanks; if blanks separate them, the units are assigned to the columns if there are equally many.
    pub(super) fn column_units(&self, columns: usize) -> Vec<Option<String>> {
        let separator = [';', '\t', ','].into_iter().find(|&separator| self.columns.contains(separator)).unwrap_or(' ');
        // The word "in" is no inch here.
        let unit = |column: &str| {
            let mut words = column.rsplit(|character: char| !character.is_alphabetic() && character != '~');
            words.find(|word| *word != "in" && is_length(word)).map(str::to_owned)
        };
        let mut units: Vec<_> = self.columns.split(separator).map(unit).collect();
        if separator == ' ' && units.len() != columns {
            units.retain(Option::is_some);
        }
        if separator == ' ' && units.len() != columns { Vec::new() } else { units }
    }

    /// The unit of the heights, and the sizes in this unit.
    pub(super) fn sizes(&self, [nx, ny]: [usize; 2]) -> Result<Sizes, String> {
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
            // The length of a profile is the longer of the two; the shorter is one pixel or zero.
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
