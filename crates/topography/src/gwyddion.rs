//! Files of Gwyddion: `.gwy`, a tree of typed components, and `.gsf`, a text header before single-precision numbers.
//!
//! Sizes are of the whole field, n times the spacing. The first row of the file, the top of Gwyddion's image, is at j =
//! 0. Points under the mask of a channel are undefined.

use super::bytes::{Bytes, Grid, Layout, MOST_CHANNELS, Order, Sample, clip, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::unit::is_length;

pub(crate) const GWY: Format =
    Format { name: "Gwyddion", sniff: |file| file.starts_with(b"GWYP"), open: open_gwy, first_line: FirstLine::Top };

pub(crate) const GSF: Format = Format {
    name: "Gwyddion simple field",
    sniff: |file| file.starts_with(SIMPLE),
    open: open_gsf,
    first_line: FirstLine::Top,
};

/// First line of a simple field.
const SIMPLE: &[u8] = b"Gwyddion Simple Field 1.0";

/// Maximum depth of nested objects; a channel needs three.
const DEPTH: usize = 8;

/// Maximum number of components of all objects.
const MOST_COMPONENTS: usize = 20_000;

/// Value of a component, as far as height maps need it.
enum Value<'a> {
    Whole(i64),
    Real(f64),
    Text(&'a [u8]),
    /// Bytes of real numbers.
    Reals(&'a [u8]),
    Object(Object<'a>),
    Other,
}

/// Components by name, in file order.
struct Object<'a>(Vec<(&'a [u8], Value<'a>)>);

impl<'a> Object<'a> {
    fn get(&self, name: &str) -> Option<&Value<'a>> {
        self.0.iter().find(|(key, _)| *key == name.as_bytes()).map(|(_, value)| value)
    }

    fn text(&self, name: &str) -> Option<String> {
        match self.get(name) {
            Some(Value::Text(bytes)) => Some(text(bytes)),
            _ => None,
        }
    }

    fn object(&self, name: &str) -> Option<&Object<'a>> {
        match self.get(name) {
            Some(Value::Object(object)) => Some(object),
            _ => None,
        }
    }

    /// Returns the unit of an axis, if any.
    fn unit(&self, axis: &str) -> Option<String> {
        self.object(axis)?.text("unitstr").filter(|unit| !unit.is_empty())
    }
}

fn open_gwy(file: &File) -> Result<Contents<'_>, String> {
    let mut bytes = Bytes::new(file.bytes()?, Order::Little);
    bytes.skip(4)?;
    let mut left = MOST_COMPONENTS;
    let root = object(&mut bytes, DEPTH, &mut left)?;
    let (mut channels, mut others) = (Vec::new(), Vec::new());
    for (key, value) in &root.0 {
        let key = text(key);
        let Some(number) = key.strip_suffix("/data").filter(|number| number.starts_with('/')) else { continue };
        let Value::Object(field) = value else { continue };
        let name = root.text(&format!("{key}/title")).unwrap_or_default();
        let unit = field.unit("si_unit_z");
        if !unit.as_deref().is_some_and(is_length) {
            let unit = unit.map_or_else(String::new, |unit| format!(" in {unit}"));
            others.push(format!("{}{unit}", if name.is_empty() { &key } else { &name }));
            continue;
        }
        if channels.len() == MOST_CHANNELS {
            return Err(format!("the file has more than {MOST_CHANNELS} channels; it must have at most so many"));
        }
        let mask = root.object(&format!("{number}/mask"));
        let details = root.object(&format!("{number}/meta")).map_or_else(Vec::new, metadata);
        channels.push(channel(name, field, mask, details)?);
    }
    match channels.is_empty() {
        true => Err(format!("the file has no channel of heights in a unit of length; it has {}", listed(&others))),
        false => Ok(channels.into()),
    }
}

fn listed(names: &[String]) -> String {
    if names.is_empty() { "no channels".into() } else { names.join(", ") }
}

