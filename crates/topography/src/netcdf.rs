//! NetCDF in its classic format (versions 1, 2 and 5), as written by SurfaceTopography and contact.engineering.
//!
//! The variable `heights` is the height map; in files without it, every variable with two dimensions is one. Its first
//! dimension is x, unless the dimensions are named `y` and `x`. The size is the attribute `length` of the variables `x`
//! and `y`, or n times the spacing of their values. Values follow from the numbers by the attributes of the CF
//! conventions (`scale_factor`, `_FillValue`, `valid_range`, ...); points marked in a variable `mask` are undefined.
//! NetCDF-4 is HDF5 and read as HDF5.

use ndarray::Array2;

use super::bytes::{Bytes, Grid, Layout, Order, Sample, text};
use super::coordinates::{CONSISTENT, evenly_spaced, rising};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, first_height};
use super::packing::{Kind, Packing, Value};
use super::two_dimensional;
use super::unit::Sides;

pub(crate) const FORMAT: Format = Format {
    name: "NetCDF",
    sniff: |file| matches!(file.head(), [b'C', b'D', b'F', 1 | 2 | 5, ..]),
    open,
    first_line: FirstLine::Bottom,
};

/// Tags of the lists of a header.
const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
const ATTRIBUTES: u32 = 12;

struct Dataset<'a> {
    bytes: &'a [u8],
    /// Name and length; a length of 0 grows with the records.
    dimensions: Vec<(String, usize)>,
    attributes: Vec<Attribute<'a>>,
    variables: Vec<Variable<'a>>,
}

struct Attribute<'a> {
    name: String,
    kind: u32,
    data: &'a [u8],
}

struct Variable<'a> {
    name: String,
    dimensions: Vec<usize>,
    attributes: Vec<Attribute<'a>>,
    kind: u32,
    begin: usize,
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let dataset = Dataset::parse(file.bytes()?)?;
    let is_map = |variable: &&Variable| {
        let lengths: Vec<usize> = variable.dimensions.iter().map(|&index| dataset.dimensions[index].1).collect();
        sample(variable.kind).is_some()
            && !lengths.contains(&0)
            && match lengths.len() {
                1 => variable.name == "heights",
                2 => variable.name != "mask" && two_dimensional(&lengths).is_ok(),
                _ => false,
            }
    };
    let mut maps: Vec<&Variable> = dataset.variables.iter().filter(is_map).collect();
    if let Some(heights) = maps.iter().position(|variable| variable.name == "heights") {
        maps = vec![maps[heights]];
    }
    if maps.is_empty() {
        let names: Vec<&str> = dataset.variables.iter().map(|variable| variable.name.as_str()).collect();
        return Err(format!("the file has no variable \"heights\" of numbers; its variables are {}", names.join(", ")));
    }
    let channels = maps.into_iter().map(|variable| dataset.channel(variable)).collect::<Result<Vec<_>, String>>()?;
    let default = first_height(&channels, &(0..channels.len()).collect::<Vec<_>>());
    Ok(Contents { default, ..channels.into() })
}

impl<'a> Dataset<'a> {
    fn parse(all: &'a [u8]) -> Result<Self, String> {
        let mut bytes = Bytes::new(all, Order::Big);
        bytes.skip(3)?;
        let version = bytes.u8()?;
        let mut header = Header { bytes, wide: version == 5 };
        header.whole()?; // number of records
        let dimensions = header.list(DIMENSIONS, |header| Ok((header.name()?, header.whole()?)))?;
        let attributes = header.attributes()?;
        let variables = header.list(VARIABLES, |header| {
            let name = header.name()?;
            let count = header.whole()?;
            let mut indices = Vec::new();
            for _ in 0..count {
                let index = header.whole()?;
                if index >= dimensions.len() || indices.len() == 1024 {
                    return Err(format!(
                        "the variable {name} has the dimension {index}; the file has {}",
                        dimensions.len()
                    ));
                }
                indices.push(index);
            }
            let attributes = header.attributes()?;
            let kind = header.bytes.u32()?;
            header.whole()?; // number of bytes, which is wrong for large variables
            let begin = if version == 1 { u64::from(header.bytes.u32()?) } else { header.bytes.u64()? };
            Ok(Variable {
                name,
                dimensions: indices,
                attributes,
                kind,
                begin: usize::try_from(begin).unwrap_or(usize::MAX),
            })
        })?;
        Ok(Self { bytes: all, dimensions, attributes, variables })
    }

