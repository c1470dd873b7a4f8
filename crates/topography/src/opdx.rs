//! Dektak OPDx (`.opdx`): stylus profilometers and interferometers of Bruker, written by Vision64.
//!
//! A tree of items, each a name, a one-byte type and a content that depends on it. `/2D_Data/NAME/Matrix` and
//! `/1D_Data/NAME/Array` hold the heights beside their `DataScale` and extents, `/MetaData` the names. An extent is the
//! distance between the first and last point, (n - 1) times the spacing, so the length is `extent * n / (n - 1)`.
//! Undefined points are NaN.

use std::rc::Rc;

use super::bytes::{Bytes, Grid, Layout, MOST_CHANNELS, Order, Sample, clip, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::unit::Conversion;

pub(crate) const FORMAT: Format = Format { name: "Dektak OPDx", sniff, open, first_line: FirstLine::Top };

const MAGIC: &[u8] = b"VCA DATA\x01\0\0\x55";

/// Maximum depth of nested containers.
const DEEPEST: usize = 32;

/// Items of `/MetaData` listed in the details, and their names there.
const DETAILS: [(&str, &str); 5] = [
    ("InstrumentName", "instrument"),
    ("InstrumentSerial", "serial number"),
    ("SerialNumber", "serial number"),
    ("Date", "date"),
    ("Time", "time"),
];

fn sniff(file: &File) -> bool {
    file.starts_with(MAGIC)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut bytes = Bytes::new(file.bytes()?, Order::Little);
    bytes.skip(MAGIC.len())?;
    let mut tree = Tree::default();
    tree.items(&mut bytes, &mut vec![])?;
    let Tree { maps, profiles, heights_2d, heights_1d, primary, details } = tree;
    let details = Rc::from(details);
    // The primary map comes first, then the others in the order of the list.
    let mut names: Vec<&str> = primary.into_iter().collect();
    names.extend(heights_2d.iter().filter(|name| Some(**name) != primary));
    let mut channels = vec![];
    for name in names {
        if let Some(data) = maps.iter().find(|data| data.name == name && data.numbers.is_some()) {
            channels.push(data.map(&details)?);
        }
    }
    for name in heights_1d {
        if let Some(data) = profiles.iter().find(|data| data.name == name && data.numbers.is_some()) {
            channels.push(data.profile(&details)?);
        }
    }
    if channels.is_empty() {
        return Err("the file lists no heights; it must list some in /MetaData".into());
    }
    Ok(channels.into())
}

/// Number with its unit.
#[derive(Clone, Copy)]
struct Quantity<'a> {
    value: f64,
    symbol: &'a [u8],
}

impl Quantity<'_> {
    fn unit(self) -> String {
        text(self.symbol)
    }
}

