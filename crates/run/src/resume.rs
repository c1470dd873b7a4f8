//! Finished parts of a command that solves its parts in turn, each from the previous state. They are kept beside the
//! output, so that `--resume` continues a killed run, and ends with the numbers of an uninterrupted one.
//!
//! | file beside `OUT`   | contents                                                                    |
//! |---------------------|-----------------------------------------------------------------------------|
//! | `OUT.journal`       | the record of every finished part, appended                                 |
//! | `OUT.state`         | the state of the last finished part, the start of the next one              |
//! | `OUT.checkpoint`    | the variables of the running solve                                          |
//!
//! Writing takes at most a twentieth of the time; a part that ends too soon after the last write waits in memory. With
//! several processes, all call the same functions and the first one writes, each part at once, from rows that travel in
//! blocks. The files do not depend on the number of processes, so that another number can continue a run.

mod snapshot;

use std::borrow::Cow;
use std::io::{self, Write as _};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use gfmd_contact::Visit;
use gfmd_field::Share;
use gfmd_files::{Journal, JournalError, Output, Reader};
use gfmd_problem::{Unusable, Words, key, words};

use gfmd_input::failure::Failure;
use gfmd_input::processes::{agree, of_first, texts};
use gfmd_input::rows::height;
use gfmd_problem::options::Options;
use snapshot::{Stored, Writer};

/// The flag of a command that can be continued.
#[derive(Args, Options, Clone, Copy, Debug)]
#[command(next_help_heading = "Long runs")]
pub struct ResumeArgs {
    /// Continue an interrupted or killed run from the files beside --out
    #[arg(long, requires = "out")]
    pub resume: bool,
}

/// The flag of a command that copies a running solve.
#[derive(Args, Options, Clone, Copy, Debug)]
#[command(next_help_heading = "Long runs")]
pub struct CheckpointArgs {
    /// Checkpoint interval of the running solve, s; 0 for none. Checkpoints are kept beside --out
    #[arg(long, default_value_t = EVERY.as_secs_f64(), value_name = "SECONDS", allow_negative_numbers = true)]
    checkpoint: f64,
}

impl CheckpointArgs {
    /// Returns the time between two copies, if any are made.
    ///
    /// # Errors
    /// Returns an error for a time that is negative or longer than a century.
    pub fn every(&self) -> Result<Option<Duration>, Failure> {
        match self.checkpoint {
            0.0 => Ok(None),
            seconds if seconds > 0.0 && seconds <= CENTURY => Ok(Some(Duration::from_secs_f64(seconds))),
            found => Err(Failure::value(key("checkpoint"), found, format!("between 0 and {CENTURY:.0e}"))),
        }
    }
}

/// Usual time between two copies of a running solve.
pub const EVERY: Duration = Duration::from_secs(60);

/// Length of a century in seconds.
const CENTURY: f64 = 3e9;

/// Time between two writes divided by the time of a write.
const WRITE_INTERVAL_FACTOR: u32 = 20;

/// Expected time of the first write.
const FIRST_COST: Duration = Duration::from_millis(5);

/// Files beside the output: finished parts, the state of the last one, the running solve.
const SUFFIXES: [&str; 3] = [".journal", ".state", ".checkpoint"];

/// Number of bytes that may wait in memory.
const MOST_WAITING: usize = 1 << 26;

/// Finished part: its scalars as text, and its fields for the output.
pub struct FinishedStep<'a> {
    /// Scalars.
    pub text: String,
    /// Fields, in the order of the output; rows of this process.
    pub fields: Vec<Cow<'a, [f64]>>,
}

/// Rows of this process of a field with a partition of its own.
pub struct OwnRows {
    /// Partition of the rows.
    pub share: Share,
    /// Values, row by row.
    pub values: Vec<f64>,
}

impl OwnRows {
    /// Passes the whole field to `take` at the first process, in pieces of whole rows with the place of their first
    /// value.
    pub fn to_first(&self, mut take: impl FnMut(usize, &[f64])) {
        let Self { share, values } = self;
        let columns = share.columns();
        share.to_first(values, columns, height(columns), |rows, values| take(rows.start * columns, values));
    }
}