    fn variable(&self, name: &str) -> Option<&Variable<'a>> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// Returns the numbers of a variable of one or two dimensions as `[x, y]`, with the conversion to values.
    fn grid(&self, variable: &Variable<'a>) -> Result<(Grid, &'a [u8], Packing), String> {
        let named: Vec<(&str, usize)> = variable
            .dimensions
            .iter()
            .map(|&index| (self.dimensions[index].0.as_str(), self.dimensions[index].1))
            .collect();
        let (points, layout) = match named[..] {
            [("y", ny), ("x", nx)] => ([nx, ny], Layout::Lines),
            _ => {
                let lengths: Vec<usize> = named.iter().map(|(_, length)| *length).collect();
                (two_dimensional(&lengths)?, Layout::Columns)
            }
        };
        let sample = sample(variable.kind).ok_or_else(|| {
            format!("the variable {} has the type {}; it must be a number", variable.name, variable.kind)
        })?;
        let grid = Grid { points, sample, order: Order::Big, layout, backwards: [false; 2] };
        let data = self.bytes.get(variable.begin..).unwrap_or_default();
        let needed = grid.bytes()?;
        if needed > data.len() {
            return Err(format!(
                "the variable {} has {needed} bytes from byte {}; the file ends after {}",
                variable.name,
                variable.begin,
                self.bytes.len()
            ));
        }
        let attributes: Vec<(String, Value)> =
            variable.attributes.iter().map(|attribute| (attribute.name.clone(), attribute.value())).collect();
        let packing = Packing::of(kind(sample), &attributes, true);
        let packing = packing.map_err(|reason| format!("the variable {}: {reason}", variable.name))?;
        Ok((grid, data, packing))
    }

    fn channel(&self, variable: &Variable<'a>) -> Result<Channel<'a>, String> {
        let (grid, data, packing) = self.grid(variable)?;
        let [nx, ny] = grid.points;
        let mask = match self.variable("mask").filter(|_| variable.name == "heights") {
            Some(mask) => Some(self.grid(mask)?).filter(|(shape, ..)| shape.points == grid.points),
            None => None,
        };
        let x = self.axis("x", nx)?;
        let y = if ny == 1 { None } else { self.axis("y", ny)? };
        let side = |axis: &AxisOf| (axis.length, axis.unit.clone());
        let sides = match (&x, &y, ny) {
            (Some(x), _, 1) => Some(Sides::of(side(x), None)?),
            (Some(x), Some(y), _) => Some(Sides::of(side(x), Some(side(y)))?),
            _ => None,
        };
        let mut lengths = sides.as_ref().map(|sides| sides.lengths);
        let Sides { unit: length_unit, mut notes, .. } = sides.unwrap_or_default();
        let height_unit = unit(&variable.attributes);
        let mut details: Vec<(String, String)> = self
            .attributes
            .iter()
            .filter(|attribute| attribute.kind == 2)
            .map(|attribute| (attribute.name.clone(), text(attribute.data)))
            .collect();
        if x.is_some_and(|axis| axis.periodic) {
            details.push(("periodic".into(), "yes".into()));
        }
        let unit = height_unit.clone();
        let name = variable.name.clone();
        let read = move || {
            packing.check(&name, height_unit.as_deref())?;
            let mut heights = grid.read(data, |number| packing.value(number))?;
            if let Some((grid, data, _)) = mask {
                let mask: Array2<f64> = grid.read(data, |mark| mark)?;
                heights.zip_mut_with(&mask, |height, mark| {
                    if *mark != 0.0 {
                        *height = f64::NAN;
                    }
                });
            }
            if let Some(lengths) = &mut lengths {
                notes.extend(rising(&mut heights, lengths));
            }
            Ok(Map { heights, lengths, length_unit, height_unit, details, notes, ..Map::default() })
        };
        Ok(Channel { name: variable.name.clone(), unit, points: grid.points, read: Box::new(read) })
    }

    /// Returns the axis of a coordinate variable, if it exists and gives a length.
    fn axis(&self, name: &str, points: usize) -> Result<Option<AxisOf>, String> {
        let Some(variable) = self.variable(name) else { return Ok(None) };
        let number = |name: &str| attribute(&variable.attributes, name).and_then(Attribute::number);
        let periodic = number("periodic").is_some_and(|periodic| periodic != 0.0);
        let length = match number("length") {
            Some(length) => Some(length),
            None => {
                let (grid, data, packing) = self.grid(variable)?;
                let values = grid.read(data, |number| packing.value(number))?;
                let largest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
                let rounding = packing.rounding(largest);
                evenly_spaced(&values.into_iter().collect::<Vec<_>>(), points, name, rounding)?
            }
        };
        Ok(length.map(|length| AxisOf { length, unit: unit(&variable.attributes), periodic }))
    }
}

struct AxisOf {
    length: f64,
    unit: Option<String>,
    periodic: bool,
}

fn attribute<'b, 'a>(attributes: &'b [Attribute<'a>], name: &str) -> Option<&'b Attribute<'a>> {
    attributes.iter().find(|attribute| attribute.name == name)
}

