//! Bytes of an input file, on disk or in memory.

use std::sync::OnceLock;

use crate::input::MOST_BYTES;
#[cfg(feature = "hdf5")]
use crate::stored::Hdf5;
use crate::{Checksum, Input};

/// Number of bytes used to recognise the format.
const HEAD: usize = 1 << 16;

/// File or entry of a file. A file on disk is read when its bytes are needed, at most once.
pub(crate) struct File {
    input: Option<Input>,
    head: Vec<u8>,
    whole: OnceLock<Vec<u8>>,
    /// True if numbers of 8 bits in an image are heights.
    image_heights: bool,
}

impl File {
    /// Opens a file on disk.
    ///
    /// # Errors
    /// A file that cannot be opened, or is not regular.
    pub(crate) fn open(path: &str) -> Result<Self, String> {
        let input = Input::settled(path).map_err(text)?;
        let head = input.head(HEAD as u64).map_err(text)?;
        Ok(Self { input: Some(input), head, whole: OnceLock::new(), image_heights: false })
    }

    /// Creates a file from bytes in memory.
    pub(crate) fn from_bytes(bytes: Vec<u8>) -> Self {
        let file = Self { input: None, head: Vec::new(), whole: OnceLock::new(), image_heights: false };
        file.whole.get_or_init(|| bytes);
        file
    }

    /// Takes numbers of 8 bits in an image for heights if `image_heights`.
    pub(crate) fn with_image_heights(self, image_heights: bool) -> Self {
        Self { image_heights, ..self }
    }

    /// Checks that numbers of 8 bits in an image are heights; otherwise they are taken for the brightness of a picture.
    ///
    /// # Errors
    /// Returns an error if nobody says so.
    pub(crate) fn check_image_heights(&self) -> Result<(), String> {
        if self.image_heights {
            return Ok(());
        }
        Err("the image has 8 bits a pixel, as pictures have; if they are heights, say so by --image-heights \
             (image_heights=True), or save the heights with 16 bits, or as text"
            .into())
    }

    /// Returns the first 64 KiB, or all bytes of a shorter file.
    pub(crate) fn head(&self) -> &[u8] {
        match self.whole.get() {
            Some(whole) => &whole[..whole.len().min(HEAD)],
            None => &self.head,
        }
    }

    /// Returns the number of bytes.
    pub(crate) fn length(&self) -> u64 {
        self.input.as_ref().map_or(self.head().len() as u64, Input::length)
    }

    pub(crate) fn starts_with(&self, magic: &[u8]) -> bool {
        self.head().starts_with(magic)
    }

    /// Returns all bytes.
    pub(crate) fn bytes(&self) -> Result<&[u8], String> {
        if let (None, Some(input)) = (self.whole.get(), &self.input) {
            let whole = input.bytes(MOST_BYTES).map_err(text)?;
            self.whole.get_or_init(|| whole);
        }
        Ok(self.whole.get().map_or(&self.head[..], |whole| whole))
    }

    /// Opens the file as HDF5.
    #[cfg(feature = "hdf5")]
    pub(crate) fn hdf5(&self) -> Result<Hdf5, String> {
        match &self.input {
            Some(input) => Hdf5::open(input),
            None => Hdf5::from_bytes(self.bytes()?),
        }
    }

    /// Computes the SHA-256 of the bytes that were read.
    ///
    /// # Errors
    /// A file on disk that was changed in place since it was opened.
    pub(crate) fn checksum(&self) -> Result<String, String> {
        if let (None, Some(input)) = (self.whole.get(), &self.input) {
            return input.checksum().map_err(text);
        }
        self.bytes().map(Checksum::of_bytes)
    }

    /// Returns the reason for a decoding error: a change of the file while it was read, or else `found`.
    pub(crate) fn cause(&self, found: String) -> String {
        let parts_are_read = self.whole.get().is_none();
        let changed = self.input.as_ref().filter(|_| parts_are_read).and_then(|input| input.check_unchanged().err());
        changed.map_or(found, text)
    }

    /// Returns true if the file begins like an HDF5 file without a user block.
    pub(crate) fn is_hdf5(&self) -> bool {
        self.starts_with(b"\x89HDF\r\n\x1a\n")
    }
}

fn text(error: std::io::Error) -> String {
    error.to_string()
}
