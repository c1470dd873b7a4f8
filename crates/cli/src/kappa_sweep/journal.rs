//! The journal of a running sweep: one record of JSON for each finished run, on the disk before the run counts as
//! finished.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry as Slot;
use std::path::Path;

use gfmd_files::Journal as Records;
use gfmd_problem::{key, words};
use gfmd_sweep::Pressed;
use serde::{Deserialize, Serialize};

use gfmd_input::failure::Failure;
use gfmd_input::json;

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
    loads: Vec<Pressed>,
}

/// Number of runs of the sweep and of loads of each run.
#[derive(Clone, Copy)]
pub(super) struct Size {
    pub(super) runs: usize,
    pub(super) loads: usize,
}

/// A journal open for writing.
pub(super) struct Journal(Records);

impl Journal {
    /// Starts a journal, or continues an existing one.
    ///
    /// # Errors
    /// A journal that exists although `resume` is false, that belongs to another sweep, or that has an unusable record;
    /// a file that cannot be read or written.
    pub(super) fn open(path: &Path, config: &str, size: Size, resume: bool) -> Result<(Self, Finished), Failure> {
        if path.exists() && !resume {
            let exists = "the journal of an unfinished sweep exists; continue it with ";
            let why = words![exists, key("resume"), ", or delete it"];
            return Err(Failure::because(path.display().to_string(), why));
        }
        let records = Records::open(path, head(config)?.as_bytes())?;
        let finished = runs(&records, size)?;
        if !finished.is_empty() {
            tracing::info!("finished parts taken over: {} of {}", finished.len(), size.runs);
        }
        Ok((Self(records), finished))
    }

    /// The finished runs of a journal, which is left as it is.
    ///
    /// # Errors
    /// A journal that belongs to another sweep, or that has an unusable record; a file that cannot be read.
    pub(super) fn look(path: &Path, config: &str, size: Size) -> Result<Finished, Failure> {
        runs(&Records::look(path, head(config)?.as_bytes())?, size)
    }

    /// Records a finished run.
    ///
    /// # Errors
    /// A number that is not finite, which could not be read again; a file that cannot be written.
    pub(super) fn record(&self, run: usize, loads: &[Pressed]) -> Result<(), Failure> {
        let text = json::to_string(&Entry { run, loads: loads.to_vec() })
            .map_err(|error| Failure::computation(error.to_string()))?;
        if text.contains("null") {
            return Err(Failure::computation(format!("run {run} has a number that is not finite: {text}")));
        }
        Ok(self.0.append(&[text])?)
    }

    /// The path of the file.
    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }

    /// Removes the file: the sweep is complete and stored.
    pub(super) fn remove(self) {
        if let Err(error) = self.0.remove() {
            tracing::info!("{error}");
        }
    }
}

/// The head of the journals of a sweep.
fn head(config: &str) -> Result<String, Failure> {
    let head = Head { version: env!("CARGO_PKG_VERSION").into(), config: config.into() };
    json::to_string(&head).map_err(|error| Failure::computation(error.to_string()))
}

/// The runs of a journal.
fn runs(records: &Records, size: Size) -> Result<Finished, Failure> {
    let mut finished = Finished::new();
    for index in 0..records.len() {
        let refuse = |reason: String| Failure::from(records.unusable(index, reason));
        let Entry { run, loads } = serde_json::from_slice(&records.read(index)?)
            .map_err(|error| refuse(format!("this is not a finished run of a sweep: {error}")))?;
        if run >= size.runs {
            return Err(refuse(format!("the run is {run}; it must be from 0 to {}", size.runs - 1)));
        }
        if loads.len() != size.loads {
            return Err(refuse(format!("the run has {} loads; it must have {}", loads.len(), size.loads)));
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
    use gfmd_contact::{Effort, Residual};
    use gfmd_measure::Summary;

    use super::*;

    const SIZE: Size = Size { runs: 6, loads: 2 };
    const CONFIG: &str = "[surface]\nhurst = [0.8]\n";

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

    #[test]
    fn runs_are_read_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.h5.journal");
        let (journal, finished) = Journal::open(&path, CONFIG, SIZE, false).unwrap();
        assert!(finished.is_empty());
        [3, 0, 5].into_iter().try_for_each(|run| journal.record(run, &loads(run))).unwrap();
        let refused = Journal::open(&path, CONFIG, SIZE, false).err().unwrap();
        assert!(refused.to_string().contains("--resume"), "{refused}");
        let (journal, finished) = Journal::open(&path, CONFIG, SIZE, true).unwrap();
        assert_eq!(finished, [0, 3, 5].map(|run| (run, loads(run))).into());
        let mut bad = loads(1);
        bad[1].approach = f64::NAN;
        assert!(journal.record(1, &bad).unwrap_err().to_string().contains("not finite"));
        let other = Journal::open(&path, "[surface]\nhurst = [0.7]\n", SIZE, true).err().unwrap();
        assert!(other.status() == 2 && other.to_string().contains("another configuration"), "{other}");
        journal.remove();
        assert!(!path.exists());
    }

    #[test]
    fn a_record_that_is_no_run_of_the_sweep_is_named() {
        let entry = |run: usize, loads: &[Pressed]| json::to_string(&Entry { run, loads: loads.to_vec() }).unwrap();
        let mut null: serde_json::Value = serde_json::from_str(&entry(0, &loads(0))).unwrap();
        null["loads"][0]["summary"]["kappa"] = serde_json::Value::Null;
        for (bad, words) in [
            (entry(6, &loads(0)), ["6", "0 to 5"]),
            (entry(2, &loads(2)[..1]), ["1 loads", "2"]),
            (entry(1, &loads(1)), ["run 1", "once"]),
            (null.to_string(), ["not a finished run", "null"]),
            (entry(0, &loads(0))[..50].into(), ["not a finished run", "column"]),
            (String::new(), ["not a finished run", "EOF"]),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("s.h5.journal");
            let (journal, _) = Journal::open(&path, CONFIG, SIZE, false).unwrap();
            journal.record(1, &loads(1)).unwrap();
            journal.0.append(&[&bad]).unwrap();
            let before = std::fs::read(&path).unwrap();
            let refused = Journal::open(&path, CONFIG, SIZE, true).err().unwrap();
            let text = refused.to_string();
            assert!(refused.status() == 2 && text.contains("s.h5.journal, record 3: "), "{text}");
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
            assert_eq!(std::fs::read(&path).unwrap(), before);
        }
    }
}
