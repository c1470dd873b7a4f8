//! Files of variables: checksum of the head, number of finished parts, variables, checksum of everything.

use std::io::{self, Write};
use std::path::Path;

use gfmd_contact::Visit;
use gfmd_files::{Checksum, FileError, input};

use gfmd_input::failure::Failure;

/// Length of a checksum.
const SUM: usize = 64;

fn checksum(bytes: &[u8]) -> String {
    let mut sum = Checksum::default();
    sum.bytes(bytes);
    sum.text()
}

/// Visitor that copies variables to a file, or to memory.
pub(super) struct Writer<W> {
    sink: W,
    sum: Checksum,
    failed: io::Result<()>,
}

impl<W: Write> Writer<W> {
    pub(super) fn new(sink: W, head: &[u8], parts: usize) -> Self {
        let mut writer = Self { sink, sum: Checksum::default(), failed: Ok(()) };
        writer.bytes(checksum(head).as_bytes());
        writer.count(&mut (parts as u64));
        writer
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.sum.bytes(bytes);
        if self.failed.is_ok() {
            self.failed = self.sink.write_all(bytes);
        }
    }

    /// Writes the checksum. Returns the error of the first failed write, if there is one.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.failed?;
        self.sink.write_all(self.sum.text().as_bytes())?;
        Ok(self.sink)
    }
}

impl<W: Write> Visit for Writer<W> {
    fn number(&mut self, x: &mut f64) {
        self.bytes(&x.to_le_bytes());
    }

    fn count(&mut self, n: &mut u64) {
        self.bytes(&n.to_le_bytes());
    }

    fn field(&mut self, x: &mut [f64]) {
        for piece in x.chunks(PIECE) {
            let bytes: Vec<u8> = piece.iter().flat_map(|x| x.to_le_bytes()).collect();
            self.bytes(&bytes);
        }
    }
}

/// Number of values that are written at a time.
const PIECE: usize = 1 << 12;

/// File of variables, as a visitor that restores them.
pub struct Stored {
    bytes: Vec<u8>,
    /// Position of the next variable; beyond the end if more were read than exist.
    next: usize,
    parts: usize,
}

impl Stored {
    /// Reads a file of the run that `head` identifies; `None` if there is none.
    pub(super) fn read(path: &Path, head: &[u8]) -> Result<Option<Self>, Failure> {
        let mut bytes = match input::bytes(path, u64::MAX) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(FileError::Io { action: "read", path: path.into(), source }.into()),
        };
        let refuse = |reason: &str| Failure::input(path.display().to_string(), reason);
        let intact =
            bytes.len().checked_sub(SUM).filter(|length| checksum(&bytes[..*length]).as_bytes() == &bytes[*length..]);
        let Some(length) = intact.filter(|length| *length >= SUM + 8) else {
            return Err(refuse("the file is damaged"));
        };
        bytes.truncate(length);
        if bytes[..SUM] != *checksum(head).as_bytes() {
            return Err(refuse("the file belongs to a run of another configuration, input or version"));
        }
        let mut stored = Self { bytes, next: SUM, parts: 0 };
        let mut parts = 0;
        stored.count(&mut parts);
        stored.parts = parts as usize;
        Ok(Some(stored))
    }

    /// Returns the number of parts that were finished when the file was written.
    pub(super) fn parts(&self) -> usize {
        self.parts
    }

    /// Returns true if all variables are read.
    pub(crate) fn is_at_end(&self) -> bool {
        self.next >= self.bytes.len()
    }

    /// Restores a value from all variables.
    ///
    /// # Errors
    /// Returns an error if the value cannot be made, or if the file has other variables than the value.
    pub fn restore<T, R: Into<Failure>>(
        &mut self,
        make: impl FnOnce(&mut dyn Visit) -> Result<T, R>,
    ) -> Result<T, Failure> {
        let made = make(self).map_err(Into::into)?;
        if self.next == self.bytes.len() {
            return Ok(made);
        }
        Err(Failure::refused("the stored state has other variables than this run; delete it"))
    }

    fn word(&mut self, word: [u8; 8]) -> [u8; 8] {
        let read = self.bytes.get(self.next..).and_then(|rest| rest.first_chunk::<8>()).copied();
        self.next += 8;
        read.unwrap_or(word)
    }
}

impl Visit for Stored {
    fn number(&mut self, x: &mut f64) {
        *x = f64::from_le_bytes(self.word(x.to_le_bytes()));
    }

    fn count(&mut self, n: &mut u64) {
        *n = u64::from_le_bytes(self.word(n.to_le_bytes()));
    }

    fn field(&mut self, x: &mut [f64]) {
        x.iter_mut().for_each(|x| self.number(x));
    }
}
