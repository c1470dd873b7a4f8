//! NumPy array files (`.npy`).

use std::path::Path;

use ndarray::{ArrayD, IxDyn, ShapeBuilder};

use crate::input::{self, MOST_BYTES};

/// First bytes of a file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// Maximum number of dimensions, as in NumPy.
const MOST_DIMENSIONS: usize = 64;

/// Reads an array of real numbers of any shape as double precision.
///
/// # Errors
/// A file that cannot be read or does not contain real numbers. The message does not contain the path.
pub fn read(path: impl AsRef<Path>) -> Result<ArrayD<f64>, String> {
    parse(&input::bytes(path, MOST_BYTES).map_err(|error| error.to_string())?)
}

/// Reads an array from the bytes of a file. Nothing is allocated before the bytes for it are known to exist.
///
/// # Errors
/// Bytes that are not an array of real numbers.
pub fn parse(bytes: &[u8]) -> Result<ArrayD<f64>, String> {
    let header = Header::parse(bytes)?;
    let count = header.shape.iter().try_fold(1_usize, |count, &length| count.checked_mul(length));
    let data = &bytes[header.data.min(bytes.len())..];
    let size = header.number.size;
    let available = data.len() / size;
    let Some(count) = count.filter(|&count| count <= available) else {
        return Err(format!(
            "the shape is {:?} but the file has {available} numbers; it is truncated or damaged",
            header.shape
        ));
    };
    header.check_end(bytes.len(), count * size)?;
    let values = data.chunks_exact(size).take(count).map(|entry| header.number.value(entry)).collect();
    let shape = IxDyn(&header.shape);
    let array = if header.column_major {
        ArrayD::from_shape_vec(shape.f(), values)
    } else {
        ArrayD::from_shape_vec(shape, values)
    };
    array.map_err(|error| error.to_string())
}

/// Header of a file.
pub(crate) struct Header {
    pub(crate) shape: Vec<usize>,
    pub(crate) column_major: bool,
    pub(crate) number: Number,
    /// Position of the first entry.
    pub(crate) data: usize,
}

impl Header {
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, String> {
        let damaged = || "the header of the NumPy array is damaged".to_owned();
        if !bytes.starts_with(MAGIC) {
            return Err("the file does not begin like a NumPy array; it must be one".into());
        }
        // The header length has two bytes in version 1, four in later versions.
        let (start, length) = match *bytes {
            [_, _, _, _, _, _, 1, _, a, b, ..] => (10, usize::from(u16::from_le_bytes([a, b]))),
            [_, _, _, _, _, _, 2..=3, _, a, b, c, d, ..] => (12, u32::from_le_bytes([a, b, c, d]) as usize),
            _ => return Err(damaged()),
        };
        let data = start + length;
        let text = std::str::from_utf8(bytes.get(start..data).ok_or_else(damaged)?).map_err(|_| damaged())?;
        let value = |key: &str| {
            let after =
                [format!("'{key}'"), format!("\"{key}\"")].iter().find_map(|key| text.split_once(key.as_str()))?.1;
            Some(after.trim_start().strip_prefix(':')?.trim_start())
        };
        let column_major = value("fortran_order").ok_or_else(damaged)?.starts_with("True");
        let shape = value("shape").and_then(|text| text.strip_prefix('(')?.split_once(')')).ok_or_else(damaged)?.0;
        let lengths =
            shape.split(',').map(|length| length.trim().trim_end_matches('L')).filter(|length| !length.is_empty());
        let shape: Vec<usize> = lengths.map(str::parse).collect::<Result<_, _>>().map_err(|_| damaged())?;
        if shape.len() > MOST_DIMENSIONS {
            return Err(damaged());
        }
        let kind = value("descr").ok_or_else(damaged)?;
        let number = Number::parse(kind).ok_or_else(|| {
            let found: String = kind.chars().take(40).collect();
            let found = found.split_once(", 'fortran_order'").map_or(&found[..], |(kind, _)| kind);
            format!("the entries have the type {found}; they must be real numbers, floats of 32 or 64 bits or integers")
        })?;
        Ok(Self { shape, column_major, number, data })
    }

    /// Checks that a file of `found` bytes ends with the last entry, as files of NumPy do.
    ///
    /// # Errors
    /// A file that is longer than its header says.
    pub(crate) fn check_end(&self, found: usize, entries: usize) -> Result<(), String> {
        let needed = self.data + entries;
        match found > needed {
            true => Err(format!(
                "the file has {found} bytes; it must have {needed} for the shape {:?}, so it was changed or holds \
                 several arrays",
                self.shape
            )),
            false => Ok(()),
        }
    }
}

/// Type of the entries.
pub(crate) struct Number {
    /// `f` for floats, `i` and `u` for signed and unsigned integers, `b` for booleans.
    pub(crate) kind: char,
    /// Number of bytes.
    pub(crate) size: usize,
    pub(crate) big_endian: bool,
}

impl Number {
    /// Parses a description such as `'<f8'`.
    fn parse(text: &str) -> Option<Self> {
        let quote = text.chars().next().filter(|quote| ['\'', '"'].contains(quote))?;
        let mut description = text[1..].split(quote).next()?.chars();
        let order = description.next()?;
        let kind = description.next()?;
        let size = description.as_str().parse().ok()?;
        let known = matches!((kind, size), ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1));
        (known && ['<', '>', '|', '='].contains(&order)).then_some(Self { kind, size, big_endian: order == '>' })
    }

    /// Returns the value of an entry; 64-bit integers are rounded.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the lowest bits of a word are the number; a size is at most 8"
    )]
    fn value(&self, entry: &[u8]) -> f64 {
        let mut bytes = [0; 8];
        for (k, byte) in bytes.iter_mut().take(self.size).enumerate() {
            *byte = entry[if self.big_endian { self.size - 1 - k } else { k }];
        }
        let bits = u64::from_le_bytes(bytes);
        // Shifting to the top and back extends the sign to the upper bits.
        let unused = 64 - 8 * self.size as u32;
        match (self.kind, self.size) {
            ('f', 4) => f64::from(f32::from_bits(bits as u32)),
            ('f', _) => f64::from_bits(bits),
            ('i', _) => (((bits << unused) as i64) >> unused) as f64,
            _ => bits as f64,
        }
    }
}
