//! MountainsMap (`.mnt`): documents of the program of Digital Surf. Numbers are little-endian.
//!
//! The stream `ScopedContents` of a compound file is a tree of numbered parts. Only measured surfaces are read: their
//! axes, counts in compressed blocks in any order, the top line first, and a mask of points that were measured. The
//! program computes levelled and filtered surfaces again, and does not store them.

mod compound;

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::bytes::{Bytes, MOST_CHANNELS, Order, Sample, count, factor, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, size};
use super::unit::{Conversion, Sides};
use compound::Compound;

pub(crate) const FORMAT: Format = Format { name: "MountainsMap", sniff, open, first_line: FirstLine::Top };

const STREAM: &str = "ScopedContents";

/// Number of a part with the inherited parts of an object.
const BASE: u16 = 0xffff;

/// Path of the objects of a document, and classes of a measured surface and of a mask.
const OBJECTS: [u16; 4] = [1, 0x2bd, 2, 1];
const MEASURED: u32 = 9012;
const MASK: u32 = 9056;

/// Mark of a point that was measured.
const IS_MEASURED: f64 = 9.0;

/// Largest ratio of compression by deflate.
const LARGEST_RATIO: u64 = 1032;

fn sniff(file: &File) -> bool {
    compound::is_compound(file.head())
        && file.bytes().and_then(Compound::open).is_ok_and(|compound| compound.has(STREAM))
}

/// Returns the tree of a document.
fn stream(file: &File) -> Result<Vec<u8>, String> {
    let mut tree = Compound::open(file.bytes()?)?.stream(STREAM)?;
    let length = Bytes::new(&tree, Order::Little).u64()?;
    let length = usize::try_from(length).unwrap_or(usize::MAX).min(tree.len() - 8);
    tree.truncate(8 + length);
    tree.drain(..8);
    Ok(tree)
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let tree = stream(file)?;
    let surfaces = surfaces(&tree)?;
    if surfaces.is_empty() {
        return Err("the document has no measured surface; export the surface from MountainsMap as .sur".into());
    }
    let channel = |(number, body): (usize, &&[u8])| {
        let surface = Surface::read(body)?;
        surface.check()?;
        let read = Box::new(move || {
            let tree = stream(file)?;
            let body = surfaces_at(&tree, number)?;
            Surface::read(body)?.map()
        });
        Ok(Channel { name: surface.name.clone(), unit: Some(surface.z.display.clone()), points: surface.points, read })
    };
    surfaces.iter().enumerate().map(channel).collect::<Result<Vec<_>, String>>().map(Into::into)
}

/// Returns the parts of a body: numbers and bodies.
fn parts(body: &[u8]) -> impl Iterator<Item = (u16, &[u8])> {
    let mut bytes = Bytes::new(body, Order::Little);
    std::iter::from_fn(move || {
        let number = bytes.u16().ok()?;
        let length = usize::try_from(bytes.u64().ok()?).ok()?;
        bytes.take(length).ok().map(|part| (number, part))
    })
}

/// Returns the part at a path of numbers.
fn part<'a>(body: &'a [u8], path: &[u16]) -> Option<&'a [u8]> {
    path.iter().try_fold(body, |body, number| parts(body).find(|(found, _)| found == number).map(|(_, part)| part))
}

/// Returns the part at a path, or an error with its name.
fn needed<'a>(body: &'a [u8], path: &[u16], what: &str) -> Result<&'a [u8], String> {
    part(body, path).ok_or_else(|| format!("a surface has no {what}; it must have it"))
}

fn whole(body: &[u8], path: &[u16], what: &str) -> Result<u32, String> {
    Bytes::new(needed(body, path, what)?, Order::Little).u32()
}

fn number(body: &[u8], path: &[u16], what: &str) -> Result<f64, String> {
    Bytes::new(needed(body, path, what)?, Order::Little).f64()
}

