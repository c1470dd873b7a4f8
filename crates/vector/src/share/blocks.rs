//! Transfer of rows between the first process, which reads and writes files, and the processes that own them.

use std::ops::Range;

use super::Share;
use crate::{Messages, Serialise, Word};

impl Share {
    /// Sends a field to the first rank. Each rank passes its `own` rows, of `columns` values each. On the first rank,
    /// `take` gets blocks of `height` rows in order, with their row numbers, which count on over all faces. The other
    /// ranks only send.
    ///
    /// # Panics
    /// If `own` does not have the rows of this rank, or if `height` is zero.
    pub fn to_first(&self, own: &[f64], columns: usize, height: usize, mut take: impl FnMut(Range<usize>, &[f64])) {
        let (points, all) = (self.rows().len() * columns, self.rows.last().map_or(0, |rows| rows.end));
        assert_eq!(own.len(), self.faces * points, "a field has the own rows");
        for face in 0..self.faces {
            let own = &own[face * points..(face + 1) * points];
            self.face_to_first(own, columns, height, &mut |rows: Range<usize>, values: &[f64]| {
                take(face * all + rows.start..face * all + rows.end, values);
            });
        }
    }

    fn face_to_first(&self, own: &[f64], columns: usize, height: usize, take: &mut dyn FnMut(Range<usize>, &[f64])) {
        let rows = self.rows();
        let mut messages = Messages::default();
        for block in self.blocks(height) {
            if self.is_whole() {
                take(block.clone(), &own[block.start * columns..block.end * columns]);
                continue;
            }
            let mine = overlap(&block, &rows);
            let sent = &own[(mine.start - rows.start) * columns..(mine.end - rows.start) * columns];
            messages.out.resize(sent.len(), 0);
            f64::pack(sent, &mut messages.out);
            messages.out_lengths = self.words_of(|rank| if rank == 0 { sent.len() } else { 0 });
            let is_first = self.ranks.rank() == 0;
            messages.into_lengths =
                self.words_of(|rank| if is_first { overlap(&block, &self.rows[rank]).len() * columns } else { 0 });
            messages.into.resize(messages.into_lengths.iter().sum(), 0);
            messages = self.ranks.post(messages).wait();
            if is_first {
                let mut values = vec![0.0; messages.into.len()];
                f64::unpack(&messages.into, &mut values);
                take(block, &values);
            }
        }
    }

    /// Distributes a field of the first rank: each rank gets its `own` rows, of `columns` values each. On the first
    /// rank, `give` fills blocks of `height` rows in order, with their row numbers, as [`to_first`](Self::to_first).
    /// The other ranks only receive.
    ///
    /// # Panics
    /// If `own` does not have the rows of this rank, or if `height` is zero.
    pub fn from_first(
        &self,
        own: &mut [f64],
        columns: usize,
        height: usize,
        mut give: impl FnMut(Range<usize>, &mut [f64]),
    ) {
        let (points, all) = (self.rows().len() * columns, self.rows.last().map_or(0, |rows| rows.end));
        assert_eq!(own.len(), self.faces * points, "a field has the own rows");
        for face in 0..self.faces {
            let own = &mut own[face * points..(face + 1) * points];
            self.face_from_first(own, columns, height, &mut |rows: Range<usize>, values: &mut [f64]| {
                give(face * all + rows.start..face * all + rows.end, values);
            });
        }
    }

    fn face_from_first(
        &self,
        own: &mut [f64],
        columns: usize,
        height: usize,
        give: &mut dyn FnMut(Range<usize>, &mut [f64]),
    ) {
        let (rows, is_first) = (self.rows(), self.ranks.rank() == 0);
        let mut messages = Messages::default();
        let (mut start, mut sent) = (0, Vec::new());
        for block in self.blocks(height) {
            if self.is_whole() {
                give(block.clone(), &mut own[block.start * columns..block.end * columns]);
                continue;
            }
            if is_first {
                sent.resize(block.len() * columns, 0.0);
                give(block.clone(), &mut sent);
            }
            messages.out.resize(sent.len(), 0);
            f64::pack(&sent, &mut messages.out);
            messages.out_lengths =
                self.words_of(|rank| if is_first { overlap(&block, &self.rows[rank]).len() * columns } else { 0 });
            let mine = overlap(&block, &rows).len() * columns;
            messages.into_lengths = self.words_of(|rank| if rank == 0 { mine } else { 0 });
            messages.into.resize(mine, 0);
            messages = self.ranks.post(messages).wait();
            f64::unpack(&messages.into, &mut own[start..start + mine]);
            start += mine;
        }
    }

    /// Returns the first value in rank order, on all ranks.
    pub fn first<P: Serialise>(&self, own: Option<P>) -> Option<P> {
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

    /// Divides all rows into blocks.
    fn blocks(&self, height: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        assert!(height > 0, "a block has rows");
        let all = self.rows.last().map_or(0, |rows| rows.end);
        (0..all).step_by(height).map(move |first| first..all.min(first + height))
    }
}

/// Returns the rows in both ranges; an empty range inside `rows` if there are none.
fn overlap(block: &Range<usize>, rows: &Range<usize>) -> Range<usize> {
    let start = block.start.clamp(rows.start, rows.end);
    start..block.end.clamp(start, rows.end)
}
