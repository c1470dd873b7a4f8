//! Finished parts of a command that solves its parts in turn, each from the previous state. They are kept beside the
//! output, so that `--resume` continues a killed run, and ends with the numbers of an uninterrupted one.
//!
//! | file beside `OUT`   | contents                                                                    |
//! |---------------------|-----------------------------------------------------------------------------|
//! | `OUT.journal`       | the record of every finished part, appended                                 |
//! | `OUT.state`         | the state of the last finished part, the start of the next one              |
//! | `OUT.checkpoint`    | the variables of the running solve                                          |
//!
//! Writing takes at most a twentieth of the time; a part that ends too soon after the last write waits in memory.

mod snapshot;

use std::borrow::Cow;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use gfmd_contact::Visit;
use gfmd_files::{Journal, JournalError, Output};
use gfmd_problem::{Unusable, Words, key, words};

use gfmd_input::failure::Failure;
use gfmd_problem::options::Options;
use snapshot::{Stored, Writer};

/// The flag of a command that can be continued.
#[derive(Args, Options, Clone, Copy, Debug)]
#[command(next_help_heading = "Long runs")]
pub struct ResumeArgs {
    /// Continue a run that was interrupted or killed, from what is kept beside --out
    #[arg(long, requires = "out")]
    pub resume: bool,
}

/// The flag of a command that copies a running solve.
#[derive(Args, Options, Clone, Copy, Debug)]
#[command(next_help_heading = "Long runs")]
pub struct CheckpointArgs {
    /// Time between two copies of the running solve beside --out; 0 for none
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

/// Number of bytes that may wait in memory.
const MOST_WAITING: usize = 1 << 26;

/// Finished part: its scalars as text, and its fields for the output.
pub struct FinishedStep<'a> {
    /// Scalars.
    pub text: String,
    /// Fields, in the order of the output.
    pub fields: Vec<Cow<'a, [f64]>>,
}

/// Files beside an output that is being computed.
pub struct UnfinishedRun<'a> {
    output: &'a Output,
    /// Text that identifies the run.
    head: Vec<u8>,
    journal: Option<Journal>,
    /// Number of parts in the journal when the run began.
    finished: usize,
    state: Option<Stored>,
    running: Option<Stored>,
    /// Records that wait to be written, and the state after the last one.
    waiting: Vec<Vec<u8>>,
    latest: Vec<u8>,
    /// Number of parts, including waiting ones.
    done: usize,
    /// True once a file was written, or if one existed.
    on_disk: bool,
    written: Instant,
    cost: Duration,
    every: Option<Duration>,
}

impl<'a> UnfinishedRun<'a> {
    /// Opens what is kept of the run that `head` identifies, with at most `parts` parts.
    ///
    /// # Errors
    /// Returns an error for an unfinished run without `--resume`, for files of another run, and for damaged files.
    pub fn open(
        output: &'a Output,
        head: String,
        parts: usize,
        ResumeArgs { resume }: ResumeArgs,
        every: Option<Duration>,
    ) -> Result<Self, Failure> {
        let mut kept = Self {
            output,
            head: head.into_bytes(),
            journal: None,
            finished: 0,
            state: None,
            running: None,
            waiting: Vec::new(),
            latest: Vec::new(),
            done: 0,
            on_disk: false,
            written: Instant::now(),
            cost: FIRST_COST,
            every,
        };
        output.check_beside(&[".checkpoint.part", ".journal"]).map_err(|error| Failure::input(key("out"), error))?;
        let Some(found) = kept.paths().into_iter().find(|path| path.exists()) else { return Ok(kept) };
        if !resume {
            let (exists, file) = ("this file of an unfinished run exists; continue the run with ", found.display());
            let why = words![exists, key("resume"), ", or delete the file"];
            return Err(Unusable::of(why).at(file.to_string()).into());
        }
        kept.recall(parts)?;
        Ok(kept)
    }

    fn recall(&mut self, parts: usize) -> Result<(), Failure> {
        let [journal, state, running] = self.paths();
        self.on_disk = true;
        let journal = Journal::open(&journal, &self.head).map_err(Failure::from)?;
        self.state = Stored::read(&state, &self.head)?;
        self.finished = self.state.as_ref().map_or(0, Stored::parts);
        if self.finished > parts || self.finished > journal.len() {
            let found = format!("it is of part {}; the journal has {}", self.finished, journal.len());
            return Err(Failure::input(state.display().to_string(), found));
        }
        // A kill between the two writes leaves a record without its state.
        journal.keep_first(self.finished).map_err(Failure::from)?;
        self.journal = Some(journal);
        // The copy of a solve that has ended since is useless.
        self.running = Stored::read(&running, &self.head)?.filter(|running| running.parts() == self.finished);
        self.done = self.finished;
        tracing::info!("finished parts taken over: {} of {parts}", self.finished);
        Ok(())
    }