/// Checks that a run that continues none, although `--resume` is given, does not replace the finished result of another
/// configuration.
///
/// # Errors
/// Returns an error if the output has a configuration that is not this one.
pub fn check_finished(output: &Output, is_this: impl FnOnce(&str) -> bool) -> Result<(), Failure> {
    let config = Reader::open(output.path()).and_then(|reader| reader.text("/", "config"));
    if config.is_ok_and(|config| !is_this(&config)) {
        let result = "this is the finished result of another configuration; leave out ";
        let why = words![result, key("resume"), " to replace it, or name another file"];
        return Err(Failure::because(output.path().display().to_string(), why));
    }
    Ok(())
}

/// Files beside an output that is being computed.
pub struct UnfinishedRun<'a> {
    /// Output at the process that writes.
    output: Option<&'a Output>,
    share: Share,
    /// Text that identifies the run.
    head: Vec<u8>,
    journal: Option<Journal>,
    /// Record of the journal with which each part begins that was finished when the run began, and the next record.
    starts: Vec<usize>,
    /// Number of parts that were finished when the run began.
    finished: usize,
    state: Option<Stored>,
    running: Option<Stored>,
    /// Records that wait to be written, their bytes, and the state after the last one.
    waiting: Vec<Vec<u8>>,
    waiting_bytes: usize,
    latest: Vec<u8>,
    /// Number of parts, including waiting ones.
    done: usize,
    /// Number of parts from which a run can continue.
    kept: usize,
    /// True once a file was written, or if one existed.
    on_disk: bool,
    written: Instant,
    cost: Duration,
    every: Option<Duration>,
}

