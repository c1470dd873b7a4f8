//! Rows that travel between the first process, which reads and writes files, and the processes that own them.

use std::ops::Range;

use super::Share;
use crate::{Letters, Parcel, Word};

impl Share {
    /// Hands the field of which each rank has its `own` rows, of `columns` values each, to the first rank: there `take` gets blocks
    /// of `height` rows in order, with the numbers of the rows. The others only send.
    ///
    /// # Panics
    /// If `own` is not made of the own rows, or the height is zero.
    pub fn to_first(&self, own: &[f64], columns: usize, height: usize, mut take: impl FnMut(Range<usize>, &[f64])) {
        let rows = self.rows();
        assert_eq!(own.len(), rows.len() * columns, "a field has the own rows");
        let mut letters = Letters::default();
        for block in self.blocks(height) {
            if self.is_whole() {
                take(block.clone(), &own[block.start * columns..block.end * columns]);
                continue;
            }
            let mine = overlap(&block, &rows);
            let sent = &own[(mine.start - rows.start) * columns..(mine.end - rows.start) * columns];
            letters.out.resize(sent.len(), 0);
            f64::pack(sent, &mut letters.out);
            letters.out_lengths = self.words_of(|rank| if rank == 0 { sent.len() } else { 0 });
            let is_first = self.ranks.rank() == 0;
            letters.into_lengths =
                self.words_of(|rank| if is_first { overlap(&block, &self.rows[rank]).len() * columns } else { 0 });
            letters.into.resize(letters.into_lengths.iter().sum(), 0);
            letters = self.ranks.post(letters).wait();
            if is_first {
                let mut values = vec![0.0; letters.into.len()];
                f64::unpack(&letters.into, &mut values);
                take(block, &values);
            }
        }
    }

    /// The own rows of a field, of `columns` values each, of which the first rank has the `whole`; they travel in blocks of `height`
    /// rows. What the others give is not looked at.
    ///
    /// # Panics
    /// If the field of the first rank does not have all rows, or the height is zero.
    pub fn from_first(&self, whole: &[f64], columns: usize, height: usize) -> Vec<f64> {
        let (rows, is_first) = (self.rows(), self.ranks.rank() == 0);
        let all = self.rows.last().map_or(0, |rows| rows.end);
        assert!(!is_first || whole.len() == all * columns, "the first rank has all rows");
        if self.is_whole() {
            return whole.to_vec();
        }
        let mut own = Vec::with_capacity(rows.len() * columns);
        let mut letters = Letters::default();
        for block in self.blocks(height) {
            let sent = if is_first { &whole[block.start * columns..block.end * columns] } else { &[] };
            letters.out.resize(sent.len(), 0);
            f64::pack(sent, &mut letters.out);
            letters.out_lengths =
                self.words_of(|rank| if is_first { overlap(&block, &self.rows[rank]).len() * columns } else { 0 });
            let mine = overlap(&block, &rows).len() * columns;
            letters.into_lengths = self.words_of(|rank| if rank == 0 { mine } else { 0 });
            letters.into.resize(mine, 0);
            letters = self.ranks.post(letters).wait();
            let start = own.len();
            own.resize(start + mine, 0.0);
            f64::unpack(&letters.into, &mut own[start..]);
        }
        own
    }

    /// The first value that a rank gives, in the order of the ranks; all get it.
    pub fn first<P: Parcel>(&self, own: Option<P>) -> Option<P> {
        let mut words = vec![0; P::WORDS + 1];
        if let Some(value) = &own {
            words[0] = 1;
            value.put(&mut words[1..]);
        }
        let mut all = vec![0; words.len() * self.rows.len()];
        self.ranks.gather(&words, &mut all, &vec![words.len(); self.rows.len()]);
        all.chunks_exact(words.len()).find(|words| words[0] == 1).map(|words| P::get(&words[1..]))
    }

    fn words_of(&self, words: impl Fn(usize) -> usize) -> Vec<usize> {
        (0..self.rows.len()).map(words).collect()
    }

    /// All rows in blocks.
    fn blocks(&self, height: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        assert!(height > 0, "a block has rows");
        let all = self.rows.last().map_or(0, |rows| rows.end);
        (0..all).step_by(height).map(move |first| first..all.min(first + height))
    }
}

/// The rows that are in both ranges, an empty range inside of the second one if there are none.
fn overlap(block: &Range<usize>, rows: &Range<usize>) -> Range<usize> {
    let start = block.start.clamp(rows.start, rows.end);
    start..block.end.clamp(start, rows.end)
}
