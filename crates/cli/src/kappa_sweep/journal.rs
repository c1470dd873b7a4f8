//! The journal of a running sweep: one line of JSON for each finished run, on the disk before the run counts as finished.
//!
//! The first line identifies the sweep. Lines are appended and never changed, so that a process that is killed at any
//! moment loses no finished run. A last line without line break is incomplete: resuming removes it and computes its run
//! again. Any other line that cannot be used is an error.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry as Slot;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use gfmd_contact::{Effort, Residual};
use gfmd_files::{folder, sync_folder};
use gfmd_measure::Summary;
use gfmd_sweep::Pressed;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// Finished runs by number.
pub(super) type Finished = BTreeMap<usize, Vec<Pressed>>;

/// The sweep that a journal belongs to.
#[derive(Serialize, Deserialize, PartialEq)]
struct Head {
    version: String,
    config: String,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    run: usize,
    loads: Vec<Load>,
}

/// The format of a load in a line. The types of the library know no file format, so their fields are repeated here; an
/// incomplete list does not compile.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Pressed")]
struct PressedFields {
    #[serde(with = "SummaryFields")]
    summary: Summary,
    approach: f64,
    #[serde(with = "ResidualFields")]
    residual: Residual,
    #[serde(with = "EffortFields")]
    effort: Effort,
}

