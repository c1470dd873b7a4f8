//! The journals of the shards of a sweep, beside its output: `OUT.shard-K-of-M.journal`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use gfmd_files::{Output, Reader, folder};
use gfmd_problem::key;
use gfmd_sweep::{Plan, Shard};
use rayon::prelude::*;

use super::check;
use super::journal::{Finished, Journal, Size};
use gfmd_input::failure::Failure;
use gfmd_input::session::GIT_COMMIT;

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

/// The finished runs of a sweep in all the journals of its shards.
pub(super) struct Gathered {
    pub(super) finished: Finished,
    out: PathBuf,
    /// The shards that left a file, with the length of their journal when it was read.
    shards: BTreeMap<Shard, Option<(PathBuf, u64)>>,
}

impl Gathered {
    /// Reads all journals beside `out`. Of a run that several journals have, the first one counts: few shards before
    /// many, and then in their order. With `claim`, a shard that is being computed is an error; without it, its runs so
    /// far count.
    ///
    /// # Errors
    /// A journal of another sweep, or an unusable record; a shard that is being computed.
    pub(super) fn read(out: &Path, config: &str, size: Size, claim: bool) -> Result<Self, Failure> {
        let read = |(shard, journal): (Shard, Option<PathBuf>)| {
            let claimed = claim.then(|| Output::claim_beside(out, &suffix(shard))).transpose();
            let _claimed = claimed.map_err(|error| Failure::input(key("merge"), error))?;
            let Some(path) = journal else { return Ok((shard, None, Finished::new())) };
            let length = length(&path);
            let runs = Journal::look(&path, config, size)?;
            Ok((shard, Some((path, length)), runs))
        };
        let all: Vec<Result<_, Failure>> =
            find(out)?.into_iter().collect::<Vec<_>>().into_par_iter().map(read).collect();
        let mut gathered = Self { finished: Finished::new(), out: out.into(), shards: BTreeMap::new() };
        for one in all {
            let (shard, journal, runs) = one?;
            for (run, loads) in runs {
                gathered.finished.entry(run).or_insert(loads);
            }
            gathered.shards.insert(shard, journal);
        }
        Ok(gathered)
    }

    /// The number of journals.
    pub(super) fn journals(&self) -> usize {
        self.shards.values().flatten().count()
    }

    /// Returns the shards that lack a run of `missing`; none if the journals come from sweeps of different numbers of
    /// shards, or if there are no journals.
    pub(super) fn lacking(&self, plan: &Plan, missing: &[usize]) -> Vec<Shard> {
        let counts: BTreeSet<usize> = self.shards.keys().map(|shard| shard.count()).collect();
        let Some(count) = counts.first().copied().filter(|_| counts.len() == 1) else { return Vec::new() };
        let shards = plan.shards(count);
        let lacking: BTreeSet<usize> = missing.iter().map(|run| shards[*run]).collect();
        lacking.into_iter().filter_map(|index| Shard::new(index, count)).collect()
    }

    /// Removes the journals: their runs are stored. One that has more runs now, or that a process writes to, stays.
    pub(super) fn remove(self) {
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

/// The runs of the output itself, if it is the whole result of this sweep by this program: a merge that was killed
/// after the file was written, and that is started again, has nothing to compute.
pub(super) fn stored(out: &Path, config: &str, plan: &Plan) -> Option<Finished> {
    let reader = Reader::open(out).ok()?;
    let same = |name: &str, value: &str| reader.text("/", name).is_ok_and(|text| text == value);
    let ours = same("config", config) && same("version", env!("CARGO_PKG_VERSION")) && same("git_commit", GIT_COMMIT);
    drop(reader);
    if !ours {
        return None;
    }
    Some(check::earlier(out, plan).ok()?.into_iter().enumerate().collect())
}