/// Content of an item, as far as needed.
enum Item<'a> {
    Number(f64),
    Text(&'a [u8]),
    Quantity(Quantity<'a>),
    /// Numbers of points along y and x, 32-bit floats.
    Matrix([u32; 2], &'a [u8]),
    /// 64-bit floats.
    Array(&'a [u8]),
    Names(Vec<&'a str>),
    Other,
}

/// Items that describe one set of numbers.
#[derive(Default)]
struct Data<'a> {
    name: &'a str,
    scale: Option<Quantity<'a>>,
    /// Extents along x and y.
    extents: [Option<Quantity<'a>>; 2],
    points: [Option<f64>; 2],
    numbers: Option<(Option<[u32; 2]>, &'a [u8])>,
}

/// Items of a file that are used.
#[derive(Default)]
struct Tree<'a> {
    maps: Vec<Data<'a>>,
    profiles: Vec<Data<'a>>,
    heights_2d: Vec<&'a str>,
    heights_1d: Vec<&'a str>,
    primary: Option<&'a str>,
    details: Vec<(String, String)>,
}

impl<'a> Tree<'a> {
    /// Reads items up to the terminator or the end; `path` has the names of the enclosing containers.
    fn items(&mut self, bytes: &mut Bytes<'a>, path: &mut Vec<&'a str>) -> Result<(), String> {
        while bytes.left() >= 5 {
            let name = name(bytes)?;
            let kind = bytes.u8()?;
            if kind == 0x7f {
                break;
            }
            path.push(name);
            if matches!(kind, 0x46 | 0x47 | 0x7d) {
                if path.len() > DEEPEST {
                    return Err(format!(
                        "the containers are nested {} deep; they must be at most {DEEPEST}",
                        path.len()
                    ));
                }
                let length = length(bytes)?;
                self.items(&mut Bytes::new(bytes.take(length)?, Order::Little), path)?;
            } else {
                let item = item(bytes, kind)?;
                self.add(path, item)?;
            }
            path.pop();
        }
        Ok(())
    }

    fn add(&mut self, path: &[&'a str], item: Item<'a>) -> Result<(), String> {
        match *path {
            ["MetaData", "2D_Channels", "Height"] => {
                if let Item::Names(names) = item {
                    self.heights_2d = names;
                }
            }
            ["MetaData", "1D_Channels", "Height"] => {
                if let Item::Names(names) = item {
                    self.heights_1d = names;
                }
            }
            ["MetaData", "PrimaryData2D"] => {
                if let Item::Text(name) = item {
                    self.primary = std::str::from_utf8(name).ok();
                }
            }
            ["MetaData", .., key] => {
                let detail = DETAILS.iter().find(|(name, _)| *name == key);
                if let (Some((_, name)), Item::Text(value)) = (detail, item) {
                    self.details.retain(|(key, _)| key != name);
                    self.details.push(((*name).into(), text(value)));
                }
            }
            [group @ ("2D_Data" | "1D_Data"), name, field] => {
                let list = if group == "2D_Data" { &mut self.maps } else { &mut self.profiles };
                let at = list.iter().rposition(|data| data.name == name).unwrap_or(list.len());
                if at == MOST_CHANNELS {
                    return Err(format!("the file has more than {MOST_CHANNELS} sets of data; it must have fewer"));
                }
                if at == list.len() {
                    list.push(Data { name, ..Data::default() });
                }
                list[at].add(field, item);
            }
            _ => (),
        }
        Ok(())
    }
}

impl<'a> Data<'a> {
    fn add(&mut self, field: &str, item: Item<'a>) {
        match (field, item) {
            ("DataScale", Item::Quantity(scale)) => self.scale = Some(scale),
            ("Extent" | "Dimension2Extent", Item::Quantity(extent)) => self.extents[0] = Some(extent),
            ("Dimension1Extent", Item::Quantity(extent)) => self.extents[1] = Some(extent),
            ("NumPoints" | "Dimension2Points", Item::Number(points)) => self.points[0] = Some(points),
            ("Dimension1Points", Item::Number(points)) => self.points[1] = Some(points),
            ("Matrix", Item::Matrix(points, numbers)) => self.numbers = Some((Some(points), numbers)),
            ("Array", Item::Array(numbers)) => self.numbers = Some((None, numbers)),
            _ => (),
        }
    }

    fn map(&self, details: &Rc<[(String, String)]>) -> Result<Channel<'a>, String> {
        let Some((Some([ny, nx]), numbers)) = self.numbers else {
            return Err(format!("the data {:?} have no Matrix; they must have one", clip(self.name)));
        };
        let points = [nx as usize, ny as usize];
        let named = self.points.map(|points| points.unwrap_or(f64::NAN));
        if named != points.map(|n| n as f64) {
            return Err(format!("the matrix has {nx} by {ny} points; it must have {} by {}", named[0], named[1]));
        }
        let (x, y) = (self.extent(0)?, self.extent(1)?);
        let unit = x.unit();
        let factor = Conversion::between(&y.unit(), &unit)?;
        let y = factor.map_or(y.value, |factor| factor.apply(y.value));
        let grid =
            Grid { points, sample: Sample::F32, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] };
        self.channel(grid, numbers, [length_of(x.value, points[0]), length_of(y, points[1])], unit, details)
    }

    fn profile(&self, details: &Rc<[(String, String)]>) -> Result<Channel<'a>, String> {
        let Some((None, numbers)) = self.numbers else {
            return Err(format!("the data {:?} have no Array; they must have one", clip(self.name)));
        };
        let points = numbers.len() / 8;
        if self.points[0] != Some(points as f64) {
            return Err(format!(
                "the profile has {points} points; it must have {}",
                self.points[0].unwrap_or(f64::NAN)
            ));
        }
        let extent = self.extent(0)?;
        let points = [points, 1];
        let grid =
            Grid { points, sample: Sample::F64, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] };
        self.channel(grid, numbers, [length_of(extent.value, points[0]), 1.0], extent.unit(), details)
    }

    fn extent(&self, axis: usize) -> Result<Quantity<'a>, String> {
        self.extents[axis].ok_or_else(|| format!("the data {:?} have no extent; they must have one", clip(self.name)))
    }

    fn channel(
        &self,
        grid: Grid,
        numbers: &'a [u8],
        lengths: [f64; 2],
        unit: String,
        details: &Rc<[(String, String)]>,
    ) -> Result<Channel<'a>, String> {
        let scale = self
            .scale
            .ok_or_else(|| format!("the data {:?} have no DataScale; they must have one", clip(self.name)))?;
        let (needed, height_unit) = (grid.bytes()?, scale.unit());
        if numbers.len() < needed {
            return Err(format!("the heights have {} bytes; they must have {needed}", numbers.len()));
        }
        let details = Rc::clone(details);
        let unit_of_heights = height_unit.clone();
        let read = move || {
            Ok(Map {
                heights: grid.read(numbers, |number| number * scale.value)?,
                lengths: Some(lengths),
                length_unit: Some(unit),
                height_unit: Some(height_unit),
                details: details.to_vec(),
                ..Map::default()
            })
        };
        Ok(Channel { name: self.name.into(), unit: Some(unit_of_heights), points: grid.points, read: Box::new(read) })
    }
}

