//! Files of variables: checksum of the head and the build, number of finished parts, variables, checksum of everything.
//! Of several processes the first one has the file; rows come and go in blocks, and a file suits any number of
//! processes.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _, Seek as _, Write};
use std::path::Path;

use gfmd_contact::Visit;
use gfmd_field::Share;
use gfmd_files::{Checksum, FileError, Input};

use gfmd_input::failure::Failure;
use gfmd_input::processes::{agree, of_first, replace_by_first};
use gfmd_input::rows::height;
use gfmd_input::session::GIT_COMMIT;

/// Length of a checksum.
const SUM: usize = 64;

/// Returns the checksum of the head of a run and of the build: the variables of a search differ between builds.
fn checksum(head: &[u8]) -> String {
    let mut sum = Checksum::default();
    sum.bytes(head);
    sum.bytes(GIT_COMMIT.as_bytes());
    sum.text()
}

/// Visitor that copies variables to a file, or to memory; with several processes, rows travel to the first one.
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

    fn values(&mut self, values: &[f64]) {
        for piece in values.chunks(PIECE) {
            let bytes: Vec<u8> = piece.iter().flat_map(|x| x.to_le_bytes()).collect();
            self.bytes(&bytes);
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
        self.values(x);
    }

    fn rows(&mut self, share: &Share, x: &mut [f64]) {
        if share.is_whole() {
            return self.values(x);
        }
        let columns = share.columns();
        share.to_first(x, columns, height(columns), |_, values| self.values(values));
    }

    fn single_rows(&mut self, share: &Share, x: &mut [f32]) {
        let mut wide: Vec<f64> = x.iter().map(|x| f64::from(*x)).collect();
        self.rows(share, &mut wide);
    }
}

/// Number of values that are written at a time.
const PIECE: usize = 1 << 12;

/// File of variables, as a visitor that restores them; with several processes, from the file of the first one.
pub struct Stored {
    /// File at the process that reads.
    opened: Option<Opened>,
    share: Share,
    parts: usize,
}

impl Stored {
    /// Opens the file of the run that `head` identifies; `None` if there is none. Only the first process has a `path`.
    ///
    /// # Errors
    /// Returns an error, at all processes, for a file that is damaged or belongs to another run.
    pub(super) fn read(path: Option<&Path>, head: &[u8], share: &Share) -> Result<Option<Self>, Failure> {
        let opened = path.map_or(Ok(None), |path| Opened::of(path, head));
        let opened = if share.is_whole() { opened } else { agree(share.ranks(), opened) }?;
        let own = [u64::from(opened.is_some()), opened.as_ref().map_or(0, |opened| opened.parts)];
        let [exists, parts] = of_first(share.ranks(), own);
        Ok((exists == 1).then(|| Self { opened, share: share.clone(), parts: parts as usize }))
    }

    /// Returns the number of parts that were finished when the file was written.
    pub(super) fn parts(&self) -> usize {
        self.parts
    }

    /// Returns the number of bytes that are not read; negative if more were read than exist.
    fn left(&self) -> i64 {
        let [left] = of_first(self.share.ranks(), [self.opened.as_ref().map_or(0, |opened| opened.left) as u64]);
        left as i64
    }

    /// Returns true if all variables are read.
    pub(crate) fn is_at_end(&self) -> bool {
        self.left() <= 0
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
        if self.left() == 0 {
            return Ok(made);
        }
        Err(Failure::refused("the stored state has other variables than this run; delete it"))
    }

    fn word(&mut self, own: u64) -> u64 {
        let mut word = own;
        if let Some(opened) = &mut self.opened {
            opened.read(&mut word);
        }
        let [word] = of_first(self.share.ranks(), [word]);
        word
    }
}

impl Visit for Stored {
    fn number(&mut self, x: &mut f64) {
        *x = f64::from_bits(self.word(x.to_bits()));
    }

    fn count(&mut self, n: &mut u64) {
        *n = self.word(*n);
    }

    fn field(&mut self, x: &mut [f64]) {
        if let Some(opened) = &mut self.opened {
            opened.read_values(x);
        }
        if !self.share.is_whole() {
            let mut words: Vec<u64> = x.iter().map(|x| x.to_bits()).collect();
            replace_by_first(self.share.ranks(), &mut words);
            x.iter_mut().zip(words).for_each(|(x, word)| *x = f64::from_bits(word));
        }
    }

    fn rows(&mut self, share: &Share, x: &mut [f64]) {
        if share.is_whole() {
            return self.field(x);
        }
        let columns = share.columns();
        share.from_first(x, columns, height(columns), |_, values| {
            if let Some(opened) = &mut self.opened {
                opened.read_values(values);
            }
        });
    }

    fn single_rows(&mut self, share: &Share, x: &mut [f32]) {
        let mut wide: Vec<f64> = x.iter().map(|x| f64::from(*x)).collect();
        self.rows(share, &mut wide);
        x.iter_mut().zip(wide).for_each(|(x, wide)| *x = wide as f32);
    }
}

/// Open file of variables. Its checksum is compared before the first variable is read.
struct Opened {
    stream: BufReader<io::Take<File>>,
    /// Number of bytes that are not read; negative if more were read than exist.
    left: i64,
    parts: u64,
}

impl Opened {
    /// Opens a file of the run that `head` identifies; `None` if there is none.
    fn of(path: &Path, head: &[u8]) -> Result<Option<Self>, Failure> {
        let unread = |source| Failure::from(FileError::Io { action: "read", path: path.into(), source });
        let input = match Input::open(path) {
            Ok(input) => input,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(unread(error)),
        };
        let refuse = |reason: &str| Failure::input(path.display().to_string(), reason);
        let [begin, end] = [SUM as u64 + 8, SUM as u64];
        let Some(length) = input.length().checked_sub(end).filter(|length| *length >= begin) else {
            return Err(refuse("the file is damaged"));
        };
        let mut file = input.handle().map_err(unread)?;
        let mut sum = Checksum::default();
        let mut content = BufReader::with_capacity(8 * PIECE, (&mut file).take(length));
        loop {
            let read = content.fill_buf().map_err(unread)?;
            let count = read.len();
            if count == 0 {
                break;
            }
            sum.bytes(read);
            content.consume(count);
        }
        let mut stated = [0; SUM];
        file.read_exact(&mut stated).map_err(unread)?;
        if sum.text().as_bytes() != stated {
            return Err(refuse("the file is damaged"));
        }
        file.rewind().map_err(unread)?;
        let mut stream = BufReader::with_capacity(8 * PIECE, file.take(length));
        let (mut found, mut parts) = ([0; SUM], [0; 8]);
        stream.read_exact(&mut found).map_err(unread)?;
        stream.read_exact(&mut parts).map_err(unread)?;
        if found != *checksum(head).as_bytes() {
            return Err(refuse("the file belongs to a run of another configuration, input or build of gfmd"));
        }
        Ok(Some(Self { stream, left: (length - begin) as i64, parts: u64::from_le_bytes(parts) }))
    }

    /// Replaces a word with the next one, if there is one.
    fn read(&mut self, word: &mut u64) {
        let mut bytes = [0; 8];
        self.left -= 8;
        if self.left >= 0 && self.stream.read_exact(&mut bytes).is_ok() {
            *word = u64::from_le_bytes(bytes);
        }
    }

    fn read_values(&mut self, values: &mut [f64]) {
        for value in values {
            let mut word = value.to_bits();
            self.read(&mut word);
            *value = f64::from_bits(word);
        }
    }
}