/// Returns the texts of the metadata of a channel.
fn metadata(object: &Object) -> Vec<(String, String)> {
    let texts = object.0.iter().filter_map(|(key, value)| match value {
        Value::Text(value) => Some((text(key), text(value))),
        _ => None,
    });
    texts.collect()
}

fn channel<'a>(
    name: String,
    field: &Object<'a>,
    mask: Option<&Object<'a>>,
    details: Vec<(String, String)>,
) -> Result<Channel<'a>, String> {
    let (grid, heights) = numbers(field, &name)?;
    let mask = mask.map(|mask| numbers(mask, "the mask")).transpose()?;
    let length = |key: &str| match field.get(key) {
        Some(Value::Real(length)) => positive(key, *length),
        _ => Err(format!("the channel {name} has no {key}; it must have its size")),
    };
    let [_, ny] = grid.points;
    let lengths = [length("xreal")?, if ny == 1 { 1.0 } else { length("yreal")? }];
    let (length_unit, height_unit) = (field.unit("si_unit_xy"), field.unit("si_unit_z"));
    let unit = height_unit.clone();
    let read = move || {
        let mut heights = grid.read(heights, |height| height)?;
        let mut notes = Vec::new();
        if let Some((shape, mask)) = mask {
            if shape.points != grid.points {
                return Err(format!("the mask has {:?} points; it must have as many as the heights", shape.points));
            }
            let mask = shape.read(mask, |masked| masked)?;
            heights.zip_mut_with(&mask, |height, masked| {
                if *masked > 0.5 {
                    *height = f64::NAN;
                }
            });
            notes.push("points under the mask of the channel are undefined".into());
        }
        Ok(Map { heights, lengths: Some(lengths), length_unit, height_unit, details, notes, ..Map::default() })
    };
    Ok(Channel { name, unit, points: grid.points, read: Box::new(read) })
}

/// Returns the grid of a data field and the bytes of its numbers, checked to be enough.
fn numbers<'a>(field: &Object<'a>, name: &str) -> Result<(Grid, &'a [u8]), String> {
    let points = |key: &str| match field.get(key) {
        Some(Value::Whole(points)) => super::bytes::count(key, *points),
        _ => Err(format!("{name} has no {key}; it must have its number of points")),
    };
    let points = [points("xres")?, points("yres")?];
    let Some(Value::Reals(bytes)) = field.get("data") else {
        return Err(format!("{name} has no numbers; it must have them as \"data\""));
    };
    let grid = Grid { points, sample: Sample::F64, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] };
    let needed = grid.bytes()?;
    if needed > bytes.len() {
        let [nx, ny] = points;
        return Err(format!("{name} has {nx} by {ny} points and {} bytes; it must have {needed}", bytes.len()));
    }
    Ok((grid, bytes))
}

/// Reads an object: its name, its size in bytes, its components.
fn object<'a>(bytes: &mut Bytes<'a>, depth: usize, left: &mut usize) -> Result<Object<'a>, String> {
    name(bytes)?;
    let size = bytes.u32()? as usize;
    let mut inside = Bytes::new(bytes.take(size)?, Order::Little);
    let mut components = Vec::new();
    while inside.left() > 0 {
        *left = left.checked_sub(1).ok_or_else(|| {
            format!("the file has more than {MOST_COMPONENTS} components; it must have at most so many")
        })?;
        components.push((name(&mut inside)?, value(&mut inside, depth, left)?));
    }
    Ok(Object(components))
}

/// Reads a text that ends with a zero byte.
fn name<'a>(bytes: &mut Bytes<'a>) -> Result<&'a [u8], String> {
    let mut ahead = *bytes;
    let rest = ahead.take(ahead.left())?;
    let length = rest
        .iter()
        .position(|&byte| byte == 0)
        .ok_or_else(|| format!("a text that starts at byte {} has no end; a zero byte must end it", bytes.at()))?;
    let text = bytes.take(length)?;
    bytes.skip(1)?;
    Ok(text)
}