fn unit(attributes: &[Attribute]) -> Option<String> {
    let found = attribute(attributes, "unit").or_else(|| attribute(attributes, "units"))?;
    Some(text(found.data)).filter(|unit| !CONSISTENT.contains(&unit.as_str()))
}

impl Attribute<'_> {
    fn value(&self) -> Value {
        let Some(sample) = sample(self.kind) else { return Value::Text(text(self.data)) };
        let numbers = self.data.chunks_exact(sample.size()).map(|bytes| sample.decode(bytes, Order::Big)).collect();
        Value::Numbers { numbers, is_float: kind(sample).is_float }
    }

    /// Returns the first number.
    fn number(&self) -> Option<f64> {
        match self.value() {
            Value::Numbers { numbers, .. } => numbers.first().copied(),
            _ => None,
        }
    }
}

fn kind(sample: Sample) -> Kind {
    let is_float = matches!(sample, Sample::F32 | Sample::F64);
    let is_signed = !matches!(sample, Sample::U8 | Sample::U16 | Sample::U32 | Sample::U64);
    Kind { is_float, is_signed, bytes: u32::try_from(sample.size()).unwrap_or(8) }
}

/// Returns the type of numbers; `None` for text and unknown types.
fn sample(kind: u32) -> Option<Sample> {
    match kind {
        1 => Some(Sample::I8),
        3 => Some(Sample::I16),
        4 => Some(Sample::I32),
        5 => Some(Sample::F32),
        6 => Some(Sample::F64),
        7 => Some(Sample::U8),
        8 => Some(Sample::U16),
        9 => Some(Sample::U32),
        10 => Some(Sample::I64),
        11 => Some(Sample::U64),
        _ => None,
    }
}

/// Position in the header.
struct Header<'a> {
    bytes: Bytes<'a>,
    /// True if counts have 64 bits, from version 5.
    wide: bool,
}

impl<'a> Header<'a> {
    fn whole(&mut self) -> Result<usize, String> {
        if self.wide {
            return Ok(usize::try_from(self.bytes.u64()?).unwrap_or(usize::MAX));
        }
        Ok(self.bytes.u32()? as usize)
    }

    /// Takes the next `count` bytes and skips the padding to a multiple of four.
    fn padded(&mut self, count: usize) -> Result<&'a [u8], String> {
        let taken = self.bytes.take(count)?;
        self.bytes.skip(count.wrapping_neg() % 4)?;
        Ok(taken)
    }

    fn name(&mut self) -> Result<String, String> {
        let length = self.whole()?;
        self.padded(length).map(text)
    }

    /// Reads a list of entries after its tag and number of entries; an absent list has zeros.
    fn list<T>(&mut self, tag: u32, mut entry: impl FnMut(&mut Self) -> Result<T, String>) -> Result<Vec<T>, String> {
        let (found, count) = (self.bytes.u32()?, self.whole()?);
        if found != tag && (found, count) != (0, 0) {
            return Err(format!("a list of the header has the tag {found}; it must be {tag}"));
        }
        let mut entries = Vec::new();
        for _ in 0..count {
            entries.push(entry(self)?);
        }
        Ok(entries)
    }

    fn attributes(&mut self) -> Result<Vec<Attribute<'a>>, String> {
        self.list(ATTRIBUTES, |header| {
            let name = header.name()?;
            let (kind, count) = (header.bytes.u32()?, header.whole()?);
            let size = if kind == 2 { 1 } else { sample(kind).map_or(1, Sample::size) };
            let data = header.padded(count.saturating_mul(size))?;
            Ok(Attribute { name, kind, data })
        })
    }
}