impl<'a> UnfinishedRun<'a> {
    /// Opens what is kept of the run that `head` identifies, with at most `parts` parts, whose fields `share` divides.
    /// Only the process that writes has an `output`.
    ///
    /// # Errors
    /// Returns an error, at all processes, for an unfinished run without `--resume`, for files of another run, and for
    /// damaged files.
    pub fn open(
        (output, share): (Option<&'a Output>, &Share),
        head: String,
        parts: usize,
        ResumeArgs { resume }: ResumeArgs,
        every: Option<Duration>,
    ) -> Result<Self, Failure> {
        let mut kept = Self {
            output,
            share: share.clone(),
            head: head.into_bytes(),
            journal: None,
            starts: vec![0],
            finished: 0,
            state: None,
            running: None,
            waiting: Vec::new(),
            waiting_bytes: 0,
            latest: Vec::new(),
            done: 0,
            kept: 0,
            on_disk: false,
            written: Instant::now(),
            cost: FIRST_COST,
            every,
        };
        let exists = kept.agree(kept.exists(resume))?;
        if of_first(share.ranks(), [u64::from(exists)]) == [1] {
            kept.recall(parts)?;
        }
        Ok(kept)
    }

    /// Returns true if files of an unfinished run exist.
    fn exists(&self, resume: bool) -> Result<bool, Failure> {
        let Some(output) = self.output else { return Ok(false) };
        output.check_beside(&[".checkpoint.part", ".journal"]).map_err(|error| Failure::input(key("out"), error))?;
        let found = SUFFIXES.map(|suffix| output.beside(suffix)).into_iter().find(|path| path.exists());
        match found {
            Some(found) if !resume => {
                let (exists, file) = ("this file of an unfinished run exists; continue the run with ", found.display());
                let why = words![exists, key("resume"), ", or delete the file"];
                Err(Unusable::of(why).at(file.to_string()).into())
            }
            None if resume => {
                let head = String::from_utf8_lossy(&self.head);
                check_finished(output, |config| head.contains(config)).map(|()| false)
            }
            found => Ok(found.is_some()),
        }
    }

    fn recall(&mut self, parts: usize) -> Result<(), Failure> {
        let [_, state, running] = SUFFIXES.map(|suffix| self.beside(suffix));
        self.state = Stored::read(state.as_deref(), &self.head, &self.share)?;
        self.finished = self.state.as_ref().map_or(0, Stored::parts);
        // The copy of a solve that has ended since is useless.
        let running = Stored::read(running.as_deref(), &self.head, &self.share)?;
        self.running = running.filter(|running| running.parts() == self.finished);
        let opened = self.open_journal(parts);
        self.agree(opened)?;
        self.on_disk = true;
        (self.done, self.kept) = (self.finished, self.finished);
        tracing::info!("finished parts taken over: {} of {parts}", self.finished);
        Ok(())
    }

    /// Opens the journal at the process that writes, with the records of the finished parts.
    fn open_journal(&mut self, parts: usize) -> Result<(), Failure> {
        let [Some(path), Some(state)] = [".journal", ".state"].map(|suffix| self.beside(suffix)) else { return Ok(()) };
        let journal = Journal::open(&path, &self.head).map_err(Failure::from)?;
        let mut starts = vec![0];
        while let Some(start) = starts.last().copied().filter(|start| *start < journal.len()) {
            let head = journal.read(start).map_err(Failure::from)?;
            let unusable = || Failure::from(journal.unusable(start, "this is not a part of a run"));
            starts.push(PartHead::decode(&head).ok_or_else(unusable)?.pieces.saturating_add(start + 1));
        }
        let whole = starts.iter().filter(|start| **start <= journal.len()).count() - 1;
        if self.finished > parts || self.finished > whole {
            let found = format!("it is of part {}; the journal has {whole}", self.finished);
            return Err(Failure::input(state.display().to_string(), found));
        }
        // A kill between the two writes leaves records without their state.
        starts.truncate(self.finished + 1);
        journal.keep_first(starts[self.finished]).map_err(Failure::from)?;
        (self.journal, self.starts) = (Some(journal), starts);
        Ok(())
    }

    /// Returns the path of a file beside the output at the process that writes.
    fn beside(&self, suffix: &str) -> Option<PathBuf> {
        self.output.map(|output| output.beside(suffix))
    }

    /// Returns the common outcome of what only the first process did.
    fn agree<T>(&self, outcome: Result<T, Failure>) -> Result<T, Failure> {
        if self.share.is_whole() { outcome } else { agree(self.share.ranks(), outcome) }
    }

    /// Returns the number of finished parts.
    pub fn finished(&self) -> usize {
        self.finished
    }

    /// Reads the text of a finished part.
    ///
    /// # Errors
    /// Returns an error, at all processes, if a file cannot be read.
    pub fn text(&self, index: usize) -> Result<String, Failure> {
        let read = || self.journal.as_ref().map_or(Ok(String::new()), |_| Ok(self.part_head(index)?.text));
        let text = self.agree(read())?;
        if self.share.is_whole() { Ok(text) } else { Ok(texts(self.share.ranks(), &text).swap_remove(0)) }
    }

    /// Reads the fields of a finished part in pieces of whole rows: `take` gets the number of the field, the place of
    /// the first value, and the values. Processes that do not write get nothing.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read, and the errors of `take`.
    pub fn pieces(
        &self,
        index: usize,
        mut take: impl FnMut(usize, usize, &[f64]) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let Some(journal) = &self.journal else { return Ok(()) };
        let mut record = self.starts[index] + 1;
        for (field, length) in self.part_head(index)?.lengths.into_iter().enumerate() {
            let mut place = 0;
            while place < length {
                let bytes = journal.read(record).map_err(Failure::from)?;
                let (numbers, rest) = bytes.as_chunks::<8>();
                if !rest.is_empty() || numbers.is_empty() || numbers.len() > length - place {
                    return Err(journal.unusable(record, "this is not a piece of a field").into());
                }
                let values: Vec<f64> = numbers.iter().map(|number| f64::from_le_bytes(*number)).collect();
                take(field, place, &values)?;
                (place, record) = (place + values.len(), record + 1);
            }
        }
        Ok(())
    }

    /// Reads a finished part of a single process.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read.
    pub fn part(&self, index: usize) -> Result<FinishedStep<'static>, Failure> {
        let PartHead { text, lengths, .. } = self.part_head(index)?;
        let mut fields = vec![Vec::new(); lengths.len()];
        self.pieces(index, |field, _, values| {
            fields[field].extend_from_slice(values);
            Ok(())
        })?;
        Ok(FinishedStep { text, fields: fields.into_iter().map(Cow::Owned).collect() })
    }

