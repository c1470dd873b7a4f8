//! The bytes of a file to read, on disk or in memory.

use std::fs;
use std::io::Read;
use std::path::PathBuf;
use std::sync::OnceLock;

use crate::stored::Hdf5;

/// The number of bytes that tell the format.
const HEAD: u64 = 1 << 16;

/// A file or an entry of one. A file on disk is read when its bytes are needed, at most once.
pub(super) struct File {
    path: Option<PathBuf>,
    head: Vec<u8>,
    whole: OnceLock<Vec<u8>>,
}

impl File {
    /// Opens a file on disk. A pipe is read to its end.
    ///
    /// # Errors
    /// A file that cannot be opened, is a folder or a device.
    pub(super) fn open(path: &str) -> Result<Self, String> {
        let text = |error: std::io::Error| error.to_string();
        let mut file = fs::File::open(path).map_err(text)?;
        let kind = file.metadata().map_err(text)?.file_type();
        if kind.is_dir() || is_device(kind) {
            let found = if kind.is_dir() { "a folder" } else { "a device" };
            return Err(format!("the name is that of {found}; it must be that of a file"));
        }
        let mut head = Vec::new();
        if !kind.is_file() {
            file.read_to_end(&mut head).map_err(text)?;
            return Ok(Self::from_bytes(head));
        }
        file.take(HEAD).read_to_end(&mut head).map_err(text)?;
        Ok(Self { path: Some(path.into()), head, whole: OnceLock::new() })
    }

    /// A file whose bytes are in memory.
    pub(super) fn from_bytes(bytes: Vec<u8>) -> Self {
        let file = Self { path: None, head: Vec::new(), whole: OnceLock::new() };
        file.whole.get_or_init(|| bytes);
        file
    }

    /// The first 64 KiB, or all bytes of a shorter file.
    pub(super) fn head(&self) -> &[u8] {
        match self.whole.get() {
            Some(whole) => &whole[..whole.len().min(HEAD as usize)],
            None => &self.head,
        }
    }

    pub(super) fn starts_with(&self, magic: &[u8]) -> bool {
        self.head().starts_with(magic)
    }

    /// All bytes.
    pub(super) fn bytes(&self) -> Result<&[u8], String> {
        if let (None, Some(path)) = (self.whole.get(), &self.path) {
            let whole = fs::read(path).map_err(|error| error.to_string())?;
            self.whole.get_or_init(|| whole);
        }
        Ok(self.whole.get().map_or(&self.head[..], |whole| whole))
    }

    /// Opens the file as HDF5.
    pub(super) fn hdf5(&self) -> Result<Hdf5, String> {
        match &self.path {
            Some(path) => Hdf5::open(path),
            None => Hdf5::from_bytes(self.bytes()?),
        }
    }

    /// True if the file begins like one of HDF5, without a user block.
    pub(super) fn is_hdf5(&self) -> bool {
        self.starts_with(b"\x89HDF\r\n\x1a\n")
    }
}

#[cfg(unix)]
fn is_device(kind: fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_char_device() || kind.is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: fs::FileType) -> bool {
    false
}
