//! The journal of work in parts: one record of JSON for each finished part, on the disk before the part counts as
//! finished.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry as Slot;
use std::path::Path;

use gfmd_files::Journal as Records;
use gfmd_input::failure::Failure;
use gfmd_input::json;
use gfmd_problem::{key, words};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::Work;

/// Finished parts by number.
pub type Finished<T> = BTreeMap<usize, T>;

/// Work that a journal belongs to.
#[derive(Serialize, Deserialize, PartialEq)]
struct Head {
    version: String,
    config: String,
}

#[derive(Serialize, Deserialize)]
struct Entry<T> {
    run: usize,
    loads: T,
}

/// Journal open for writing.
pub struct Journal(Records);

impl Journal {
    /// Starts a journal, or continues an existing one.
    ///
    /// # Errors
    /// Returns an error for a journal that exists although `resume` is false, that belongs to other work, or that has
    /// an unusable record; for a file that cannot be read or written.
    pub fn open<T: Serialize + DeserializeOwned>(
        path: &Path,
        work: &Work<T>,
        resume: bool,
    ) -> Result<(Self, Finished<T>), Failure> {
        if path.exists() && !resume {
            let exists = format!("the journal of an unfinished {} exists; continue it with ", work.name);
            let why = words![exists, key("resume"), ", or delete it"];
            return Err(Failure::because(path.display().to_string(), why));
        }
        let records = Records::open(path, head(&work.config)?.as_bytes())?;
        let finished = parts(&records, work)?;
        if !finished.is_empty() {
            tracing::info!("finished parts taken over: {} of {}", finished.len(), work.parts);
        }
        Ok((Self(records), finished))
    }

    /// Returns the finished parts of a journal, which is left as it is.
    ///
    /// # Errors
    /// Returns an error for a journal that belongs to other work or has an unusable record, or that cannot be read.
    pub fn look<T: Serialize + DeserializeOwned>(path: &Path, work: &Work<T>) -> Result<Finished<T>, Failure> {
        parts(&Records::look(path, head(&work.config)?.as_bytes())?, work)
    }

    /// Records a finished part.
    ///
    /// # Errors
    /// Returns an error for a number that is not finite, which could not be read again; for a file that cannot be
    /// written.
    pub fn record<T: Serialize + DeserializeOwned>(&self, part: usize, result: &T) -> Result<(), Failure> {
        let text = json::to_string(&Entry { run: part, loads: result })
            .map_err(|error| Failure::computation(error.to_string()))?;
        if serde_json::from_str::<Entry<T>>(&text).is_err() {
            return Err(Failure::computation(format!("run {part} has a number that is not finite: {text}")));
        }
        Ok(self.0.append(&[text])?)
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Removes the file: the work is complete and stored.
    pub fn remove(self) {
        if let Err(error) = self.0.remove() {
            tracing::info!("{error}");
        }
    }
}

/// Returns the head of the journals of a configuration.
fn head(config: &str) -> Result<String, Failure> {
    let head = Head { version: env!("CARGO_PKG_VERSION").into(), config: config.into() };
    json::to_string(&head).map_err(|error| Failure::computation(error.to_string()))
}

/// Reads the parts of a journal.
fn parts<T: DeserializeOwned>(records: &Records, work: &Work<T>) -> Result<Finished<T>, Failure> {
    let mut finished = Finished::new();
    for index in 0..records.len() {
        let refuse = |reason: String| Failure::from(records.unusable(index, reason));
        let Entry { run, loads } = serde_json::from_slice(&records.read(index)?)
            .map_err(|error| refuse(format!("this is not a finished run of a {}: {error}", work.name)))?;
        if run >= work.parts {
            return Err(refuse(format!("the run is {run}; it must be from 0 to {}", work.parts - 1)));
        }
        if let Some(reason) = (work.refuse)(&loads) {
            return Err(refuse(reason));
        }
        match finished.entry(run) {
            Slot::Occupied(_) => {
                return Err(refuse(format!("run {run} is in an earlier record; it must be in the journal once")));
            }
            Slot::Vacant(slot) => {
                slot.insert(loads);
            }
        }
    }
    Ok(finished)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: &str = "[surface]\nhurst = [0.8]\n";

    fn work(config: &str) -> Work<Vec<f64>> {
        let refuse =
            |loads: &Vec<f64>| (loads.len() != 2).then(|| format!("the run has {} loads; it must have 2", loads.len()));
        Work { name: "sweep", config: config.into(), parts: 6, refuse: Box::new(refuse) }
    }

    fn loads(run: usize) -> Vec<f64> {
        vec![2.0 + 1.0 / (run as f64 + 3.0), 1e-300 / 3.0]
    }

    #[test]
    fn parts_are_read_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.h5.journal");
        let (journal, finished) = Journal::open(&path, &work(CONFIG), false).unwrap();
        assert!(finished.is_empty());
        [3, 0, 5].into_iter().try_for_each(|run| journal.record(run, &loads(run))).unwrap();
        let refused = Journal::open(&path, &work(CONFIG), false).err().unwrap();
        assert!(refused.to_string().contains("--resume"), "{refused}");
        let (journal, finished) = Journal::open(&path, &work(CONFIG), true).unwrap();
        assert_eq!(finished, [0, 3, 5].map(|run| (run, loads(run))).into());
        assert!(journal.record(1, &vec![1.0, f64::NAN]).unwrap_err().to_string().contains("not finite"));
        let other = Journal::open(&path, &work("[surface]\nhurst = [0.7]\n"), true).err().unwrap();
        assert!(other.status() == 2 && other.to_string().contains("another configuration"), "{other}");
        journal.remove();
        assert!(!path.exists());
    }

    #[test]
    fn a_record_that_is_no_part_of_the_work_is_named() {
        let entry = |run: usize, loads: &[f64]| json::to_string(&Entry { run, loads }).unwrap();
        for (bad, words) in [
            (entry(6, &loads(0)), ["6", "0 to 5"]),
            (entry(2, &loads(2)[..1]), ["1 loads", "2"]),
            (entry(1, &loads(1)), ["run 1", "once"]),
            (entry(0, &[1.0, f64::NAN]), ["not a finished run", "null"]),
            (entry(0, &loads(0))[..30].into(), ["not a finished run", "column"]),
            (String::new(), ["not a finished run", "EOF"]),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("s.h5.journal");
            let (journal, _) = Journal::open(&path, &work(CONFIG), false).unwrap();
            journal.record(1, &loads(1)).unwrap();
            journal.0.append(&[&bad]).unwrap();
            let before = std::fs::read(&path).unwrap();
            let refused = Journal::open(&path, &work(CONFIG), true).err().unwrap();
            let text = refused.to_string();
            assert!(refused.status() == 2 && text.contains("s.h5.journal, record 3: "), "{text}");
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
            assert_eq!(std::fs::read(&path).unwrap(), before);
        }
    }
}
