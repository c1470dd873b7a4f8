//! Input files: regular files only, opened without waiting, with detection of changes while they are read.
//!
//! Every file named by a flag, a caller or another file is opened here. A pipe, a terminal or a device is refused,
//! since reading it may never end. It is not opened, since opening may block or change its state.
//!
//! A file that is replaced by a rename is read completely, as the old or the new one. A file that is rewritten in place
//! is detected by its length and modification time, and refused.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::time::{Duration, SystemTime};

use crate::Checksum;

/// Largest size of a file that describes a run (a configuration), in bytes.
pub const MOST_TEXT: u64 = 1 << 20;

/// Largest size of a file read into memory, in bytes: four times the heights of the largest map, for maps in text.
pub const MOST_BYTES: u64 = 1 << 35;

/// Largest size of a file for a checksum, in bytes: some system files declare more and are endless.
const MOST_HASHED: u64 = 1 << 40;

/// Interval in which two changes of a file may have the same modification time: one and a half ticks of the slowest
/// usual clock.
const TICK: Duration = Duration::from_millis(15);

/// Maximum number of ticks to wait for a file that is being written.
const TICKS: usize = 4;

/// Number of bytes read at a time for a checksum.
const PIECE: usize = 1 << 16;

/// Open regular file. Errors come from the operating system, or state the value found and the allowed values.
#[derive(Debug)]
pub struct Input {
    file: File,
    length: u64,
    modified: Option<SystemTime>,
}

impl Input {
    /// Opens the file at `path`, or the target of a symbolic link.
    ///
    /// # Errors
    /// A file that cannot be opened; a folder, pipe, socket or device, which is not opened.
    pub fn open(path: impl AsRef<Path>) -> io::Result<Self> {
        let path = path.as_ref();
        check_regular(&fs::metadata(path)?)?;
        let file = open(path)?;
        // The path may lead to another file by now.
        let metadata = file.metadata()?;
        check_regular(&metadata)?;
        Ok(Self { file, length: metadata.len(), modified: metadata.modified().ok() })
    }

    /// Opens a file like [`open`](Self::open). If it was written a moment ago, waits at most a few hundredths of a
    /// second, so that every later change is detected by its modification time.
    ///
    /// # Errors
    /// The errors of `open`.
    pub fn settled(path: impl AsRef<Path>) -> io::Result<Self> {
        let mut input = Self::open(path)?;
        for _ in 0..TICKS {
            let age = input.modified.and_then(|modified| modified.elapsed().ok());
            let Some(rest) = age.and_then(|age| TICK.checked_sub(age)) else { break };
            std::thread::sleep(rest);
            let metadata = input.file.metadata()?;
            (input.length, input.modified) = (metadata.len(), metadata.modified().ok());
        }
        Ok(input)
    }

    /// Returns the number of bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Reads the first `most` bytes, or all of a shorter file.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn head(&self, most: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.stream().take(most).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// Reads all bytes.
    ///
    /// # Errors
    /// A file of more than `most` bytes, before it is read; a file that cannot be read, or changes meanwhile.
    pub fn bytes(&self, most: u64) -> io::Result<Vec<u8>> {
        self.check_length(most)?;
        let length = self.length;
        let mut bytes = Vec::new();
        let capacity = usize::try_from(length).map_err(|_| io::ErrorKind::OutOfMemory)?;
        bytes.try_reserve_exact(capacity).map_err(|_| io::ErrorKind::OutOfMemory)?;
        self.stream().take(length).read_to_end(&mut bytes)?;
        if bytes.len() < capacity {
            return Err(changed());
        }
        self.check_unchanged().map(|()| bytes)
    }

    /// Computes the SHA-256 of all bytes, as printed by `sha256sum`. Little memory is used.
    ///
    /// # Errors
    /// A file of more than a tebibyte; a file that cannot be read, or changes meanwhile.
    pub fn checksum(&self) -> io::Result<String> {
        self.check_length(MOST_HASHED)?;
        let (mut file, mut sum, mut piece) = (self.stream().take(self.length), Checksum::default(), vec![0; PIECE]);
        loop {
            match file.read(&mut piece)? {
                0 => return self.check_unchanged().map(|()| sum.text()),
                length => sum.bytes(&piece[..length]),
            }
        }
    }

    /// Checks that the file still has the length and modification time that it had when it was opened.
    ///
    /// # Errors
    /// A file that was changed in place.
    pub fn check_unchanged(&self) -> io::Result<()> {
        let metadata = self.file.metadata()?;
        let same = metadata.len() == self.length && metadata.modified().ok() == self.modified;
        if same { Ok(()) } else { Err(changed()) }
    }

    fn check_length(&self, most: u64) -> io::Result<()> {
        let length = self.length;
        if length <= most {
            return Ok(());
        }
        let text = format!("it has {length} bytes; it must have at most {most}");
        Err(io::Error::new(io::ErrorKind::InvalidInput, text))
    }

    /// Returns the same open file, for a reader of parts of it.
    pub fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Returns a stream of the bytes from the beginning, independent of other readers of the file.
    fn stream(&self) -> Stream<'_> {
        Stream { file: &self.file, next: 0 }
    }
}

