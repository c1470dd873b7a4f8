//! NumPy arrays, `.npy`: `[x, y]` or `[x]`, without sizes and units.

use crate::npy::{self, Header};

use super::bytes::{Grid, Layout, Order, Sample};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::two_dimensional;

pub(crate) const FORMAT: Format =
    Format { name: "NumPy", sniff: |file| file.starts_with(npy::MAGIC), open, first_line: FirstLine::Bottom };

fn open(file: &File) -> Result<Contents<'_>, String> {
    let bytes = file.bytes()?;
    let header = Header::parse(bytes)?;
    let grid = grid(&header)?;
    header.check_end(bytes.len(), grid.bytes()?)?;
    let read = move || {
        let heights = grid.read(&bytes[header.data..], |height| height)?;
        Ok(Map { heights, ..Map::default() })
    };
    Ok(Channel { name: String::new(), unit: None, points: grid.points, read: Box::new(read) }.into())
}

/// Returns the grid of an array `[x, y]`, stored with y running fastest unless the header says otherwise.
pub(crate) fn grid(header: &Header) -> Result<Grid, String> {
    let number = &header.number;
    let sample = match (number.kind, number.size) {
        ('f', 4) => Sample::F32,
        ('f', _) => Sample::F64,
        ('i', 1) => Sample::I8,
        ('i', 2) => Sample::I16,
        ('i', 4) => Sample::I32,
        ('i', _) => Sample::I64,
        (_, 1) => Sample::U8,
        (_, 2) => Sample::U16,
        (_, 4) => Sample::U32,
        (_, _) => Sample::U64,
    };
    Ok(Grid {
        points: two_dimensional(&header.shape)?,
        sample,
        order: if number.big_endian { Order::Big } else { Order::Little },
        layout: if header.column_major { Layout::Lines } else { Layout::Columns },
        backwards: [false; 2],
    })
}
