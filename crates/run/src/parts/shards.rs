//! The journals of shards beside an output: `OUT.shard-K-of-M.journal`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use gfmd_files::{Output, folder};
use gfmd_input::failure::Failure;
use gfmd_problem::key;
use gfmd_sweep::Shard;
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::Work;
use super::journal::{Finished, Journal};

/// Returns the part of a journal's name between the name of the output and the ending.
pub(super) fn suffix(shard: Shard) -> String {
    format!(".shard-{}-of-{}", shard.index(), shard.count())
}

/// Finds the shards that left a file beside an output, with their journals; sweeps of few shards first.
fn find(out: &Path) -> Result<BTreeMap<Shard, Option<PathBuf>>, Failure> {
    let name = out.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let failed =
        |error: std::io::Error| Failure::computation(format!("cannot read {}: {error}", folder(out).display()));
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder(out)).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let stem = ["journal", "lock"].into_iter().find_map(|ending| file.strip_suffix(&format!(".{ending}")));
        let numbers = stem.and_then(|stem| stem.strip_prefix(&name)?.strip_prefix(".shard-")?.split_once("-of-"));
        let Some(shard) = numbers.and_then(|(index, count)| format!("{index}/{count}").parse::<Shard>().ok()) else {
            continue;
        };
        if stem != Some(&format!("{name}{}", suffix(shard))) {
            continue;
        }
        let journal = found.entry(shard).or_insert(None);
        if file.ends_with(".journal") {
            *journal = Some(path);
        }
    }
    Ok(found)
}

/// Finished parts in the journals of all shards.
pub struct Gathered<T> {
    /// Finished parts.
    pub finished: Finished<T>,
    out: PathBuf,
    /// The shards that left a file, with the length of their journal when it was read.
    shards: BTreeMap<Shard, Option<(PathBuf, u64)>>,
}

impl<T: Serialize + DeserializeOwned + Send> Gathered<T> {
    /// Reads all journals beside `out`. Of a part that several journals have, the first one counts: few shards before
    /// many, and then in their order. With `claim`, a shard that is being computed is an error; without it, its parts
    /// so far count.
    ///
    /// # Errors
    /// Returns an error for a journal of other work, an unusable record, or a shard that is being computed.
    pub fn read(out: &Path, work: &Work<T>, claim: bool) -> Result<Self, Failure> {
        let read = |(shard, journal): (Shard, Option<PathBuf>)| {
            let claimed = claim.then(|| Output::claim_beside(out, &suffix(shard))).transpose();
            let _claimed = claimed.map_err(|error| Failure::input(key("merge"), error))?;
            let Some(path) = journal else { return Ok((shard, None, Finished::new())) };
            let length = length(&path);
            let parts = Journal::look(&path, work)?;
            Ok((shard, Some((path, length)), parts))
        };
        let all: Vec<Result<_, Failure>> =
            find(out)?.into_iter().collect::<Vec<_>>().into_par_iter().map(read).collect();
        let mut gathered = Self { finished: Finished::new(), out: out.into(), shards: BTreeMap::new() };
        for one in all {
            let (shard, journal, parts) = one?;
            for (part, result) in parts {
                gathered.finished.entry(part).or_insert(result);
            }
            gathered.shards.insert(shard, journal);
        }
        Ok(gathered)
    }

    /// Returns the number of journals.
    pub fn journals(&self) -> usize {
        self.shards.values().flatten().count()
    }

    /// Returns the shards that lack a part of `missing`; none if the journals come from different numbers of shards, or
    /// if there are no journals. `divide` returns the shard of each part for a number of shards.
    pub(super) fn lacking(&self, divide: impl FnOnce(usize) -> Vec<usize>, missing: &[usize]) -> Vec<Shard> {
        let counts: BTreeSet<usize> = self.shards.keys().map(|shard| shard.count()).collect();
        let Some(count) = counts.first().copied().filter(|_| counts.len() == 1) else { return Vec::new() };
        let shards = divide(count);
        let lacking: BTreeSet<usize> = missing.iter().map(|part| shards[*part]).collect();
        lacking.into_iter().filter_map(|index| Shard::new(index, count)).collect()
    }

    /// Removes the journals: their parts are stored. One that has more parts now, or that a process writes to, stays.
    pub fn remove(self) {
        for (shard, journal) in self.shards {
            let Ok(_claimed) = Output::claim_beside(&self.out, &suffix(shard)) else { continue };
            let Some((path, read)) = journal else { continue };
            if length(&path) != read {
                tracing::info!("{} has grown, and stays", path.display());
            } else if let Err(error) = std::fs::remove_file(&path) {
                tracing::info!("cannot remove {}: {error}", path.display());
            }
        }
    }
}

fn length(path: &Path) -> u64 {
    path.metadata().map_or(0, |metadata| metadata.len())
}
