//! MATLAB 5 workspaces (`save -v6`, `-v7`), compressed or not, in either byte order.
//!
//! Every real matrix with more than one number is a channel; its rows run along x and its columns along y, a vector is
//! a profile. Channels have no sizes and units.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::bytes::{Bytes, Grid, Layout, MOST_CHANNELS, Order, Sample, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format =
    Format { name: "MATLAB 5", sniff: |file| order(file.head()).is_some(), open, first_line: FirstLine::Bottom };

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Number of bytes before the first element.
const HEADER: usize = 128;

/// Largest number of bytes of the name of a variable, and of its dimensions.
const MOST_NAME: usize = 4096;

/// Returns the byte order given by version and mark at the end of the header.
fn order(head: &[u8]) -> Option<Order> {
    if !head.starts_with(b"MATLAB") {
        return None;
    }
    match head.get(124..HEADER)? {
        [0, 1 | 2, b'I', b'M'] => Some(Order::Little),
        [1 | 2, 0, b'M', b'I'] => Some(Order::Big),
        _ => None,
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    if file.starts_with(b"MATLAB 7.3") {
        return Err("the file was saved with -v7.3; it must be saved with -v7 or -v6".into());
    }
    let order = order(file.head()).ok_or("the header is damaged")?;
    let mut bytes = Bytes::new(file.bytes()?, order);
    bytes.skip(HEADER)?;
    let (mut channels, mut others) = (Vec::new(), Vec::new());
    // The last element may lack its padding.
    while bytes.left() >= 8 {
        let (kind, length) = (bytes.u32()?, bytes.u32()? as usize);
        let element = bytes.take(length)?;
        let found = match kind {
            COMPRESSED => Matrix::head(&mut ZlibDecoder::new(element), order, true)?,
            MATRIX => {
                bytes.skip((length.wrapping_neg() % 8).min(bytes.left()))?;
                Matrix::head(&mut &*element, order, false)?
            }
            _ => continue,
        };
        match found {
            Ok(matrix) if channels.len() < MOST_CHANNELS => channels.push(matrix.channel(element, kind, order)),
            Ok(_) => {
                return Err(format!("the file has more than {MOST_CHANNELS} matrices; it must have at most so many"));
            }
            Err(name) if others.len() < 20 => others.push(name),
            Err(_) => {}
        }
    }
    match channels.is_empty() {
        true => Err(format!("the file has no real matrix with two or more numbers; it has {}", others.join(", "))),
        false => Ok(channels.into()),
    }
}

/// Real matrix, read up to its numbers.
struct Matrix {
    name: String,
    grid: Grid,
    /// Number of bytes of the numbers.
    bytes: usize,
}

impl Matrix {
    /// Reads the head of a variable; if compressed, its own tag comes first. The inner error is the name of a variable
    /// that is not a real matrix.
    fn head(stream: &mut impl Read, order: Order, tagged: bool) -> Result<Result<Self, String>, String> {
        let mut stream = Stream { stream, order };
        if tagged && stream.tag()?.0 != MATRIX {
            return Ok(Err(String::new()));
        }
        let flags = stream.element()?;
        let class = Bytes::new(&flags, order).u32()?;
        let dimensions = stream.element()?;
        let mut lengths = Bytes::new(&dimensions, order);
        let mut shape = Vec::new();
        while lengths.left() >= 4 {
            shape.push(usize::try_from(lengths.i32()?).map_err(|_| "a dimension is negative; it must not be")?);
        }
        let name = text(&stream.element()?);
        let points = match shape[..] {
            [1, n] | [n, 1] => [n, 1],
            [rows, columns] => [rows, columns],
            _ => return Ok(Err(name)),
        };
        // Classes 6 to 15 are numbers; bit 11 marks complex numbers.
        if !(6..=15).contains(&(class & 0xff)) || class & 0x800 != 0 || points == [1, 1] || points.contains(&0) {
            return Ok(Err(name));
        }
        let (kind, bytes, inline) = stream.tag()?;
        let sample = match kind {
            1 => Sample::I8,
            2 => Sample::U8,
            3 => Sample::I16,
            4 => Sample::U16,
            5 => Sample::I32,
            6 => Sample::U32,
            7 => Sample::F32,
            9 => Sample::F64,
            12 => Sample::I64,
            13 => Sample::U64,
            _ => return Err(format!("the numbers of {name} have the type {kind}; it must be between 1 and 13")),
        };
        debug_assert!(inline.is_none() || bytes <= 4);
        let grid = Grid { points, sample, order, layout: Layout::Lines, backwards: [false; 2] };
        if grid.bytes()? != bytes {
            return Err(format!(
                "the matrix {name} has {points:?} points in {bytes} bytes; it must have {}",
                grid.bytes()?
            ));
        }
        Ok(Ok(Self { name, grid, bytes }))
    }

    /// Returns the channel of a matrix in the bytes of its element.
    fn channel(self, element: &[u8], kind: u32, order: Order) -> Channel<'_> {
        let Self { name, grid, bytes } = self;
        let read = move || {
            let heights = if kind == COMPRESSED {
                let mut stream = ZlibDecoder::new(element);
                numbers(&mut stream, order, true)?;
                grid.inflate(element.len(), stream.take(bytes as u64), |height| height)?
            } else {
                let mut stream = element;
                numbers(&mut stream, order, false)?;
                grid.read(stream, |height| height)?
            };
            Ok(Map { heights, ..Map::default() })
        };
        Channel { name, unit: None, points: grid.points, read: Box::new(read) }
    }
}

/// Moves to the numbers of a matrix.
fn numbers(stream: &mut impl Read, order: Order, tagged: bool) -> Result<(), String> {
    let mut stream = Stream { stream, order };
    if tagged {
        stream.tag()?;
    }
    for _ in 0..3 {
        stream.element()?;
    }
    stream.tag().map(|_| ())
}

/// Reader of the elements inside a variable.
struct Stream<'a, R> {
    stream: &'a mut R,
    order: Order,
}

impl<R: Read> Stream<'_, R> {
    fn exactly<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.stream.read_exact(&mut bytes).map_err(|error| format!("a variable is damaged: {error}"))?;
        Ok(bytes)
    }

    /// Reads type and number of bytes of the next element; a short element has its bytes in the tag.
    fn tag(&mut self) -> Result<(u32, usize, Option<[u8; 4]>), String> {
        let first = self.exactly::<4>()?;
        let word = Bytes::new(&first, self.order).u32()?;
        let next = self.exactly::<4>()?;
        match word >> 16 {
            0 => Ok((word, Bytes::new(&next, self.order).u32()? as usize, None)),
            length @ 1..=4 => Ok((word & 0xffff, length as usize, Some(next))),
            length => Err(format!("a short element has {length} bytes; it must have at most 4")),
        }
    }

    /// Reads the bytes of the next element.
    fn element(&mut self) -> Result<Vec<u8>, String> {
        let (_, length, inline) = self.tag()?;
        if let Some(bytes) = inline {
            return Ok(bytes[..length].to_vec());
        }
        if length > MOST_NAME {
            return Err(format!(
                "name or dimensions of a variable have {length} bytes; they must have at most {MOST_NAME}"
            ));
        }
        let mut bytes = vec![0; length.next_multiple_of(8)];
        self.stream.read_exact(&mut bytes).map_err(|error| format!("a variable is damaged: {error}"))?;
        bytes.truncate(length);
        Ok(bytes)
    }
}
