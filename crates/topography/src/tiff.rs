//! TIFF: pages of tags, and the formats that keep height maps in them.
//!
//! JPK, Park and LEXT have their own tags; other pages are images, with the size of a pixel from ImageJ, OME or GeoTIFF
//! if there is one.

mod geo;
mod image;
pub(crate) mod jpk;
pub(crate) mod lext;
pub(crate) mod park;
pub(crate) mod plain;

use super::bytes::{Bytes, MOST_CHANNELS, Order, Sample, text};
use super::file::File;

/// Tags of an image that several formats read.
const DESCRIPTION: u16 = 270;
const RESOLUTION: [u16; 2] = [282, 283];

/// Returns the order of the bytes of a TIFF file.
fn order(head: &[u8]) -> Option<Order> {
    match head {
        [b'I', b'I', 42, 0, ..] => Some(Order::Little),
        [b'M', b'M', 0, 42, ..] => Some(Order::Big),
        _ => None,
    }
}

/// Returns true if the first page of a file satisfies `has`.
fn first_page(file: &File, has: impl Fn(&Page) -> bool) -> bool {
    let Some(order) = order(file.head()) else { return false };
    let Ok(all) = file.bytes() else { return false };
    let mut bytes = Bytes::new(all, order);
    let first = bytes.seek(4).and_then(|()| bytes.u32());
    first.is_ok_and(|at| Page::read(all, order, at, &mut (all.len() / ENTRY)).is_ok_and(|(page, _)| has(&page)))
}

/// Number of bytes of an entry of a page.
const ENTRY: usize = 12;

/// Entry of a page: a tag, the type of its numbers, their number, and the position of the first.
#[derive(Clone, Copy)]
struct Entry {
    tag: u16,
    kind: u16,
    count: usize,
    at: usize,
}

impl Entry {
    /// Returns the number of bytes of a number of this type; 0 for unknown types.
    fn size(&self) -> usize {
        match self.kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 => 8,
            _ => 0,
        }
    }

    /// Decodes a number of this type.
    fn number(&self, bytes: &[u8], order: Order) -> f64 {
        let sample = match self.kind {
            1 | 2 | 7 => Sample::U8,
            6 => Sample::I8,
            3 => Sample::U16,
            8 => Sample::I16,
            9 | 10 => Sample::I32,
            11 => Sample::F32,
            12 => Sample::F64,
            _ => Sample::U32,
        };
        if matches!(self.kind, 5 | 10) {
            let (above, below) = bytes.split_at(4);
            return sample.decode(above, order) / sample.decode(below, order);
        }
        sample.decode(bytes, order)
    }
}

/// Page: the entries of a directory.
struct Page<'a> {
    all: &'a [u8],
    order: Order,
    entries: Vec<Entry>,
}

impl<'a> Page<'a> {
    /// Reads the page at a position, and the position of the next page. `left` is the number of entries that still fit
    /// into the file after the pages before.
    fn read(all: &'a [u8], order: Order, at: u32, left: &mut usize) -> Result<(Self, u32), String> {
        let mut bytes = Bytes::new(all, order);
        bytes.seek(at as usize)?;
        let count = usize::from(bytes.u16()?);
        *left =
            left.checked_sub(count).ok_or("the pages have more tags than the file has bytes; they must not overlap")?;
        let mut entries = Vec::new();
        for _ in 0..count {
            let (tag, kind, count) = (bytes.u16()?, bytes.u16()?, bytes.u32()? as usize);
            let mut entry = Entry { tag, kind, count, at: bytes.at() };
            let value = bytes.u32()?;
            if entry.size().saturating_mul(count) > 4 {
                entry.at = value as usize;
            }
            entries.push(entry);
        }
        let next = if bytes.left() < 4 { 0 } else { bytes.u32()? };
        Ok((Self { all, order, entries }, next))
    }

    fn entry(&self, tag: u16) -> Option<Entry> {
        self.entries.iter().find(|entry| entry.tag == tag && entry.size() > 0).copied()
    }

    fn has(&self, tag: u16) -> bool {
        self.entry(tag).is_some()
    }

    /// Returns the bytes of a tag.
    fn bytes(&self, tag: u16) -> Result<Option<&'a [u8]>, String> {
        let Some(entry) = self.entry(tag) else { return Ok(None) };
        let length = entry.size().saturating_mul(entry.count);
        let found = entry.at.checked_add(length).and_then(|end| self.all.get(entry.at..end));
        found.map(Some).ok_or_else(|| {
            let (at, all) = (entry.at, self.all.len());
            format!(
                "the tag {tag} has {length} bytes from byte {at} on; they must lie within the {all} bytes of the file"
            )
        })
    }

    /// Returns the numbers of a tag; none if there is no such tag.
    fn numbers(&self, tag: u16) -> Result<impl Iterator<Item = f64> + use<'a>, String> {
        let bytes = self.bytes(tag)?.unwrap_or_default();
        let (entry, order) = (self.entry(tag).unwrap_or(Entry { tag, kind: 1, count: 0, at: 0 }), self.order);
        Ok(bytes.chunks_exact(entry.size()).map(move |number| entry.number(number, order)))
    }

    /// Returns the first number of a tag.
    fn number(&self, tag: u16) -> Result<Option<f64>, String> {
        self.numbers(tag).map(|mut numbers| numbers.next())
    }

    /// Returns the first number of a tag that must not be negative and must be whole, or else `default`.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number of 32 bits")]
    fn whole(&self, tag: u16, default: usize) -> Result<usize, String> {
        match self.number(tag)? {
            None => Ok(default),
            Some(found) if found.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&found) => Ok(found as usize),
            Some(found) => Err(format!("the tag {tag} is {found}; it must be a whole number")),
        }
    }

    /// Returns the text of a tag; empty if there is no such tag.
    fn text(&self, tag: u16) -> Result<String, String> {
        Ok(self.bytes(tag)?.map(text).unwrap_or_default())
    }

    /// Returns the page that a tag leads to.
    fn page(&self, tag: u16) -> Result<Option<Self>, String> {
        let Some(at) = self.number(tag)? else { return Ok(None) };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a position of 32 bits")]
        Self::read(self.all, self.order, at as u32, &mut (self.all.len() / ENTRY)).map(|(page, _)| Some(page))
    }
}

/// Reads all pages of a file.
fn pages(all: &[u8]) -> Result<Vec<Page<'_>>, String> {
    let order = order(all).ok_or("the file does not begin as TIFF")?;
    let mut bytes = Bytes::new(all, order);
    bytes.seek(4)?;
    let (mut at, mut left, mut pages) = (bytes.u32()?, all.len() / ENTRY, Vec::new());
    while at != 0 {
        if pages.len() == MOST_CHANNELS {
            return Err(format!("the file has more than {MOST_CHANNELS} pages; it must have fewer"));
        }
        let (page, next) = Page::read(all, order, at, &mut left)?;
        pages.push(page);
        at = next;
    }
    if pages.is_empty() {
        return Err("the file has no page; it must have one".into());
    }
    Ok(pages)
}