    fn part_head(&self, index: usize) -> Result<PartHead, Failure> {
        let missing = || Failure::computation(format!("there is no part {index}"));
        let (journal, start) = self.journal.as_ref().zip(self.starts.get(index)).ok_or_else(missing)?;
        let record = journal.read(*start).map_err(Failure::from)?;
        PartHead::decode(&record).ok_or_else(|| self.unusable(index, "this is not a part of a run"))
    }

    /// Returns the error for a part with unusable text.
    pub fn unusable(&self, index: usize, reason: impl std::fmt::Display) -> Failure {
        let text = reason.to_string();
        match self.journal.as_ref().zip(self.starts.get(index)) {
            Some((journal, start)) => Failure::from(journal.unusable(*start, text)),
            None => Failure::computation(text),
        }
    }

    /// Returns the state of the last finished part, once.
    pub fn state(&mut self) -> Option<Stored> {
        self.state.take()
    }

    /// Returns the variables of the solve that was running.
    pub fn running(&mut self) -> Option<&mut Stored> {
        self.running = self.running.take().filter(|running| !running.is_at_end());
        self.running.as_mut()
    }

    /// Adds a finished part, with `further` fields after its own; [`keep_state`](Self::keep_state) keeps its state.
    ///
    /// # Errors
    /// Returns an error, at all processes, if a file cannot be written.
    pub fn add(&mut self, part: &FinishedStep, further: &[OwnRows]) -> Result<(), Failure> {
        self.done += 1;
        let (share, columns) = (self.share.clone(), self.share.columns());
        let block = height(columns) * columns;
        let lengths = part.fields.iter().map(|field| if share.is_whole() { field.len() } else { share.total() });
        let of_further = further.iter().map(|rows| rows.share.total());
        let blocks = further.iter().map(|rows| height(rows.share.columns()) * rows.share.columns());
        let blocks: Vec<usize> = part.fields.iter().map(|_| block).chain(blocks).collect();
        let lengths: Vec<usize> = lengths.chain(of_further).collect();
        let pieces = lengths.iter().zip(blocks).map(|(length, block)| length.div_ceil(block)).sum();
        let mut written = self.wait(PartHead { text: part.text.clone(), lengths, pieces }.encode());
        for field in &part.fields {
            let mut take = |values: &[f64]| {
                let piece = || values.iter().flat_map(|number| number.to_le_bytes()).collect();
                if written.is_ok() {
                    written = self.wait(piece());
                }
            };
            if share.is_whole() {
                field.chunks(block).for_each(&mut take);
            } else {
                share.to_first(field, columns, height(columns), |_, values| take(values));
            }
        }
        for rows in further {
            rows.to_first(|_, values| {
                let piece = || values.iter().flat_map(|number| number.to_le_bytes()).collect();
                if written.is_ok() {
                    written = self.wait(piece());
                }
            });
        }
        self.agree(written)
    }

    /// Lets a record wait, or writes all that wait if they are many.
    fn wait(&mut self, record: Vec<u8>) -> Result<(), Failure> {
        if self.output.is_none() {
            return Ok(());
        }
        self.waiting_bytes += record.len();
        self.waiting.push(record);
        if self.waiting_bytes > MOST_WAITING { self.append() } else { Ok(()) }
    }

    /// Writes the records that wait to the journal.
    fn append(&mut self) -> Result<(), Failure> {
        let Some(path) = self.beside(".journal") else { return Ok(()) };
        if self.journal.is_none() {
            self.journal = Some(Journal::open(&path, &self.head).map_err(not_written)?);
            self.on_disk = true;
        }
        if let Some(journal) = &self.journal {
            journal.append(&self.waiting).map_err(not_written)?;
        }
        self.waiting.clear();
        self.waiting_bytes = 0;
        Ok(())
    }