fn value<'a>(bytes: &mut Bytes<'a>, depth: usize, left: &mut usize) -> Result<Value<'a>, String> {
    let kind = bytes.u8()?;
    let mut array = |size: usize| -> Result<&'a [u8], String> {
        let count = bytes.u32()? as usize;
        bytes.take(count.saturating_mul(size))
    };
    Ok(match kind {
        b'D' => Value::Reals(array(8)?),
        b'C' => array(1).map(|_| Value::Other)?,
        b'I' => array(4).map(|_| Value::Other)?,
        b'Q' => array(8).map(|_| Value::Other)?,
        b'b' | b'c' => bytes.skip(1).map(|()| Value::Other)?,
        b'i' => Value::Whole(bytes.i32()?.into()),
        b'q' => Value::Whole(bytes.i64()?),
        b'd' => Value::Real(bytes.f64()?),
        b's' => Value::Text(name(bytes)?),
        b'S' => {
            for _ in 0..bytes.u32()? {
                name(bytes)?;
            }
            Value::Other
        }
        b'o' => match depth.checked_sub(1) {
            Some(depth) => Value::Object(object(bytes, depth, left)?),
            None => return Err(format!("objects lie inside each other more than {DEPTH} deep; they must not")),
        },
        b'O' => {
            for _ in 0..bytes.u32()? {
                name(bytes)?;
                let size = bytes.u32()? as usize;
                bytes.skip(size)?;
            }
            Value::Other
        }
        other => {
            return Err(format!(
                "a component has the type {:?}; it must be one of b, c, i, q, d, s, o and their arrays",
                char::from(other)
            ));
        }
    })
}

fn open_gsf(file: &File) -> Result<Contents<'_>, String> {
    let bytes = file.bytes()?;
    let end = bytes.iter().position(|&byte| byte == 0).ok_or("the header has no end; a zero byte must end it")?;
    let header = text(&bytes[..end]);
    let mut entries: Vec<(String, String)> = header
        .lines()
        .skip(1)
        .filter_map(|line| line.split_once('='))
        .map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned()))
        .collect();
    let mut take = |key: &str| {
        let position = entries.iter().position(|(found, _)| found == key)?;
        Some(entries.remove(position).1)
    };
    let mut points = |key: &str| {
        let found = take(key).ok_or_else(|| format!("the header has no {key}; it must have one"))?;
        let value: u64 = found.parse().map_err(|_| format!("{key} is {:?}; it must be a number", clip(&found)))?;
        super::bytes::count(key, value)
    };
    let points = [points("XRes")?, points("YRes")?];
    let mut length = |key: &str| match take(key) {
        None => Ok(None),
        Some(found) => {
            let value = found.parse().map_err(|_| format!("{key} is {:?}; it must be a number", clip(&found)))?;
            positive(key, value).map(Some)
        }
    };
    let lengths = match (length("XReal")?, length("YReal")?) {
        (Some(x), _) if points[1] == 1 => Some([x, 1.0]),
        (Some(x), Some(y)) => Some([x, y]),
        (None, None) => None,
        _ => return Err("only one of XReal and YReal is given; both or neither must be given".into()),
    };
    let mut unit = |key: &str| take(key).filter(|unit| !unit.is_empty());
    let (length_unit, height_unit) = (unit("XYUnits"), unit("ZUnits"));
    if let Some(unit) = height_unit.as_deref().filter(|unit| !is_length(unit)) {
        return Err(format!("the numbers are in {}; they must be heights in a unit of length", clip(unit)));
    }
    let name = take("Title").unwrap_or_default();
    // The header is padded to a multiple of four with one to four zero bytes.
    let start = (end / 4 + 1) * 4;
    let data = bytes.get(start..).unwrap_or_default();
    let grid = Grid { points, sample: Sample::F32, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] };
    let unit = height_unit.clone();
    let read = move || {
        let heights = grid.read(data, |height| height)?;
        Ok(Map { heights, lengths, length_unit, height_unit, details: entries, ..Map::default() })
    };
    Ok(Channel { name, unit, points, read: Box::new(read) }.into())
}