/// Bytes of a file, read at its own position.
struct Stream<'a> {
    file: &'a File,
    next: u64,
}

impl Read for Stream<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        #[cfg(unix)]
        let count = std::os::unix::fs::FileExt::read_at(self.file, buffer, self.next)?;
        #[cfg(windows)]
        let count = std::os::windows::fs::FileExt::seek_read(self.file, buffer, self.next)?;
        self.next += count as u64;
        Ok(count)
    }
}

/// Reads all bytes of the file at `path`, at most `most`.
///
/// # Errors
/// The errors of [`Input::open`] and [`Input::bytes`].
pub fn bytes(path: impl AsRef<Path>, most: u64) -> io::Result<Vec<u8>> {
    Input::open(path)?.bytes(most)
}

/// Reads the text in the file at `path`, at most [`MOST_TEXT`] bytes.
///
/// # Errors
/// The errors of [`bytes`]; a file that is not UTF-8 text.
pub fn text(path: impl AsRef<Path>) -> io::Result<String> {
    let words = |_| io::Error::new(io::ErrorKind::InvalidData, "it is not text in UTF-8; it must be");
    String::from_utf8(bytes(path, MOST_TEXT)?).map_err(words)
}

fn check_regular(metadata: &fs::Metadata) -> io::Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    let text = format!("it is {}; it must be a regular file", kind(metadata));
    Err(io::Error::new(io::ErrorKind::InvalidInput, text))
}

fn changed() -> io::Error {
    io::Error::other("it changed while it was read; it must stay the same, or be replaced by renaming")
}

/// Opens a file without waiting; opening a pipe would wait for a writer.
#[cfg(unix)]
fn open(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    File::options().read(true).custom_flags(nix::libc::O_NONBLOCK | nix::libc::O_NOCTTY).open(path)
}

#[cfg(not(unix))]
fn open(path: &Path) -> io::Result<File> {
    File::open(path)
}

/// Returns the kind of an object that is not a regular file, in words.
#[doc(hidden)]
pub fn kind(metadata: &std::fs::Metadata) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = metadata.file_type();
        if kind.is_fifo() {
            return "a pipe";
        } else if kind.is_socket() {
            return "a socket";
        } else if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    if metadata.is_dir() { "a folder" } else { "a special file" }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_file_is_read_within_its_limit_and_hashed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "abc").unwrap();
        let input = Input::settled(&path).unwrap();
        assert_eq!((input.length(), input.head(2).unwrap(), input.bytes(3).unwrap()), (3, b"ab".into(), b"abc".into()));
        assert_eq!(input.bytes(2).unwrap_err().to_string(), "it has 3 bytes; it must have at most 2");
        // FIPS 180-2, appendix B.1.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(input.checksum().unwrap(), abc);
        fs::write(&path, [0xff]).unwrap();
        assert_eq!(text(&path).unwrap_err().to_string(), "it is not text in UTF-8; it must be");
        // A configuration of 1.5 GiB, without any byte on the disk or read.
        File::create(&path).unwrap().set_len(3 << 29).unwrap();
        assert!(text(&path).unwrap_err().to_string().ends_with("it must have at most 1048576"));
        assert_eq!(Input::open(folder.path().join("none")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn a_file_that_changes_is_refused_and_one_that_is_replaced_is_read_whole() {
        let folder = tempfile::tempdir().unwrap();
        let [path, new] = ["file", "new"].map(|name| folder.path().join(name));
        let changes: [fn(&mut File) -> io::Result<()>; 3] =
            [|file| file.write_all(b"xyz"), |file| file.set_len(1), |file| file.set_len(4)];
        for change in changes {
            fs::write(&path, "abc").unwrap();
            let input = Input::settled(&path).unwrap();
            // The write falls into the same tick as the opening at the latest.
            change(&mut File::options().write(true).open(&path).unwrap()).unwrap();
            for refused in [input.bytes(9).map(drop), input.checksum().map(drop), input.check_unchanged()] {
                let text = refused.unwrap_err().to_string();
                assert!(text.starts_with("it changed while it was read"), "{text}");
            }
        }
        fs::write(&path, "abc").unwrap();
        fs::write(&new, "xyz!").unwrap();
        let input = Input::settled(&path).unwrap();
        fs::rename(&new, &path).unwrap();
        assert_eq!(input.bytes(9).unwrap(), b"abc");
        assert_eq!(Input::open(&path).unwrap().bytes(9).unwrap(), b"xyz!");
    }

    /// The test ends: a pipe without a writer and an endless device are not opened.
    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file_is_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let [pipe, link] = ["pipe", "link"].map(|name| folder.path().join(name));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        for (path, found) in
            [(&*pipe, "a pipe"), (&*link, "a pipe"), (Path::new("/dev/zero"), "a device"), (folder.path(), "a folder")]
        {
            let text = format!("it is {found}; it must be a regular file");
            assert_eq!(Input::open(path).unwrap_err().to_string(), text);
            assert_eq!(bytes(path, 9).unwrap_err().to_string(), text);
        }
        // An open without a check returns as well: another process may replace a file by a pipe.
        assert!(check_regular(&open(&pipe).unwrap().metadata().unwrap()).is_err());
    }
}