    /// Keeps the added part, and the state after it.
    ///
    /// # Errors
    /// Returns an error, at all processes, if the file cannot be written.
    pub fn keep_state(&mut self, mut state: impl FnMut(&mut dyn Visit)) -> Result<(), Failure> {
        if !self.share.is_whole() {
            let appended = self.append();
            self.agree(appended)?;
            self.replace(".state", &mut state)?;
            self.kept = self.done;
            return Ok(());
        }
        let mut writer = Writer::new(Vec::new(), &self.head, self.done);
        state(&mut writer);
        self.latest = writer.finish().map_err(|error| Failure::computation(error.to_string()))?;
        let is_time = self.written.elapsed() >= WRITE_INTERVAL_FACTOR * self.cost;
        if is_time || self.waiting_bytes + self.latest.len() > MOST_WAITING {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes everything that waits.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn flush(&mut self) -> Result<(), Failure> {
        let Some(state) = self.beside(".state").filter(|_| !self.latest.is_empty()) else { return Ok(()) };
        let started = Instant::now();
        self.append()?;
        let latest = std::mem::take(&mut self.latest);
        gfmd_files::replace(&state, |file| file.write_all(&latest))?;
        self.kept = self.done;
        (self.cost, self.written) = (started.elapsed(), Instant::now());
        Ok(())
    }

    /// Returns true if it is time to copy the running solve, or if any process is `asked` to.
    pub(crate) fn is_due(&self, asked: bool) -> bool {
        let elapsed = self.written.elapsed();
        let is_time = self.every.is_some_and(|every| elapsed >= every && elapsed >= WRITE_INTERVAL_FACTOR * self.cost);
        self.share.any(asked || (is_time && self.output.is_some()))
    }

    /// Copies the running solve.
    ///
    /// # Errors
    /// Returns an error, at all processes, if the file cannot be written.
    pub fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) -> Result<(), Failure> {
        self.flush()?;
        self.replace(".checkpoint", variables)
    }

    /// Replaces a file of variables.
    fn replace(&mut self, suffix: &str, variables: &mut dyn FnMut(&mut dyn Visit)) -> Result<(), Failure> {
        let started = Instant::now();
        let (head, done, mut is_visited) = (&self.head, self.done, false);
        let written = self.beside(suffix).map_or(Ok(()), |path| {
            gfmd_files::replace(&path, |file| {
                is_visited = true;
                let mut writer = Writer::new(file, head, done);
                variables(&mut writer);
                writer.finish().map(drop)
            })
        });
        if !is_visited && !self.share.is_whole() {
            // The rows travel in any case.
            variables(&mut Writer::new(io::sink(), head, done));
        }
        self.agree(written.map_err(Failure::from))?;
        self.on_disk = self.output.is_some();
        (self.cost, self.written) = (started.elapsed(), Instant::now());
        Ok(())
    }

    /// Returns the remark on a failure: the parts that are kept, and how to continue.
    pub fn remark(&self) -> Words {
        let (parts, Some(output), true) = (self.kept, self.output, self.on_disk) else { return Words::default() };
        let ([journal, state, running], path) = (SUFFIXES.map(|suffix| output.beside(suffix)), output.path().display());
        let plural = if parts == 1 { "" } else { "s" };
        // A checkpoint may precede the first finished part.
        if (journal.exists() && state.exists()) || (parts == 0 && running.exists()) {
            let kept = format!("; {parts} finished part{plural} and the state are kept beside {path}, ");
            words![kept, key("resume"), " continues"]
        } else {
            format!("; the files beside {path} that kept {parts} finished part{plural} and the state are gone").into()
        }
    }

    /// Removes the files, since the run is complete and its output stored. A kill may have left an unfinished file.
    pub fn remove(self) {
        let unfinished = [".state.part", ".checkpoint.part"];
        let paths = SUFFIXES.into_iter().chain(unfinished).filter_map(|suffix| self.beside(suffix));
        for path in paths.filter(|path| path.exists()) {
            if let Err(error) = std::fs::remove_file(&path) {
                tracing::info!("cannot remove {}: {error}", path.display());
            }
        }
    }
}

/// Returns the failure for a file that cannot be written.
pub(crate) fn not_written(error: JournalError) -> Failure {
    Failure::computation(error.to_string())
}

/// First record of a part in the journal; the pieces of its fields follow, each a record.
#[derive(Debug, PartialEq)]
struct PartHead {
    text: String,
    /// Number of values of each field.
    lengths: Vec<usize>,
    /// Number of pieces of all fields.
    pieces: usize,
}

impl PartHead {
    fn encode(&self) -> Vec<u8> {
        let numbers = [self.pieces, self.lengths.len()].into_iter().chain(self.lengths.iter().copied());
        let mut bytes: Vec<u8> = numbers.flat_map(|number| (number as u64).to_le_bytes()).collect();
        bytes.extend(self.text.as_bytes());
        bytes
    }