/// Returns a text of 16-bit characters after a byte 4.
fn text(body: &[u8], path: &[u16]) -> String {
    let bytes = part(body, path).and_then(|bytes| bytes.strip_prefix(&[4])).unwrap_or_default();
    let units = bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    char::decode_utf16(units).map(|found| found.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// Returns the bodies of the measured surfaces.
fn surfaces(tree: &[u8]) -> Result<Vec<&[u8]>, String> {
    let list = part(tree, &OBJECTS).ok_or("the document has no list of objects; it must have one")?;
    let (mut bytes, mut found) = (Bytes::new(list, Order::Little), Vec::new());
    while bytes.left() > 8 && found.len() < MOST_CHANNELS {
        bytes.skip(8)?;
        let (number, length) = (bytes.u16()?, bytes.u64()?);
        let object = bytes.take(usize::try_from(length).unwrap_or(usize::MAX))?;
        let class = part(object, &[1, 1]).and_then(|class| Bytes::new(class, Order::Little).u32().ok());
        if let (1, Some(MEASURED), Some(body)) = (number, class, part(object, &[2, 1, 2, BASE])) {
            found.push(body);
        }
    }
    Ok(found)
}

/// Returns the body of a measured surface.
fn surfaces_at(tree: &[u8], number: usize) -> Result<&[u8], String> {
    surfaces(tree)?.into_iter().nth(number).ok_or_else(|| format!("the document has no surface {number}"))
}

/// Scale of an axis: its step in a unit, and its origin in the unit shown.
struct Axis {
    step: f64,
    unit: String,
    display: String,
    origin: f64,
}

impl Axis {
    fn read(body: &[u8], path: &[u16], what: &str) -> Result<Self, String> {
        let body = needed(body, path, what)?;
        let unit = text(body, &[2]);
        let display = Some(text(body, &[3])).filter(|display| !display.is_empty()).unwrap_or_else(|| unit.clone());
        let origin = part(body, &[5]).map_or(Ok(0.0), |bytes| Bytes::new(bytes, Order::Little).f64())?;
        Ok(Self { step: number(body, &[1], "step of an axis")?, unit, display, origin })
    }
}

/// Measured surface.
struct Surface<'a> {
    name: String,
    points: [usize; 2],
    axes: [Axis; 2],
    z: Axis,
    counts: Array<'a>,
    mask: Option<Array<'a>>,
}

impl<'a> Surface<'a> {
    fn read(body: &'a [u8]) -> Result<Self, String> {
        let grid = needed(body, &[BASE], "grid")?;
        let points = |axis: u16| whole(grid, &[axis, BASE, 1], "number of points");
        let points = [count("the number of columns", points(1)?)?, count("the number of lines", points(2)?)?];
        let axis = |axis: u16| Axis::read(grid, &[axis, BASE, BASE], "lateral axis");
        // A surface without a mask has a part of another class.
        let mask = part(grid, &[3]).filter(|mask| whole(mask, &[1, 1], "class").is_ok_and(|class| class == MASK));
        let marks = |body| Array::read(needed(body, &[2, 5], "mask")?, [points[0] + 2, points[1] + 2]);
        Ok(Self {
            name: text(grid, &[BASE, BASE, 1]),
            points,
            axes: [axis(1)?, axis(2)?],
            z: Axis::read(body, &[2, BASE], "axis of the heights")?,
            counts: Array::read(needed(body, &[1], "array of heights")?, points)?,
            mask: mask.map(marks).transpose()?,
        })
    }

    /// Returns the height of a count in the unit shown.
    fn scale(&self) -> Result<f64, String> {
        let conversion = Conversion::between(&self.z.unit, &self.z.display)?;
        factor("the height of a count", conversion.map_or(self.z.step, |conversion| conversion.apply(self.z.step)))
    }

    fn sides(&self) -> Result<Sides, String> {
        let [x, y] = &self.axes;
        let spacing = [positive("the spacing along x", x.step)?, positive("the spacing along y", y.step)?];
        let lengths = size(self.points, spacing);
        let side = |axis: usize| (lengths[axis], Some(self.axes[axis].unit.clone()));
        Sides::of(side(0), Some(side(1)).filter(|_| self.points[1] > 1))
    }

    fn check(&self) -> Result<(), String> {
        self.scale()?;
        self.sides().map(|_| ())
    }

    /// Decodes the heights.
    fn map(&self) -> Result<Map, String> {
        let (scale, sides, [nx, ny]) = (self.scale()?, self.sides()?, self.points);
        let mut heights = ndarray::Array2::from_elem((nx, ny), f64::NAN);
        self.counts.each(|k, count| heights[[k % nx, k / nx]] = scale * count + self.z.origin)?;
        if let Some(mask) = &self.mask {
            // The mask has a border of one point.
            mask.each(|k, mark| {
                let [x, y] = [k % (nx + 2), k / (nx + 2)];
                if mark != IS_MEASURED && (1..=nx).contains(&x) && (1..=ny).contains(&y) {
                    heights[[x - 1, y - 1]] = f64::NAN;
                }
            })?;
        }
        let (lengths, length_unit) = (Some(sides.lengths), sides.unit);
        let height_unit = Some(self.z.display.clone());
        Ok(Map { heights, lengths, length_unit, height_unit, notes: sides.notes, ..Map::default() })
    }
}

/// Compressed numbers, in blocks of any order.
struct Array<'a> {
    sample: Sample,
    /// Number of the first element, number of elements, and bytes of each block, by the first.
    blocks: Vec<(u64, u32, &'a [u8])>,
}

impl<'a> Array<'a> {
    /// Reads the heads of the blocks, which must hold each of the points once.
    fn read(body: &'a [u8], [nx, ny]: [usize; 2]) -> Result<Self, String> {
        let elements = u64::from(whole(body, &[2, 1], "number of elements")?);
        let mut bytes = Bytes::new(needed(body, &[2, 2], "elements")?, Order::Little);
        let length = bytes.u64()?;
        if elements != nx as u64 * ny as u64 {
            return Err(format!("an array has {elements} elements for {nx} by {ny} points; it must have as many"));
        }
        let sample = match length.checked_div(elements) {
            Some(1) => Sample::U8,
            Some(2) => Sample::I16,
            Some(4) => Sample::I32,
            _ => return Err(format!("{elements} elements have {length} bytes; each must have 1, 2 or 4")),
        };
        let mut blocks = Vec::new();
        while bytes.left() > 0 {
            let (first, count, length) = (bytes.u64()?, bytes.u32()?, bytes.u32()? as usize);
            let data = bytes.take(length)?;
            if u64::from(count) * sample.size() as u64 > length as u64 * LARGEST_RATIO {
                return Err(format!("a block has {count} elements in {length} bytes; they cannot hold so much"));
            }
            blocks.push((first, count, data));
        }
        blocks.sort_by_key(|(first, ..)| *first);
        let mut next = 0;
        for (first, count, _) in &blocks {
            if *first != next {
                return Err(format!("a block begins with element {first}; it must begin with {next}"));
            }
            next += u64::from(*count);
        }
        if next != elements {
            return Err(format!("the blocks have {next} elements; they must have {elements}"));
        }
        Ok(Self { sample, blocks })
    }

    /// Calls `found` with the index and the value of each element.
    fn each(&self, mut found: impl FnMut(usize, f64)) -> Result<(), String> {
        let size = self.sample.size();
        let mut index = 0;
        for (_, count, data) in &self.blocks {
            let mut stream = std::io::BufReader::new(ZlibDecoder::new(*data));
            let mut element = [0; 8];
            for _ in 0..*count {
                stream.read_exact(&mut element[..size]).map_err(|error| format!("a block is damaged: {error}"))?;
                found(index, self.sample.decode(&element[..size], Order::Little));
                index += 1;
            }
        }
        Ok(())
    }
}
