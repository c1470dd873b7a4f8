//! Checksums of files and arrays: SHA-256, as printed by `sha256sum`.

use std::fmt::Write as _;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::Input;

/// Incremental checksum of bytes.
#[derive(Clone, Default)]
pub struct Checksum(Sha256);

impl Checksum {
    /// Computes the SHA-256 of a file.
    ///
    /// # Errors
    /// A file that cannot be read, is not regular, or changes while it is read.
    pub fn of_file(path: &Path) -> std::io::Result<String> {
        Input::settled(path)?.checksum()
    }

    /// Computes the SHA-256 of bytes.
    pub fn of_bytes(bytes: &[u8]) -> String {
        let mut sum = Self::default();
        sum.bytes(bytes);
        sum.text()
    }

    /// Computes the SHA-256 of numbers, as eight bytes each, least significant first.
    pub fn of_numbers(numbers: impl IntoIterator<Item = f64>) -> String {
        let mut sum = Self::default();
        numbers.into_iter().for_each(|number| sum.bytes(&number.to_le_bytes()));
        sum.text()
    }

    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Returns the checksum as 64 hexadecimal digits.
    pub fn text(self) -> String {
        self.0.finalize().iter().fold(String::with_capacity(64), |mut text, byte| {
            let _ = write!(text, "{byte:02x}"); // Writing to a string cannot fail.
            text
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_of_sha256sum() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "abc").unwrap();
        // FIPS 180-2, appendix B.1.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(Checksum::of_file(&path).unwrap(), abc);
        assert_eq!(Checksum::of_numbers([f64::from_le_bytes(*b"abcdefgh")]), {
            let mut sum = Checksum::default();
            sum.bytes(b"abcd");
            sum.bytes(b"efgh");
            sum.text()
        });
        assert!(Checksum::of_file(folder.path()).is_err());
    }
}