    fn decode(mut bytes: &[u8]) -> Option<Self> {
        let mut number = || {
            let (number, rest) = bytes.split_first_chunk::<8>()?;
            bytes = rest;
            usize::try_from(u64::from_le_bytes(*number)).ok()
        };
        let (pieces, fields) = (number()?, number()?);
        let lengths = (0..fields).map(|_| number()).collect::<Option<_>>()?;
        Some(Self { text: String::from_utf8(bytes.to_vec()).ok()?, lengths, pieces })
    }
}

#[cfg(test)]
mod tests {
    use gfmd_problem::Spelling;
    use gfmd_vector::ThreadRanks;

    use super::*;

    #[test]
    fn heads_of_parts_are_read_back_and_others_refused() {
        let head = PartHead { text: "kappa = nan\n".into(), lengths: vec![2, 0], pieces: 1 };
        let bytes = head.encode();
        assert_eq!(PartHead::decode(&bytes).unwrap(), head);
        for length in 0..bytes.len() {
            assert!(PartHead::decode(&bytes[..length]).is_none_or(|shorter| shorter != head), "{length}");
        }
        assert_eq!(PartHead::decode(&[255; 64]), None);
    }

    #[test]
    fn a_run_is_continued_with_its_own_files_only() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::claim(folder.path().join("a.h5")).unwrap();
        let args = |resume| ResumeArgs { resume };
        let part = |number: f64| FinishedStep { text: format!("{number}"), fields: vec![vec![number; 3].into()] };
        let mut kept =
            UnfinishedRun::open((Some(&output), &Share::whole(1, 3)), "one".into(), 4, args(false), None).unwrap();
        assert_eq!(kept.finished(), 0);
        kept.add(&part(0.0), &[]).unwrap();
        kept.keep_state(|visitor| visitor.number(&mut 0.5)).unwrap();
        assert!(!folder.path().join("a.h5.journal").exists(), "a short run writes nothing");
        kept.add(&part(1.0), &[]).unwrap();
        kept.keep_state(|visitor| visitor.number(&mut 1.5)).unwrap();
        kept.checkpoint(&mut |visitor| visitor.field(&mut [2.5; 2])).unwrap();
        drop(kept);

        let refused = UnfinishedRun::open((Some(&output), &Share::whole(1, 3)), "one".into(), 4, args(false), None)
            .err()
            .unwrap()
            .to_string();
        assert!(refused.contains("a.h5.journal") && refused.contains("--resume"), "{refused}");
        let other =
            UnfinishedRun::open((Some(&output), &Share::whole(1, 3)), "two".into(), 4, args(true), None).err().unwrap();
        assert!(other.status() == 2 && other.to_string().contains("another configuration"), "{other}");

