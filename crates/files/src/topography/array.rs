//! Arrays of NumPy: `.npy`, one array `[x, y]` or `[x]`; `.npz`, several of them under names. They have no sizes and units.

use std::io::Read;

use crate::npy::{self, Header};

use super::bytes::{Grid, Layout, MOST_CHANNELS, Order, Sample};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::two_dimensional;
use super::zipped::Zip;

pub(super) const FORMAT: Format =
    Format { name: "NumPy", sniff: |file| file.starts_with(npy::MAGIC), open, first_line: FirstLine::Bottom };

pub(super) const ARCHIVE: Format =
    Format { name: "NumPy archive", sniff: is_archive, open: open_archive, first_line: FirstLine::Bottom };

/// The most bytes of a header; NumPy's own have at most 64 KiB.
const HEADER: u64 = 1 << 16;

fn open(file: &File) -> Result<Contents<'_>, String> {
    let bytes = file.bytes()?;
    let header = Header::parse(bytes)?;
    let grid = grid(&header)?;
    let read = move || {
        let heights = grid.read(&bytes[header.data..], |height| height)?;
        Ok(Map { heights, ..Map::default() })
    };
    Ok(Channel { name: String::new(), unit: None, points: grid.points, read: Box::new(read) }.into())
}

fn is_archive(file: &File) -> bool {
    let all_arrays = |names: Vec<String>| !names.is_empty() && names.iter().all(|name| name.ends_with(".npy"));
    file.starts_with(b"PK") && Zip::open(file).is_ok_and(|zip| all_arrays(zip.names()))
}

fn open_archive(file: &File) -> Result<Contents<'_>, String> {
    let mut zip = Zip::open(file)?;
    let mut channels = Vec::new();
    for entry in zip.names().into_iter().take(MOST_CHANNELS) {
        let mut start = Vec::new();
        zip.stream(&entry)?.0.take(HEADER).read_to_end(&mut start).map_err(|error| format!("{entry}: {error}"))?;
        let Ok(header) = Header::parse(&start) else { continue };
        let Ok(grid) = grid(&header) else { continue };
        let name = entry.trim_end_matches(".npy").to_owned();
        let read = move || {
            let mut zip = Zip::open(file)?;
            let (mut stream, compressed) = zip.stream(&entry)?;
            let mut skipped = vec![0; header.data];
            stream.read_exact(&mut skipped).map_err(|error| format!("{entry}: {error}"))?;
            let heights = grid.inflate(compressed, stream, |height| height)?;
            Ok(Map { heights, ..Map::default() })
        };
        channels.push(Channel { name, unit: None, points: grid.points, read: Box::new(read) });
    }
    if channels.is_empty() {
        return Err("the archive has no array of real numbers with 1 or 2 dimensions; it must have one".into());
    }
    Ok(channels.into())
}

/// The grid of an array `[x, y]`, which NumPy stores with y running fastest unless it says otherwise.
fn grid(header: &Header) -> Result<Grid, String> {
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
