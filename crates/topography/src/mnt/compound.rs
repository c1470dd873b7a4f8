//! Compound files (OLE): a file system of streams in sectors, linked by a table.

use crate::bytes::{Bytes, Order, clip};

const MAGIC: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";

/// Largest number of a sector; higher ones are marks.
const LAST_SECTOR: u32 = 0xffff_fffa;

/// Positions in the header: size of a sector, first sectors of the folder and of the table of tables, and the tables.
const SHIFT: usize = 30;
const FOLDER: usize = 48;
const SMALLEST: usize = 56;
const TABLES: usize = 68;
const FIRST_TABLES: usize = 109;

/// Length of an entry of the folder.
const ENTRY: usize = 128;

pub(super) fn is_compound(head: &[u8]) -> bool {
    head.starts_with(MAGIC)
}

/// Compound file.
pub(super) struct Compound<'a> {
    all: &'a [u8],
    sector: usize,
    /// Next sector of each sector.
    table: Vec<u32>,
    /// Streams: name, first sector and length.
    streams: Vec<(String, u32, u64)>,
    /// Smallest length of a stream in sectors of its own.
    smallest: u64,
}

impl<'a> Compound<'a> {
    pub(super) fn open(all: &'a [u8]) -> Result<Self, String> {
        let mut bytes = Bytes::new(all, Order::Little);
        bytes.seek(SHIFT)?;
        let sector = match bytes.u16()? {
            shift @ (9 | 12) => 1 << shift,
            other => return Err(format!("a sector has 2^{other} bytes; it must have 512 or 4096")),
        };
        bytes.seek(FOLDER)?;
        let folder = bytes.u32()?;
        bytes.seek(SMALLEST)?;
        let smallest = bytes.u32()?.into();
        let mut compound = Self { all, sector, table: Vec::new(), streams: Vec::new(), smallest };
        compound.read_table()?;
        let folder = compound.chain(folder, None)?;
        compound.streams = folder.chunks_exact(ENTRY).filter_map(entry).collect();
        Ok(compound)
    }

    /// Returns true if the file has a stream with this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.streams.iter().any(|(found, ..)| found == name)
    }

    /// Returns the bytes of a stream.
    pub(super) fn stream(&self, name: &str) -> Result<Vec<u8>, String> {
        let found = self.streams.iter().find(|(found, ..)| found == name);
        let (_, first, length) = found.ok_or_else(|| format!("the file has no stream {}", clip(name)))?;
        if *length < self.smallest {
            return Err(format!(
                "the stream {} has {length} bytes; it must have at least {}",
                clip(name),
                self.smallest
            ));
        }
        self.chain(*first, Some(*length))
    }

    /// Returns the bytes of a sector. The last one may be cut.
    fn sector(&self, number: u32) -> Result<&'a [u8], String> {
        let start = (number as usize).checked_add(1).and_then(|number| number.checked_mul(self.sector));
        let rest = start.and_then(|start| self.all.get(start..)).filter(|rest| !rest.is_empty());
        let rest =
            rest.ok_or_else(|| format!("the sector {number} lies beyond the {} bytes of the file", self.all.len()))?;
        Ok(&rest[..rest.len().min(self.sector)])
    }

    /// Reads the table of the next sectors, whose own sectors are listed in the header and in further sectors.
    fn read_table(&mut self) -> Result<(), String> {
        let mut bytes = Bytes::new(self.all, Order::Little);
        bytes.seek(TABLES)?;
        let mut more = bytes.u32()?;
        bytes.skip(4)?;
        let mut list = bytes.take(4 * FIRST_TABLES)?;
        let most = self.all.len() / 4;
        loop {
            let is_last = more > LAST_SECTOR;
            let next = if is_last { &[][..] } else { self.sector(more)? };
            for number in numbers(list).filter(|number| *number <= LAST_SECTOR) {
                self.table.extend(numbers(self.sector(number)?));
                if self.table.len() > most {
                    return Err("the table of sectors has more entries than the file has bytes; it must not".into());
                }
            }
            if is_last {
                return Ok(());
            }
            let split = next.len().saturating_sub(4);
            list = &next[..split];
            more = numbers(&next[split..]).next().unwrap_or(u32::MAX);
            // Each further sector lists at least one, so that the loop ends.
            if numbers(list).all(|number| number > LAST_SECTOR) {
                return Ok(());
            }
        }
    }

    /// Returns the bytes of linked sectors, `length` of them if given.
    fn chain(&self, first: u32, length: Option<u64>) -> Result<Vec<u8>, String> {
        let (mut bytes, mut number) = (Vec::new(), first);
        let wanted = length.map_or(usize::MAX, |length| usize::try_from(length).unwrap_or(usize::MAX));
        while number <= LAST_SECTOR && bytes.len() < wanted {
            bytes.extend_from_slice(self.sector(number)?);
            if bytes.len() > self.all.len() {
                return Err("a stream has more bytes than the file; its sectors must not be linked in a circle".into());
            }
            number = self.table.get(number as usize).copied().unwrap_or(u32::MAX);
        }
        match length {
            Some(_) if bytes.len() < wanted => {
                Err(format!("a stream has {} bytes; it must have {wanted}", bytes.len()))
            }
            Some(_) => {
                bytes.truncate(wanted);
                Ok(bytes)
            }
            None => Ok(bytes),
        }
    }
}

fn numbers(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
}

/// Reads an entry of the folder if it is a stream.
fn entry(bytes: &[u8]) -> Option<(String, u32, u64)> {
    const STREAM: u8 = 2;
    let mut at = Bytes::new(bytes, Order::Little);
    let name = at.take(64).ok()?;
    let length = usize::from(at.u16().ok()?).min(64);
    let kind = at.u8().ok()?;
    at.seek(116).ok()?;
    let (first, size) = (at.u32().ok()?, at.u64().ok()?);
    let units =
        name.get(..length.saturating_sub(2))?.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    let name = char::decode_utf16(units).map(|found| found.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    (kind == STREAM).then_some((name, first, size))
}
