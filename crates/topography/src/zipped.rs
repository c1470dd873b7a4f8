//! Zip archives: the entries of x3p, plux, npz and containers.

use std::io::{Cursor, Read};

use roxmltree::Document;
use zip::ZipArchive;

use super::file::File;

/// Largest size of an entry that describes others, in bytes.
pub(crate) const MOST_TEXT: u64 = 1 << 20;

/// Largest compression ratio of a data file.
const MOST_RATIO: u64 = 64;

/// Largest number of XML tags and attributes. Each takes more memory than its text.
const MOST_NODES: usize = 20_000;

/// Parses the XML of an entry.
pub(crate) fn xml<'a>(name: &str, text: &'a str) -> Result<Document<'a>, String> {
    if text.bytes().filter(|byte| matches!(byte, b'<' | b'=')).count() > MOST_NODES {
        return Err(format!("the entry {name} has more than {MOST_NODES} tags and attributes; it must have fewer"));
    }
    Document::parse(text).map_err(|error| format!("the entry {name}: {error}"))
}

/// Returns the parts of a path in lower case, without empty parts and `.`, joined by slashes.
pub(crate) fn plain(path: &str) -> String {
    let parts: Vec<&str> = path.split(['/', '\\']).filter(|part| !matches!(*part, "" | ".")).collect();
    parts.join("/").to_lowercase()
}

/// Zip archive in memory, and its number of bytes.
pub(crate) struct Zip<'a>(ZipArchive<Cursor<&'a [u8]>>, usize);

impl<'a> Zip<'a> {
    pub(crate) fn open(file: &'a File) -> Result<Self, String> {
        Self::of(file.bytes()?)
    }

    /// Opens the archive at the end of `bytes`.
    pub(crate) fn of(bytes: &'a [u8]) -> Result<Self, String> {
        let archive = ZipArchive::new(Cursor::new(bytes));
        archive
            .map(|archive| Self(archive, bytes.len()))
            .map_err(|error| format!("the zip archive is damaged: {error}"))
    }

    /// Returns true if the file is a zip archive with all these entries.
    pub(crate) fn has(file: &File, entries: &[&str]) -> bool {
        file.starts_with(b"PK")
            && Zip::open(file).is_ok_and(|zip| entries.iter().all(|entry| zip.meant(entry).is_some()))
    }

    /// Finds the entry with this name, or else a name that differs only in case, slashes or `./`.
    pub(crate) fn meant(&self, name: &str) -> Option<String> {
        let wanted = plain(name);
        let exact = self.0.index_for_name(name).map(|_| name.to_owned());
        exact.or_else(|| self.names().into_iter().find(|entry| plain(entry) == wanted))
    }

    /// Returns the names of the entries in the order of the archive.
    pub(crate) fn names(&self) -> Vec<String> {
        self.0.file_names().filter_map(Result::ok).map(|name| name.into_owned()).collect()
    }

    /// Returns the bytes of an entry as a stream, and their compressed number. The number is limited to the size of the
    /// archive, whatever the entry declares. The checksum is verified at the end.
    pub(crate) fn stream(&mut self, name: &str) -> Result<(impl Read, usize), String> {
        let size = self.1;
        let found = self.meant(name).unwrap_or_else(|| name.to_owned());
        let entry = self.0.by_name(&found).map_err(|error| format!("the entry {name}: {error}"))?;
        let compressed = entry.compressed_size();
        Ok((entry, usize::try_from(compressed).unwrap_or(usize::MAX).min(size)))
    }

    /// Decompresses an entry of at most `most` bytes, whatever size the archive declares, and verifies its checksum.
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

    /// Decompresses a text entry.
    pub(crate) fn text(&mut self, name: &str) -> Result<String, String> {
        String::from_utf8(self.read(name, MOST_TEXT)?).map_err(|_| format!("the entry {name} is not text in UTF-8"))
    }
}