    fn paths(&self) -> [PathBuf; 3] {
        [".journal", ".state", ".checkpoint"].map(|suffix| self.output.beside(suffix))
    }

    /// Returns the number of finished parts.
    pub fn finished(&self) -> usize {
        self.finished
    }

    /// Reads a finished part.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read.
    pub fn part(&self, index: usize) -> Result<FinishedStep<'static>, Failure> {
        let missing = || Failure::computation(format!("there is no part {index}"));
        let journal = self.journal.as_ref().ok_or_else(missing)?;
        let record = journal.read(index).map_err(Failure::from)?;
        FinishedStep::decode(&record)
            .ok_or_else(|| Failure::from(journal.unusable(index, "this is not a part of a run")))
    }

    /// Returns the error for a part with unusable text.
    pub fn unusable(&self, index: usize, reason: impl std::fmt::Display) -> Failure {
        let text = reason.to_string();
        match &self.journal {
            Some(journal) => Failure::from(journal.unusable(index, text)),
            None => Failure::computation(text),
        }
    }

    /// Returns the state of the last finished part, once.
    pub fn state(&mut self) -> Option<Stored> {
        self.state.take()
    }

    /// Returns the variables of the solve that was running.
    pub fn running(&mut self) -> Option<&mut Stored> {
        self.running.as_mut().filter(|running| !running.is_at_end())
    }

    /// Adds a finished part; [`keep_state`](Self::keep_state) keeps its state.
    pub fn add(&mut self, part: &FinishedStep) {
        self.waiting.push(part.encode());
        self.done += 1;
    }

    /// Keeps the added part, and the state after it.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn keep_state(&mut self, state: impl FnOnce(&mut dyn Visit)) -> Result<(), Failure> {
        let mut writer = Writer::new(Vec::new(), &self.head, self.done);
        state(&mut writer);
        self.latest = writer.finish().map_err(|error| Failure::computation(error.to_string()))?;
        let waiting: usize = self.waiting.iter().map(Vec::len).sum::<usize>() + self.latest.len();
        if self.written.elapsed() >= WRITE_INTERVAL_FACTOR * self.cost || waiting > MOST_WAITING {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes everything that waits.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn flush(&mut self) -> Result<(), Failure> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        let started = Instant::now();
        let [journal, state, _] = self.paths();
        if self.journal.is_none() {
            self.journal = Some(Journal::open(&journal, &self.head).map_err(not_written)?);
            self.on_disk = true;
        }
        if let Some(journal) = &self.journal {
            journal.append(&self.waiting).map_err(not_written)?;
        }
        self.waiting.clear();
        let latest = std::mem::take(&mut self.latest);
        gfmd_files::replace(&state, |file| std::io::Write::write_all(file, &latest))?;
        (self.cost, self.written) = (started.elapsed(), Instant::now());
        Ok(())
    }

    /// Returns true if it is time to copy the running solve.
    pub(crate) fn is_due(&self) -> bool {
        let elapsed = self.written.elapsed();
        self.every.is_some_and(|every| elapsed >= every && elapsed >= WRITE_INTERVAL_FACTOR * self.cost)
    }

    /// Copies the running solve.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) -> Result<(), Failure> {
        self.flush()?;
        let started = Instant::now();
        let [_, _, path] = self.paths();
        gfmd_files::replace(&path, |file| {
            let mut writer = Writer::new(file, &self.head, self.done);
            variables(&mut writer);
            writer.finish().map(drop)
        })?;
        self.on_disk = true;
        (self.cost, self.written) = (started.elapsed(), Instant::now());
        Ok(())
    }

    /// Returns the remark on a failure: the parts that are kept, and how to continue.
    pub fn remark(&self) -> Words {
        let parts = self.done - self.waiting.len();
        if !self.on_disk {
            return Words::default();
        }
        let ([journal, state, running], path) = (self.paths(), self.output.path().display());
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
        let unfinished = [".state.part", ".checkpoint.part"].map(|suffix| self.output.beside(suffix));
        for path in self.paths().into_iter().chain(unfinished).filter(|path| path.exists()) {
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

impl FinishedStep<'_> {
    fn encode(&self) -> Vec<u8> {
        let size = |field: &Cow<[f64]>| 8 + 8 * field.len();
        let mut bytes = Vec::with_capacity(8 + self.text.len() + self.fields.iter().map(size).sum::<usize>());
        bytes.extend((self.text.len() as u64).to_le_bytes());
        bytes.extend(self.text.as_bytes());
        for field in &self.fields {
            bytes.extend((8 * field.len() as u64).to_le_bytes());
            field.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        }
        bytes
    }

    fn decode(mut bytes: &[u8]) -> Option<FinishedStep<'static>> {
        let mut piece = || -> Option<&[u8]> {
            let (length, rest) = bytes.split_first_chunk::<8>()?;
            let (content, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
            bytes = rest;
            Some(content)
        };
        let text = String::from_utf8(piece()?.to_vec()).ok()?;
        let fields = std::iter::from_fn(piece).map(|field| {
            let (numbers, rest) = field.as_chunks::<8>();
            rest.is_empty().then(|| numbers.iter().map(|number| f64::from_le_bytes(*number)).collect::<Vec<_>>().into())
        });
        let fields = fields.collect::<Option<Vec<Cow<[f64]>>>>()?;
        bytes.is_empty().then_some(FinishedStep { text, fields })
    }
}

#[cfg(test)]
mod tests {
    use gfmd_problem::Spelling;

    use super::*;

    #[test]
    fn parts_are_read_back_and_others_refused() {
        let part =
            FinishedStep { text: "kappa = nan\n".into(), fields: vec![vec![0.1, f64::NAN].into(), vec![].into()] };
        let bytes = part.encode();
        let back = FinishedStep::decode(&bytes).unwrap();
        assert_eq!(back.text, part.text);
        assert_eq!(back.fields.len(), 2);
        assert_eq!(back.fields[0][0].to_bits(), 0.1_f64.to_bits());
        assert!(back.fields[0][1].is_nan());
        for length in 0..bytes.len() {
            let shorter = FinishedStep::decode(&bytes[..length]);
            assert!(shorter.is_none_or(|shorter| shorter.fields.len() < 2), "{length}");
        }
    }

    #[test]
    fn a_run_is_continued_with_its_own_files_only() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::claim(folder.path().join("a.h5")).unwrap();
        let args = |resume| ResumeArgs { resume };
        let part = |number: f64| FinishedStep { text: format!("{number}"), fields: vec![vec![number; 3].into()] };
        let mut kept = UnfinishedRun::open(&output, "one".into(), 4, args(false), None).unwrap();
        assert_eq!(kept.finished(), 0);
        kept.add(&part(0.0));
        kept.keep_state(|visitor| visitor.number(&mut 0.5)).unwrap();
        assert!(!folder.path().join("a.h5.journal").exists(), "a short run writes nothing");
        kept.add(&part(1.0));
        kept.keep_state(|visitor| visitor.number(&mut 1.5)).unwrap();
        kept.checkpoint(&mut |visitor| visitor.field(&mut [2.5; 2])).unwrap();
        drop(kept);

        let refused = UnfinishedRun::open(&output, "one".into(), 4, args(false), None).err().unwrap().to_string();
        assert!(refused.contains("a.h5.journal") && refused.contains("--resume"), "{refused}");
        let other = UnfinishedRun::open(&output, "two".into(), 4, args(true), None).err().unwrap();
        assert!(other.status() == 2 && other.to_string().contains("another configuration"), "{other}");

        let mut kept = UnfinishedRun::open(&output, "one".into(), 4, args(true), None).unwrap();
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
        kept.add(&part(2.0));
        kept.keep_state(|visitor| visitor.number(&mut 2.5)).unwrap();
        kept.flush().unwrap();
        drop(kept);
        let mut kept = UnfinishedRun::open(&output, "one".into(), 4, args(true), None).unwrap();
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
        let mut kept = UnfinishedRun::open(&output, "one".into(), 4, ResumeArgs { resume: false }, None).unwrap();
        assert!(kept.remark().is_empty());
        kept.add(&FinishedStep { text: "0".into(), fields: vec![] });
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
        let mut kept = UnfinishedRun::open(&output, "one".into(), 4, args, None).unwrap();
        kept.add(&FinishedStep { text: "0".into(), fields: vec![] });
        kept.keep_state(|visitor| visitor.field(&mut [0.25; 8])).unwrap();
        kept.flush().unwrap();
        drop(kept);
        let path = folder.path().join("a.h5.state");
        let good = std::fs::read(&path).unwrap();
        for position in 0..good.len() {
            let mut bad = good.clone();
            bad[position] ^= 1;
            std::fs::write(&path, &bad).unwrap();
            let refused =
                UnfinishedRun::open(&output, "one".into(), 4, args, None).err().expect("a flipped bit is noticed");
            assert!(refused.status() == 2 && refused.to_string().contains("a.h5.state"), "{position}: {refused}");
        }
    }
}