/// Returns the length, n times the spacing, from the distance between the first and last of n points.
fn length_of(extent: f64, points: usize) -> f64 {
    if points > 1 { extent * points as f64 / (points - 1) as f64 } else { extent }
}

fn name<'a>(bytes: &mut Bytes<'a>) -> Result<&'a str, String> {
    let length = bytes.u32()? as usize;
    std::str::from_utf8(bytes.take(length)?).map_err(|_| "a name is not valid UTF-8; each name must be".into())
}

/// Reads a length: its number of bytes (1, 2 or 4), then the length.
fn length(bytes: &mut Bytes) -> Result<usize, String> {
    Ok(match bytes.u8()? {
        1 => bytes.u8()?.into(),
        2 => bytes.u16()?.into(),
        4 => bytes.u32()? as usize,
        size => return Err(format!("a length has {size} bytes; it must have 1, 2 or 4")),
    })
}

/// Takes the content after a length.
fn block<'a>(bytes: &mut Bytes<'a>) -> Result<&'a [u8], String> {
    let length = length(bytes)?;
    bytes.take(length)
}

fn item<'a>(bytes: &mut Bytes<'a>, kind: u8) -> Result<Item<'a>, String> {
    Ok(match kind {
        0x01 => Item::Number(bytes.u8()?.into()),
        0x04 => Item::Number(bytes.i16()?.into()),
        0x05 => Item::Number(bytes.u16()?.into()),
        0x06 => Item::Number(bytes.i32()?.into()),
        0x07 => Item::Number(bytes.u32()?.into()),
        0x0a => Item::Number(bytes.i64()? as f64),
        0x0b => Item::Number(bytes.u64()? as f64),
        0x0c => Item::Number(bytes.f32()?.into()),
        0x0d => Item::Number(bytes.f64()?),
        0x12 => Item::Text(block(bytes)?),
        0x13 => {
            let mut inside = Bytes::new(block(bytes)?, Order::Little);
            let value = inside.f64()?;
            name(&mut inside)?;
            Item::Quantity(Quantity { value, symbol: name(&mut inside)?.as_bytes() })
        }
        0x15 => {
            bytes.skip(9)?;
            Item::Other
        }
        0x18 => {
            let mut inside = Bytes::new(block(bytes)?, Order::Little);
            name(&mut inside)?;
            let symbol = name(&mut inside)?.as_bytes();
            Item::Quantity(Quantity { value: inside.f64()?, symbol })
        }
        0x00 | 0x45 => {
            name(bytes)?;
            if kind == 0 {
                bytes.skip(4)?;
                name(bytes)?;
            }
            let mut inside = Bytes::new(block(bytes)?, Order::Little);
            let points = [inside.u32()?, inside.u32()?];
            Item::Matrix(points, inside.take(inside.left())?)
        }
        0x40 => {
            name(bytes)?;
            // Five bytes with another meaning precede the numbers.
            Item::Array(block(bytes)?.get(5..).unwrap_or_default())
        }
        0x42 => {
            name(bytes)?;
            let mut inside = Bytes::new(block(bytes)?, Order::Little);
            let mut names = vec![];
            while inside.left() > 0 && names.len() <= MOST_CHANNELS {
                names.push(name(&mut inside)?);
            }
            Item::Names(names)
        }
        0x0e | 0x7c => {
            name(bytes)?;
            block(bytes)?;
            Item::Other
        }
        _ => return Err(format!("an item has type {kind:#04x} at byte {}; it must be a known one", bytes.at())),
    })
}
