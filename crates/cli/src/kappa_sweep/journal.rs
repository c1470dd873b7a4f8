//! The journal of a running sweep: one line of JSON for each finished run, on the disk before the next one starts.
//!
//! The first line says which sweep it is. A line cut short by a kill is dropped when the sweep is resumed; its run is
//! computed again, to the same bits.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::load::LoadRecord;

#[derive(Serialize, Deserialize, PartialEq)]
struct Head {
    version: String,
    config: String,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    run: usize,
    loads: Vec<LoadRecord>,
}

/// A journal open for writing.
pub(super) struct Journal {
    path: PathBuf,
    file: Mutex<File>,
}

/// Finished runs by index.
pub(super) type Finished = BTreeMap<usize, Vec<LoadRecord>>;

impl Journal {
    /// Starts a journal, or continues the one that is there.
    ///
    /// # Errors
    /// A journal that is there although `resume` is false, or that belongs to another sweep; a file that cannot be
    /// written.
    pub(super) fn open(path: &Path, config: &str, resume: bool) -> Result<(Self, Finished), Failure> {
        let head = Head { version: env!("CARGO_PKG_VERSION").into(), config: config.into() };
        let name = path.display();
        let failed = |error: std::io::Error| Failure::Computation(format!("cannot write {name}: {error}"));
        let mut finished = Finished::new();
        if path.exists() {
            if !resume {
                let reason = "an unfinished sweep is there: continue it with --resume, or delete that file";
                return Err(Failure::input(&name.to_string(), reason));
            }
            finished = read(path, &head)?;
        }
        // Written anew rather than appended to: an interrupted last line would swallow the next one.
        let mut file = OpenOptions::new().write(true).create(true).truncate(true).open(path).map_err(failed)?;
        let mut text = line(&head)?;
        for (&run, loads) in &finished {
            text += &line(&Entry { run, loads: loads.clone() })?;
        }
        file.write_all(text.as_bytes()).and_then(|()| file.sync_data()).map_err(failed)?;
        Ok((Self { path: path.into(), file: Mutex::new(file) }, finished))
    }

    /// Records a finished run.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn record(&self, run: usize, loads: &[LoadRecord]) -> Result<(), Failure> {
        let text = line(&Entry { run, loads: loads.to_vec() })?;
        let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        file.write_all(text.as_bytes())
            .and_then(|()| file.sync_data())
            .map_err(|error| Failure::Computation(format!("cannot write {}: {error}", self.path.display())))
    }

    /// Where it is.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Removes it: the sweep is complete and stored.
    pub(super) fn remove(self) {
        if let Err(error) = std::fs::remove_file(&self.path) {
            tracing::warn!("cannot remove {}: {error}", self.path.display());
        }
    }
}

fn line(value: &impl Serialize) -> Result<String, Failure> {
    crate::json::to_string(value)
        .map(|text| text + "\n")
        .map_err(|error| Failure::Computation(format!("cannot record a run: {error}")))
}

fn read(path: &Path, expected: &Head) -> Result<Finished, Failure> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| Failure::input(&name, error))?;
    let mut lines = BufReader::new(file).lines().map_while(Result::ok);
    let Some(first) = lines.next() else { return Ok(Finished::new()) };
    let head: Head =
        serde_json::from_str(&first).map_err(|_| Failure::input(&name, "this is not the journal of a sweep"))?;
    if head != *expected {
        let reason = "it belongs to a sweep of another configuration or version: finish that one, or delete the file";
        return Err(Failure::input(&name, reason));
    }
    Ok(lines
        .map_while(|line| serde_json::from_str::<Entry>(&line).ok())
        .map(|entry| (entry.run, entry.loads))
        .collect())
}