        let mut kept =
            UnfinishedRun::open((Some(&output), &Share::whole(1, 3)), "one".into(), 4, args(true), None).unwrap();
        assert_eq!(kept.finished(), 2);
        assert_eq!(kept.part(1).unwrap().fields, [vec![1.0; 3]]);
        let number = kept.state().unwrap().restore(|visitor| {
            let mut number = 0.0;
            visitor.number(&mut number);
            Ok::<_, Failure>(number)
        });
        assert_eq!(number.unwrap(), 1.5);
        let mut field = [0.0; 2];
        kept.running().unwrap().field(&mut field);
        assert_eq!(field, [2.5; 2]);
        assert!(kept.running().is_none(), "it is read once");
        // The next part ends, and the copy of its solve becomes useless.
        kept.add(&part(2.0), &[]).unwrap();
        kept.keep_state(|visitor| visitor.number(&mut 2.5)).unwrap();
        kept.flush().unwrap();
        drop(kept);
        let mut kept =
            UnfinishedRun::open((Some(&output), &Share::whole(1, 3)), "one".into(), 4, args(true), None).unwrap();
        assert_eq!(kept.finished(), 3);
        assert!(kept.running().is_none());
        std::fs::write(folder.path().join("a.h5.state.part"), "cut off by a kill").unwrap();
        kept.remove();
        drop(output);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_time_between_copies_is_checked() {
        let every = |checkpoint| CheckpointArgs { checkpoint }.every();
        assert_eq!(every(0.0).unwrap(), None);
        assert_eq!(every(0.5).unwrap(), Some(Duration::from_millis(500)));
        for bad in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
            assert!(every(bad).unwrap_err().to_string().starts_with("--checkpoint is"), "{bad}");
        }
    }

