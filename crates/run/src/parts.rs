//! Long work in independent parts, such as the runs of a sweep: finished parts in a journal, shards for many processes,
//! and their merge.

mod journal;
mod shards;

use std::path::Path;

use gfmd_files::{FileError, Output};
use gfmd_input::failure::Failure;
use gfmd_problem::{Words, key, words};
use gfmd_sweep::Shard;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::resume::check_finished;

pub use journal::{Finished, Journal};
pub use shards::Gathered;

/// Reason why a part cannot belong to a work; `None` if it can.
type Refuse<T> = Box<dyn Fn(&T) -> Option<String> + Send + Sync>;

/// Work in parts with results `T`.
pub struct Work<T> {
    /// Name of the work in messages, such as "sweep".
    pub name: &'static str,
    /// Configuration, which identifies the work.
    pub config: String,
    /// Number of parts.
    pub parts: usize,
    /// Returns the reason why a part cannot belong to this work.
    pub refuse: Refuse<T>,
}

/// Finished parts found for a merge.
pub struct Merge<T> {
    /// Finished parts.
    pub finished: Finished<T>,
    /// Parts that are missing, ascending.
    pub open: Vec<usize>,
    /// Journals of the shards.
    pub gathered: Gathered<T>,
}

impl<T: Serialize + DeserializeOwned + Send> Work<T> {
    /// Returns the parts that are not finished, ascending.
    pub fn missing(&self, finished: &Finished<T>) -> Vec<usize> {
        (0..self.parts).filter(|part| !finished.contains_key(part)).collect()
    }

    /// Checks that work that continues none, although `resume` is true, does not replace the finished result of
    /// another configuration. Only lines of the configuration that `counts` are compared.
    ///
    /// # Errors
    /// Returns an error if it would.
    pub fn check_finished(&self, output: &Output, resume: bool, counts: fn(&&str) -> bool) -> Result<(), Failure> {
        if !resume || output.beside(JOURNAL).exists() {
            return Ok(());
        }
        check_finished(output, |config| config.lines().filter(&counts).eq(self.config.lines().filter(&counts)))
    }

    /// Takes the parts from all journals beside a claimed output, and from the output itself if parts are missing
    /// (`stored`). `divide` returns the shard of each part for a number of shards.
    ///
    /// # Errors
    /// Returns an error for a journal of other work or with an unusable record, and for a shard that is being computed.
    pub fn merge(
        &self,
        output: &Output,
        divide: impl FnOnce(usize) -> Vec<usize>,
        stored: impl FnOnce() -> Option<Finished<T>>,
    ) -> Result<Merge<T>, Failure> {
        let path = output.beside(JOURNAL);
        let mut gathered = Gathered::read(output.path(), self, true)?;
        let mut finished = std::mem::take(&mut gathered.finished);
        if path.exists() {
            finished.extend(Journal::look(&path, self)?);
        }
        let mut open = self.missing(&finished);
        if !open.is_empty() {
            finished.extend(stored().unwrap_or_default());
            open = self.missing(&finished);
        }
        let (found, parts, journals) = (finished.len(), self.parts, gathered.journals());
        let lacking: Vec<String> = gathered.lacking(divide, &open).iter().map(ToString::to_string).collect();
        let of_shards = if lacking.is_empty() { String::new() } else { format!(", those of {}", lacking.join(", ")) };
        tracing::info!(
            "{found} of {parts} runs are in {journals} journals; {} are computed now{of_shards}",
            open.len()
        );
        Ok(Merge { finished, open, gathered })
    }
}

/// Ending of the name of a journal.
const JOURNAL: &str = ".journal";

/// Claims an output, beside which there can be a journal.
///
/// # Errors
/// Returns an error if the output cannot be claimed, or if its name is too long for a journal.
pub fn claim(out: &Path) -> Result<Output, Failure> {
    named(Output::claim(out))
}

/// Claims the place of a shard beside an output.
///
/// # Errors
/// Returns an error as [`claim`].
pub fn claim_shard(out: &Path, shard: Shard) -> Result<Output, Failure> {
    named(Output::claim_beside(out, &shards::suffix(shard)))
}

fn named(claimed: Result<Output, FileError>) -> Result<Output, Failure> {
    let output = claimed.and_then(|output| output.check_beside(&[JOURNAL]).map(|()| output));
    output.map_err(|error| Failure::input(key("out"), error))
}

/// Returns the remark on a failure: the place of the parts, unless their journal was removed.
pub fn remark(parts: &str, journal: &Path, place: Words) -> Words {
    match journal.exists() {
        true => words![format!("; {parts} are in "), place],
        false => format!("; the journal {} is gone, and with it the {parts}", journal.display()).into(),
    }
}

/// Returns the remark that a run with the journal at this path can be continued.
pub fn resumes(journal: &Path) -> Words {
    words![journal.display().to_string(), ", ", key("resume"), " continues"]
}

/// Returns the remark that a merge into this output can be continued.
pub fn merges(output: &Output) -> Words {
    words![format!("the journals beside {}, ", output.path().display()), key("merge"), " continues"]
}