#[derive(Serialize, Deserialize)]
struct Load(#[serde(with = "PressedFields")] Pressed);

#[derive(Serialize, Deserialize)]
#[serde(remote = "Summary")]
struct SummaryFields {
    mean_pressure: f64,
    p_star: f64,
    area_fraction: f64,
    area_fraction_corrected: f64,
    kappa: f64,
    kappa_corrected: f64,
    contact_nodes: u64,
    boundary_links: u64,
    mean_gap: f64,
    max_pressure: f64,
    mean_pressure_in_contact: f64,
    pressure_deviation_in_contact: f64,
    pressure_moment_2: f64,
    elastic_energy: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Residual")]
struct ResidualFields {
    complementarity: f64,
    penetration: f64,
    negative_pressure: f64,
    load: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Effort")]
struct EffortFields {
    iterations: u64,
    transform_pairs: f64,
}

impl Entry {
    fn new(run: usize, loads: &[Pressed]) -> Self {
        Self { run, loads: loads.iter().map(|load| Load(*load)).collect() }
    }
}

/// Number of runs of the sweep and of loads of each run.
#[derive(Clone, Copy)]
pub(super) struct Size {
    pub(super) runs: usize,
    pub(super) loads: usize,
}

/// The operations on a file that a journal needs. Tests implement them by a file that fails at any operation.
trait Storage {
    fn read(&mut self) -> io::Result<Vec<u8>>;
    /// Removes all bytes from `length` on.
    fn cut(&mut self, length: usize) -> io::Result<()>;
    /// Writes at the end.
    fn append(&mut self, text: &[u8]) -> io::Result<()>;
    /// Returns when everything is on the disk.
    fn sync(&mut self) -> io::Result<()>;
}

impl Storage for File {
    fn read(&mut self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    fn cut(&mut self, length: usize) -> io::Result<()> {
        self.set_len(length as u64)
    }

    fn append(&mut self, text: &[u8]) -> io::Result<()> {
        self.write_all(text)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}

/// A journal open for writing.
pub(super) struct Journal {
    path: PathBuf,
    lines: Mutex<Lines<File>>,
}

impl Journal {
    /// Starts a journal, or continues an existing one.
    ///
    /// # Errors
    /// A journal that exists although `resume` is false, that belongs to another sweep, or that has an unusable line; a file
    /// that cannot be read or written.
    pub(super) fn open(path: &Path, config: &str, size: Size, resume: bool) -> Result<(Self, Finished), Failure> {
        let name = path.display();
        if path.exists() && !resume {
            let reason = "the journal of an unfinished sweep exists; continue it with --resume, or delete it";
            return Err(Failure::input(&name.to_string(), reason));
        }
        let open = || {
            let file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
            sync_folder(folder(path))?;
            Ok(file)
        };
        let file = open().map_err(|error: io::Error| failed(path, &error))?;
        let head = Head { version: env!("CARGO_PKG_VERSION").into(), config: config.into() };
        let (lines, finished) = Lines::open(file, &head, size).map_err(|error| match error {
            Unusable::Io(error) => failed(path, &error),
            Unusable::Line { number, reason } => Failure::input(&format!("{name}, line {number}"), reason),
        })?;
        Ok((Self { path: path.into(), lines: Mutex::new(lines) }, finished))
    }

    /// Records a finished run.
    ///
    /// # Errors
    /// A number that is not finite, which could not be read again; a file that cannot be written.
    pub(super) fn record(&self, run: usize, loads: &[Pressed]) -> Result<(), Failure> {
        let failed = |error| failed(&self.path, &error);
        let text = line(&Entry::new(run, loads)).map_err(failed)?;
        if text.contains("null") {
            return Err(Failure::Computation(format!(
                "run {run} has a number that is not finite: {}",
                text.trim_end()
            )));
        }
        let mut lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        lines.append(&text).map_err(failed)
    }

    /// The path of the file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the file: the sweep is complete and stored.
    pub(super) fn remove(self) {
        if let Err(error) = std::fs::remove_file(&self.path) {
            tracing::warn!("cannot remove {}: {error}", self.path.display());
        }
    }
}

fn failed(path: &Path, error: &io::Error) -> Failure {
    Failure::Computation(format!("cannot write {}: {error}", path.display()))
}

fn line(value: &impl Serialize) -> io::Result<String> {
    Ok(crate::json::to_string(value)? + "\n")
}

/// Reasons why a journal cannot be continued.
#[derive(Debug)]
enum Unusable {
    Io(io::Error),
    /// A line, counted from 1.
    Line {
        number: usize,
        reason: String,
    },
}

impl From<io::Error> for Unusable {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// The lines of a journal, each ended by a line break.
struct Lines<F> {
    file: F,
    /// True after an append that failed: the last line may be incomplete, so no line may follow it.
    broken: bool,
}

impl<F: Storage> Lines<F> {
    /// Reads the finished runs, removes an incomplete last line, and writes the head if there is none.
    fn open(mut file: F, head: &Head, size: Size) -> Result<(Self, Finished), Unusable> {
        let bytes = file.read()?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let head_line = line(head)?;
        if whole == 0 && !head_line.as_bytes().starts_with(&bytes) {
            return Err(no_head());
        }
        let finished = if whole == 0 { Finished::new() } else { runs(&bytes[..whole - 1], head, size)? };
        if whole < bytes.len() {
            file.cut(whole)?;
            file.sync()?;
        }
        let mut lines = Self { file, broken: false };
        if whole == 0 {
            lines.append(&head_line)?;
        }
        Ok((lines, finished))
    }

    fn append(&mut self, line: &str) -> io::Result<()> {
        if self.broken {
            return Err(io::Error::other("an earlier line could not be written"));
        }
        self.broken = true;
        self.file.append(line.as_bytes())?;
        self.file.sync()?;
        self.broken = false;
        Ok(())
    }
}

fn no_head() -> Unusable {
    Unusable::Line { number: 1, reason: "this is not the journal of a sweep".into() }
}

/// The runs of a journal of the sweep `expected`.
fn runs(text: &[u8], expected: &Head, size: Size) -> Result<Finished, Unusable> {
    let mut lines = text.split(|byte| *byte == b'\n');
    let head: Head = serde_json::from_slice(lines.next().unwrap_or_default()).map_err(|_| no_head())?;
    if head != *expected {
        let reason =
            "the journal belongs to a sweep of another configuration or version; finish that sweep, or delete it";
        return Err(Unusable::Line { number: 1, reason: reason.into() });
    }
    let mut finished = Finished::new();
    for (line, number) in lines.zip(2..) {
        let refuse = |reason: String| Unusable::Line { number, reason };
        let Entry { run, loads } = serde_json::from_slice(line).map_err(|error| {
            let found = error.to_string().replace(" at line 1 column", " at column");
            refuse(format!("this is not a finished run of a sweep: {found}"))
        })?;
        if run >= size.runs {
            return Err(refuse(format!("the run is {run}; it must be from 0 to {}", size.runs - 1)));
        }
        if loads.len() != size.loads {
            return Err(refuse(format!("the run has {} loads; it must have {}", loads.len(), size.loads)));
        }
        match finished.entry(run) {
            Slot::Occupied(_) => {
                return Err(refuse(format!("run {run} is in an earlier line; it must be in the journal once")));
            }
            Slot::Vacant(slot) => drop(slot.insert(loads.into_iter().map(|Load(load)| load).collect())),
        }
    }
    Ok(finished)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use super::*;

    const SIZE: Size = Size { runs: 6, loads: 2 };

    fn head() -> Head {
        Head { version: "1".into(), config: "[surface]\nhurst = [0.8]\n".into() }
    }

    fn first_line() -> String {
        line(&head()).unwrap()
    }

    fn loads(run: usize) -> Vec<Pressed> {
        let kappa = 2.0 + 1.0 / (run as f64 + 3.0);
        let summary = Summary {
            mean_pressure: 0.1,
            p_star: 0.02,
            area_fraction: 0.04,
            area_fraction_corrected: 0.039,
            kappa,
            kappa_corrected: 1.9,
            contact_nodes: 17,
            boundary_links: 9,
            mean_gap: 1.0,
            max_pressure: 2.0,
            mean_pressure_in_contact: 1.0,
            pressure_deviation_in_contact: 0.5,
            pressure_moment_2: 0.1,
            elastic_energy: 0.01,
        };
        let residual = Residual { complementarity: 1e-9, penetration: 0.0, negative_pressure: 0.0, load: 1e-16 };
        let load =
            Pressed { summary, approach: 0.3, residual, effort: Effort { iterations: 12, transform_pairs: 24.0 } };
        vec![load, Pressed { approach: 0.4, ..load }]
    }

    fn entry(run: usize) -> String {
        line(&Entry::new(run, &loads(run))).unwrap()
    }

    /// The content of a file as the system sees it, and its content after a loss of power.
    #[derive(Clone, Default)]
    struct Disk {
        seen: Vec<u8>,
        synced: Vec<u8>,
    }

    /// A file whose process is killed after `left` operations, in the middle of the next one if it is a write.
    #[derive(Clone)]
    struct Mortal {
        disk: Rc<RefCell<Disk>>,
        left: usize,
    }

    impl Mortal {
        fn spend(&mut self) -> io::Result<()> {
            self.left = self.left.checked_sub(1).ok_or_else(|| io::Error::other("killed"))?;
            Ok(())
        }
    }

    impl Storage for Mortal {
        fn read(&mut self) -> io::Result<Vec<u8>> {
            self.spend()?;
            Ok(self.disk.borrow().seen.clone())
        }

        fn cut(&mut self, length: usize) -> io::Result<()> {
            self.spend()?;
            self.disk.borrow_mut().seen.truncate(length);
            Ok(())
        }

        fn append(&mut self, text: &[u8]) -> io::Result<()> {
            let alive = self.spend();
            let written = if alive.is_ok() { text } else { &text[..text.len() / 2] };
            self.disk.borrow_mut().seen.extend(written);
            alive
        }

        fn sync(&mut self) -> io::Result<()> {
            self.spend()?;
            let mut disk = self.disk.borrow_mut();
            disk.synced = disk.seen.clone();
            Ok(())
        }
    }

    fn open(content: &[u8]) -> Result<(Lines<Mortal>, Finished), Unusable> {
        let disk = Disk { seen: content.to_vec(), synced: content.to_vec() };
        Lines::open(Mortal { disk: Rc::new(RefCell::new(disk)), left: usize::MAX }, &head(), SIZE)
    }

    #[test]
    fn a_kill_at_any_operation_loses_no_finished_run() {
        let torn = &entry(5)[..40];
        for content in [
            String::new(),
            first_line()[..20].into(),
            first_line(),
            first_line() + torn,
            first_line() + &entry(3) + &entry(1) + torn,
        ] {
            let mut left = 0;
            loop {
                let before = Disk { seen: content.clone().into(), synced: content.clone().into() };
                let disk = Rc::new(RefCell::new(before));
                let file = Mortal { disk: Rc::clone(&disk), left };
                // Runs 3 and 1 if the file had them before, then the runs whose recording succeeded.
                let mut kept: Vec<usize> = if content.contains("\"run\":3") { vec![1, 3] } else { Vec::new() };
                let mut complete = false;
                if let Ok((mut lines, finished)) = Lines::open(file, &head(), SIZE) {
                    assert_eq!(finished.keys().copied().collect::<Vec<_>>(), kept);
                    // Runs are computed in parallel, so a run may be recorded after another one failed.
                    let recorded = [4, 0, 2].map(|run| (run, lines.append(&entry(run)).is_ok()));
                    kept.extend(recorded.iter().filter(|(_, recorded)| *recorded).map(|(run, _)| run));
                    complete = recorded.iter().all(|(_, recorded)| *recorded);
                }
                let Disk { seen, synced } = disk.borrow().clone();
                // A loss of power may leave a part of the bytes that were not synced.
                let partly = synced.len().midpoint(seen.len()).min(seen.len());
                for found in [&seen[..], &synced, &seen[..partly]] {
                    let (mut lines, finished) = open(found).unwrap_or_else(|error| panic!("{left}: {error:?}"));
                    for run in &kept {
                        assert_eq!(finished.get(run), Some(&loads(*run)), "killed after {left}: run {run}");
                    }
                    // The sweep continues from this file.
                    let mut missing = (0..SIZE.runs).filter(|run| !finished.contains_key(run));
                    missing.try_for_each(|run| lines.append(&entry(run))).unwrap();
                    let whole = lines.file.disk.borrow().seen.clone();
                    assert_eq!(open(&whole).unwrap().1.len(), SIZE.runs);
                }
                if complete {
                    break;
                }
                left += 1;
            }
            assert!(left >= 7, "hardly anything was interrupted");
        }
    }

    #[test]
    fn only_the_last_line_may_be_short() {
        let refused = |lines: &[&str], number: usize, words: &[&str]| {
            let content = first_line() + &lines.concat();
            let Err(Unusable::Line { number: found, reason }) = open(content.as_bytes()) else {
                panic!("{lines:?} was read");
            };
            assert_eq!(found, number, "{reason}");
            assert!(words.iter().all(|word| reason.contains(word)), "{reason}");
        };
        let (zero, one) = (entry(0), entry(1));
        refused(&[&zero, &one[..50], "\n", &entry(2)], 3, &["column"]);
        refused(&[&zero, &one[..50], "\n"], 3, &["column"]);
        refused(&[&zero, "\n", &one], 3, &["not a finished run"]);
        let mut null: serde_json::Value = serde_json::from_str(&zero).unwrap();
        null["loads"][0]["summary"]["kappa"] = serde_json::Value::Null;
        let null = null.to_string() + "\n";
        refused(&[&null, &one], 2, &["null"]);
        refused(&[&zero.replace("\"run\":0", "\"run\":6")], 2, &["6", "0 to 5"]);
        refused(&[&one, &zero, &one], 4, &["run 1", "once"]);
        let short = line(&Entry::new(2, &loads(2)[..1])).unwrap();
        refused(&[&zero, &short], 3, &["1 loads", "2"]);
        assert_eq!(open((first_line() + &zero + &one[..one.len() - 1]).as_bytes()).unwrap().1.len(), 1);
    }

    #[test]
    fn another_file_is_left_as_it_is() {
        let other = line(&Head { version: "0".into(), ..head() }).unwrap();
        for content in ["a letter", "a letter\n", "{}\n", &other, &(other.clone() + &entry(0))] {
            let disk = Rc::new(RefCell::new(Disk { seen: content.into(), synced: content.into() }));
            let file = Mortal { disk: Rc::clone(&disk), left: usize::MAX };
            assert!(matches!(Lines::open(file, &head(), SIZE), Err(Unusable::Line { number: 1, .. })));
            assert_eq!(disk.borrow().seen, content.as_bytes());
        }
    }
}