    #[test]
    fn what_was_removed_is_not_said_to_be_kept() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        let output = Output::claim(inner.join("a.h5")).unwrap();
        let mut kept = UnfinishedRun::open(
            (Some(&output), &Share::whole(1, 3)),
            "one".into(),
            4,
            ResumeArgs { resume: false },
            None,
        )
        .unwrap();
        assert!(kept.remark().is_empty());
        kept.add(&FinishedStep { text: "0".into(), fields: vec![] }, &[]).unwrap();
        kept.keep_state(|visitor| visitor.field(&mut [0.25; 8])).unwrap();
        kept.flush().unwrap();
        let remark = kept.remark().spelled(Spelling::Flag);
        assert!(remark.starts_with("; 1 finished part and the state are kept beside"), "{remark}");
        std::fs::remove_dir_all(&inner).unwrap();
        let remark = kept.remark().spelled(Spelling::Flag);
        assert!(remark.ends_with("that kept 1 finished part and the state are gone"), "{remark}");
        assert!(!remark.contains("--resume"), "{remark}");
    }

    #[test]
    fn a_damaged_state_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::claim(folder.path().join("a.h5")).unwrap();
        let args = ResumeArgs { resume: true };
        let mut kept = UnfinishedRun::open((Some(&output), &Share::whole(1, 3)), "one".into(), 4, args, None).unwrap();
        kept.add(&FinishedStep { text: "0".into(), fields: vec![] }, &[]).unwrap();
        kept.keep_state(|visitor| visitor.field(&mut [0.25; 8])).unwrap();
        kept.flush().unwrap();
        drop(kept);
        let path = folder.path().join("a.h5.state");
        let good = std::fs::read(&path).unwrap();
        for position in 0..good.len() {
            let mut bad = good.clone();
            bad[position] ^= 1;
            std::fs::write(&path, &bad).unwrap();
            let refused = UnfinishedRun::open((Some(&output), &Share::whole(1, 3)), "one".into(), 4, args, None)
                .err()
                .expect("a flipped bit is noticed");
            assert!(refused.status() == 2 && refused.to_string().contains("a.h5.state"), "{position}: {refused}");
        }
    }

    #[test]
    fn several_processes_continue_the_run_of_any_number() {
        const COLUMNS: usize = 2048;
        let folder = tempfile::tempdir().unwrap();
        let output = &Output::claim(folder.path().join("a.h5")).unwrap();
        let field = |start: f64| -> Vec<f64> { (0..6 * COLUMNS).map(|i| start + i as f64).collect() };
        let number_of = |share: &Share| share.own().map(|i| 7.0 + i as f64).collect::<Vec<_>>();
        // Keeps part `index`, of two fields, and a state of all kinds of variables; then copies a running solve.
        let keep = |kept: &mut UnfinishedRun, share: &Share, index: usize| {
            let fields = [0.0, 0.5].map(|start| Cow::Owned(field(start + index as f64)[share.own()].to_vec()));
            kept.add(&FinishedStep { text: format!("part {index}"), fields: fields.into() }, &[]).unwrap();
            let mut rows = number_of(share);
            kept.keep_state(|visitor| {
                visitor.rows(share, &mut rows);
                visitor.field(&mut [index as f64, -1.0]);
                visitor.single_rows(share, &mut rows.iter().map(|x| *x as f32).collect::<Vec<_>>());
                visitor.flag(&mut true);
            })
            .unwrap();
            assert!(kept.is_due(share.ranks().rank() + 1 == share.ranks().size()), "any process may ask");
            kept.checkpoint(&mut |visitor| visitor.rows(share, &mut rows)).unwrap();
        };
        let restore = |kept: &mut UnfinishedRun, share: &Share, last: usize| {
            for index in 0..=last {
                assert_eq!(kept.text(index).unwrap(), format!("part {index}"));
                let mut found = [vec![], vec![]];
                let take = |field: usize, place: usize, values: &[f64]| {
                    assert_eq!((place, place % COLUMNS), (found[field].len(), 0));
                    found[field].extend_from_slice(values);
                    Ok(())
                };
                kept.pieces(index, take).unwrap();
                let is_first = share.ranks().rank() == 0;
                let wanted = [0.0, 0.5].map(|start| if is_first { field(start + index as f64) } else { vec![] });
                assert!(found == wanted);
            }
            let own = share.own().len();
            let (mut rows, mut pair, mut single) = (vec![0.0; own], [0.0; 2], vec![0.0; own]);
            let mut flag = false;
            let read = kept.state().unwrap().restore(|visitor| {
                visitor.rows(share, &mut rows);
                visitor.field(&mut pair);
                visitor.single_rows(share, &mut single);
                visitor.flag(&mut flag);
                Ok::<_, Failure>(())
            });
            read.unwrap();
            assert!(rows == number_of(share) && pair == [last as f64, -1.0] && flag);
            assert!(single.iter().zip(&rows).all(|(single, x)| f64::from(*single) == *x));
            rows.fill(0.0);
            kept.running().unwrap().rows(share, &mut rows);
            assert!(rows == number_of(share) && kept.running().is_none());
        };
        for (part, size) in [3, 1, 2, 6].into_iter().enumerate() {
            ThreadRanks::of(size, |ranks| {
                let is_first = ranks.rank() == 0;
                let share = &Share::among(ranks, [6, COLUMNS], 0).unwrap();
                let place = (is_first.then_some(output), share);
                let every = Some(Duration::from_secs(3600));
                let open =
                    |resume, head: &str| UnfinishedRun::open(place, head.into(), 4, ResumeArgs { resume }, every);
                if part > 0 {
                    let refused = open(false, "one").err().unwrap().to_string();
                    assert!(refused.contains("a.h5.journal") && refused.contains("--resume"), "{refused}");
                    let other = open(true, if is_first { "two" } else { "" }).err().unwrap().to_string();
                    assert!(other.contains("another configuration"), "{other}");
                }
                let mut kept = open(part > 0, if is_first { "one" } else { "" }).unwrap();
                assert_eq!(kept.finished(), part);
                if let Some(last) = part.checked_sub(1) {
                    restore(&mut kept, share, last);
                }
                keep(&mut kept, share, part);
                assert_eq!(kept.remark().is_empty(), !is_first);
            });
        }
        // A disk that is full fails on all processes.
        ThreadRanks::of(2, |ranks| {
            let place = (ranks.rank() == 0).then_some(output);
            let share = &Share::among(ranks, [6, COLUMNS], 0).unwrap();
            let resume = ResumeArgs { resume: true };
            let mut kept = UnfinishedRun::open((place, share), "one".into(), 4, resume, None).unwrap();
            share.any(false);
            if place.is_some() {
                std::fs::create_dir(folder.path().join("a.h5.checkpoint.part")).unwrap();
            }
            let failed = kept.checkpoint(&mut |visitor| visitor.rows(share, &mut number_of(share))).unwrap_err();
            assert!(failed.to_string().contains("a.h5.checkpoint.part"), "{failed}");
        });
    }
}
