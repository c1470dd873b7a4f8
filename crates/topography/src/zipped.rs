//! Zip archives: the entries of x3p, plux, npz and containers.

use std::io::{Cursor, Read};

use roxmltree::Document;
use zip::ZipArchive;

use super::file::File;

/// The largest size of an entry that describes others, in bytes.
pub(crate) const MOST_TEXT: u64 = 1 << 20;

/// The largest ratio of compression of a data file.
const MOST_RATIO: u64 = 64;

/// The largest number of tags and attributes of XML. Each takes more memory than its text.
const MOST_NODES: usize = 20_000;

/// Parses the XML of an entry.
pub(crate) fn xml<'a>(name: &str, text: &'a str) -> Result<Document<'a>, String> {
    if text.bytes().filter(|byte| matches!(byte, b'<' | b'=')).count() > MOST_NODES {
        return Err(format!("the entry {name} has more than {MOST_NODES} tags and attributes; it must have fewer"));
    }
    Document::parse(text).map_err(|error| format!("the entry {name}: {error}"))
}

/// The parts of a path in small letters, without empty ones and `.`, joined by slashes.
pub(crate) fn plain(path: &str) -> String {
    let parts: Vec<&str> = path.split(['/', '\\']).filter(|part| !matches!(*part, "" | ".")).collect();
    parts.join("/").to_lowercase()
}

/// A zip archive in memory, and its number of bytes.
pub(crate) struct Zip<'a>(ZipArchive<Cursor<&'a [u8]>>, usize);

impl<'a> Zip<'a> {
    pub(crate) fn open(file: &'a File) -> Result<Self, String> {
        let bytes = file.bytes()?;
        let archive = ZipArchive::new(Cursor::new(bytes));
        archive
            .map(|archive| Self(archive, bytes.len()))
            .map_err(|error| format!("the zip archive is damaged: {error}"))
    }

    /// True if the file is a zip archive with all these entries.
    pub(crate) fn has(file: &File, entries: &[&str]) -> bool {
        file.starts_with(b"PK")
            && Zip::open(file).is_ok_and(|zip| entries.iter().all(|entry| zip.meant(entry).is_some()))
    }

    /// The name of the entry that `name` means: the same name, else one that differs in case, slashes or `./` only.
    pub(crate) fn meant(&self, name: &str) -> Option<String> {
        let wanted = plain(name);
        let exact = self.0.index_for_name(name).map(|_| name.to_owned());
        exact.or_else(|| self.names().into_iter().find(|entry| plain(entry) == wanted))
    }

    /// The names of the entries in the order of the archive.
    pub(crate) fn names(&self) -> Vec<String> {
        self.0.file_names().filter_map(Result::ok).map(|name| name.into_owned()).collect()
    }

    /// The bytes of an entry as a stream, and their compressed number, at most that of the archive, whatever the entry
    /// declares; the checksum is verified at the end.
    pub(crate) fn stream(&mut self, name: &str) -> Result<(impl Read, usize), String> {
        let size = self.1;
        let found = self.meant(name).unwrap_or_else(|| name.to_owned());
        let entry = self.0.by_name(&found).map_err(|error| format!("the entry {name}: {error}"))?;
        let compressed = entry.compressed_size();
        Ok((entry, usize::try_from(compressed).unwrap_or(usize::MAX).min(size)))
    }

    /// Decompresses an entry of at most `most` bytes, whatever size the archive declares; its checksum is verified.
    pub(crate) fn read(&mut self, name: &str, most: u64) -> Result<Vec<u8>, String> {
        let found = self.meant(name).unwrap_or_else(|| name.to_owned());
        let entry = self.0.by_name(&found).map_err(|error| format!("the entry {name}: {error}"))?;
        let mut bytes = Vec::new();
        entry
            .take(most.saturating_add(1))
            .read_to_end(&mut bytes)
            .map_err(|error| format!("the entry {name}: {error}"))?;
        if bytes.len() as u64 > most {
            return Err(format!("the entry {name} has more than {most} bytes; it must have at most so many"));
        }
        Ok(bytes)
    }

    /// Decompresses a whole file, which may have up to 64 times its compressed size.
    pub(crate) fn whole(&mut self, name: &str) -> Result<Vec<u8>, String> {
        let compressed = self.stream(name)?.1 as u64;
        self.read(name, compressed.saturating_mul(MOST_RATIO).max(MOST_TEXT))
    }

    /// Decompresses an entry of text.
    pub(crate) fn text(&mut self, name: &str) -> Result<String, String> {
        String::from_utf8(self.read(name, MOST_TEXT)?).map_err(|_| format!("the entry {name} is not text in UTF-8"))
    }
}
