//! Shards of a sweep, for many independent processes.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fmt;
use std::str::FromStr;

use crate::Plan;

/// One of `count` shards of the runs of a sweep. Its text is K/M, such as 0/4 for the first of four.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    count: usize,
    index: usize,
}

/// Error: text that is not a shard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it must be K/M with whole numbers K from 0 to M - 1 and M from 1, such as 0/4")]
pub struct ShardError;

impl Shard {
    /// Returns shard `index`, from 0, of `count`; `None` if it does not exist.
    pub fn new(index: usize, count: usize) -> Option<Self> {
        (index < count).then_some(Self { count, index })
    }

    /// Returns the number of the shard, from 0.
    pub fn index(self) -> usize {
        self.index
    }

    /// Returns the number of shards.
    pub fn count(self) -> usize {
        self.count
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let number = |text: &str| text.parse::<usize>().ok().filter(|_| text.bytes().all(|byte| byte.is_ascii_digit()));
        let (index, count) = text.split_once('/').ok_or(ShardError)?;
        number(index).zip(number(count)).and_then(|(index, count)| Self::new(index, count)).ok_or(ShardError)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// Returns the shard number, from 0, of each piece of `work` for `count` shards. Each piece belongs to one shard. The
/// shards have about equal work: pieces are assigned in order of decreasing work, each to the shard with the least work
/// so far. With fewer pieces than shards, some shards have none.
pub fn divide(work: &[u64], count: usize) -> Vec<usize> {
    let mut dearest: Vec<usize> = (0..work.len()).collect();
    dearest.sort_by_key(|piece| (Reverse(work[*piece]), *piece));
    // The first pieces go to one shard each, so only as many shards as there are pieces take part.
    let some = count.min(dearest.len());
    let mut least: BinaryHeap<Reverse<(u64, usize)>> = (0..some).map(|index| Reverse((0, index))).collect();
    let mut shards = vec![0; dearest.len()];
    for piece in dearest {
        let Some(Reverse((sum, index))) = least.pop() else { break };
        least.push(Reverse((sum.saturating_add(work[piece].max(1)), index)));
        shards[piece] = index;
    }
    shards
}

impl Plan {
    /// Returns the shard number, from 0, of each run for `count` shards ([`divide`]), by the expected work of the runs.
    pub fn shards(&self, count: usize) -> Vec<usize> {
        // Whole numbers, since the last bits of a logarithm differ between machines.
        let work: Vec<u64> = self.points.iter().map(|point| (self.work(point) * 1e6).round() as u64).collect();
        divide(&self.runs.iter().map(|run| work[run.point]).collect::<Vec<_>>(), count)
    }

    /// Returns the indices of the runs of a shard, ascending.
    pub fn runs_of_shard(&self, shard: Shard) -> Vec<usize> {
        let shards = self.shards(shard.count).into_iter().enumerate();
        shards.filter(|(_, index)| *index == shard.index).map(|(run, _)| run).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    fn shards(count: usize) -> Vec<Shard> {
        (0..count).filter_map(|index| Shard::new(index, count)).collect()
    }

    #[test]
    fn every_run_belongs_to_one_shard() {
        let plan = Plan::new(Preset::Smoke.config()).unwrap();
        for count in [1, 2, 5, 31, plan.runs.len(), plan.runs.len() + 7] {
            let mut all: Vec<usize> = shards(count).into_iter().flat_map(|shard| plan.runs_of_shard(shard)).collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..plan.runs.len()), "{count}");
        }
        assert_eq!(plan.runs_of_shard(Shard::new(0, 1).unwrap()), (0..plan.runs.len()).collect::<Vec<_>>());
        assert_eq!(plan.runs_of_shard(Shard::new(usize::MAX - 1, usize::MAX).unwrap()), []);
    }

    #[test]
    fn shards_are_about_equally_dear() {
        for (preset, count, most) in
            [(Preset::Default, 16, 1.03), (Preset::Default, 64, 1.15), (Preset::Prodanov, 31, 1.15)]
        {
            let plan = Plan::new(preset.config()).unwrap();
            let work = |run: &usize| plan.work(&plan.points[plan.runs[*run].point]);
            let sums: Vec<f64> =
                shards(count).into_iter().map(|shard| plan.runs_of_shard(shard).iter().map(work).sum()).collect();
            let mean = sums.iter().sum::<f64>() / count as f64;
            // A run is not divided.
            let run = (0..plan.runs.len()).map(|run| work(&run)).fold(0.0, f64::max);
            let worst = sums.iter().copied().fold(0.0, f64::max);
            assert!(worst <= (most * mean).max(run), "{preset:?} in {count} shards: {}", worst / mean);
        }
    }

    #[test]
    fn only_shards_are_read() {
        assert_eq!("3/64".parse(), Ok(Shard { index: 3, count: 64 }));
        assert_eq!("3/64".parse::<Shard>().unwrap().to_string(), "3/64");
        for text in ["", "/", "3", "4/4", "0/0", "-1/4", "+1/4", "1/4/2", "1 / 4", "a/b", "0/99999999999999999999"] {
            assert_eq!(text.parse::<Shard>(), Err(ShardError), "{text}");
        }
    }
}
