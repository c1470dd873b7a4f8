//! Partition of the rows of a field among processes.

mod blocks;

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::{Alone, LEAF, Messages, Ranks, Serialise, Split, Word, half, pass, reduce, tree};

/// Rows of a field that belong to this process, and the owners of all other rows.
///
/// Rows are divided between leaves of the tree of a [`pass`]. Each rank reduces the largest branches inside its rows,
/// all ranks receive the results, and each reduces the rest of the tree: a sum has the same bits for any number of
/// ranks.
#[derive(Clone)]
pub struct Share {
    ranks: Arc<dyn Ranks>,
    columns: usize,
    rows: Arc<[Range<usize>]>,
    /// Number of fields that follow one another, each divided by these rows.
    faces: usize,
}

/// Error: more processes than can share a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyRanks {
    /// Number of processes.
    pub ranks: usize,
    /// Largest possible number of processes.
    pub most: usize,
    /// Unit of the partition: each process except the last has a multiple of this number of rows.
    pub unit: usize,
}

impl fmt::Display for TooManyRanks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ranks, most, unit } = self;
        write!(
            f,
            "the grid is shared by {ranks} processes; it must be at most {most}: each has {unit} rows or a multiple of \
             them, which are whole blocks of {LEAF} values of the sums, so that these have the bits of one process. \
             Powers of two along y allow the most processes"
        )
    }
}

impl std::error::Error for TooManyRanks {}

impl Share {
    /// Returns all rows, for one process.
    pub fn whole(rows: usize, columns: usize) -> Self {
        Self { ranks: Arc::new(Alone), columns, rows: std::iter::once(0..rows).collect(), faces: 1 }
    }

    /// Returns the rows of this rank. The `ranks` share all rows as evenly as whole leaves and whole rows of `levels`
    /// coarser grids allow; each coarser grid has half as many rows.
    ///
    /// # Errors
    /// Returns an error if there are more ranks than the partition allows.
    pub fn among(ranks: Arc<dyn Ranks>, [rows, columns]: [usize; 2], levels: u32) -> Result<Self, TooManyRanks> {
        let size = ranks.size();
        if size == 1 {
            return Ok(Self::whole(rows, columns));
        }
        let unit = unit(columns, levels);
        let units = Self::most([rows, columns], levels);
        if size > units {
            return Err(TooManyRanks { ranks: size, most: units, unit });
        }
        let cut = |rank: usize| rows.min(units * rank / size * unit);
        let rows = (0..size).map(|rank| cut(rank)..cut(rank + 1)).collect();
        Ok(Self { ranks, columns, rows, faces: 1 })
    }

    /// Returns the rows of this rank of another field, of `rows` × `columns` values, shared by the same ranks.
    ///
    /// # Errors
    /// Returns an error as [`among`](Self::among).
    pub fn of_another(&self, shape: [usize; 2]) -> Result<Self, TooManyRanks> {
        Self::among(Arc::clone(&self.ranks), shape, 0)
    }

    /// Returns the rows of this rank of another field, of `columns` values each; each rank gives its `own` number of
    /// rows. Such a partition serves exchanges alone: ranks that add up values need whole leaves.
    pub fn of_lengths(&self, own: usize, columns: usize) -> Self {
        let mut end = 0;
        let place = |length: usize| {
            let start = end;
            end += length;
            start..end
        };
        let rows = self.each(own).into_iter().map(place).collect();
        Self { ranks: Arc::clone(&self.ranks), columns, rows, faces: 1 }
    }

    /// Returns the rows of this rank of another field, of `rows` × `columns` values, shared by the same ranks as evenly
    /// as multiples of `unit` rows allow; `None` if there are more ranks. Sums over such a field have other bits than
    /// with one process, since ranks need not have whole leaves.
    pub fn without_sums(&self, [rows, columns]: [usize; 2], unit: usize) -> Option<Self> {
        let (size, units) = (self.rows.len(), rows.div_ceil(unit));
        let cut = |rank: usize| rows.min(units * rank / size * unit);
        let parts = (0..size).map(|rank| cut(rank)..cut(rank + 1)).collect();
        (size <= units).then(|| Self { ranks: Arc::clone(&self.ranks), columns, rows: parts, faces: 1 })
    }

    /// Returns the largest number of processes that can share a field of `rows` × `columns` values.
    pub fn most([rows, columns]: [usize; 2], levels: u32) -> usize {
        rows.div_ceil(unit(columns, levels)).max(1)
    }

    /// Returns the partition of two fields that follow one another, both divided by these rows, such as the faces of a
    /// plate. Each rank has its rows of the first one, then its rows of the second one, and so do passes and sums.
    #[must_use]
    pub fn of_faces(&self) -> Self {
        Self { faces: 2, ..self.clone() }
    }

    /// Returns the partition of one of the [faces](Self::of_faces).
    #[must_use]
    pub fn face(&self) -> Self {
        Self { faces: 1, ..self.clone() }
    }

    /// Returns the number of fields that follow one another.
    pub fn faces(&self) -> usize {
        self.faces
    }

    /// Returns the processes.
    pub fn ranks(&self) -> &dyn Ranks {
        &*self.ranks
    }

    /// Returns true for a single process.
    pub fn is_whole(&self) -> bool {
        self.rows.len() == 1
    }

    /// Returns the rows of this rank.
    pub fn rows(&self) -> Range<usize> {
        self.rows[self.ranks.rank()].clone()
    }

    /// Returns the rows of each rank.
    pub fn all_rows(&self) -> &[Range<usize>] {
        &self.rows
    }

    /// Returns the number of values in a row.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the range of the values of this rank in the whole field. The values of further faces extend it, since
    /// they follow in the vectors of this rank.
    pub fn own(&self) -> Range<usize> {
        let Range { start, end } = self.values(self.ranks.rank());
        start..start + self.faces * (end - start)
    }

    /// Returns the number of values of all ranks.
    pub fn total(&self) -> usize {
        self.faces * self.of_face()
    }

    /// Returns the number of values of all ranks in one face.
    fn of_face(&self) -> usize {
        self.rows.last().map_or(0, |rows| rows.end * self.columns)
    }

    fn values(&self, rank: usize) -> Range<usize> {
        let rows = &self.rows[rank];
        rows.start * self.columns..rows.end * self.columns
    }

    /// Runs a [`pass`] over the values of all ranks; `vectors` hold the values of this rank. Every rank gets the
    /// result. Indices of `leaf` count from the first value of this rank.
    ///
    /// # Panics
    /// If the vectors do not have the number of values of this rank.
    pub fn pass<V: Split, R: Serialise>(
        &self,
        vectors: V,
        leaf: &(impl Fn(usize, V) -> R + Sync),
        merge: &(impl Fn(R, R) -> R + Sync),
    ) -> R {
        if self.faces == 1 {
            return self.pass_face(vectors, leaf, merge);
        }
        assert!(vectors.fits(self.own().len()), "the vectors of one pass must have the length of the share");
        let points = self.values(self.ranks.rank()).len();
        let mut rest = Some(vectors);
        let results = (0..self.faces).filter_map(|face| {
            let (part, after) = rest.take()?.split(points);
            rest = Some(after);
            Some(self.pass_face(part, &|start, part| leaf(face * points + start, part), merge))
        });
        results.reduce(merge).expect("there is at least one face")
    }

    /// Runs a pass over the values of one face.
    fn pass_face<V: Split, R: Serialise>(
        &self,
        vectors: V,
        leaf: &(impl Fn(usize, V) -> R + Sync),
        merge: &(impl Fn(R, R) -> R + Sync),
    ) -> R {
        if self.is_whole() {
            return pass(vectors, leaf, merge);
        }
        let own = self.values(self.ranks.rank());
        assert!(vectors.fits(own.len()), "the vectors of one pass must have the length of the share");
        let mut rest = vectors;
        let mut parts = Vec::new();
        for branch in self.branches(self.ranks.rank()) {
            let (part, after) = rest.split(branch.len());
            rest = after;
            parts.push(([branch.start - own.start, branch.len()], part));
        }
        let sums = parts.into_par_iter().map(|(place, part)| tree(LEAF, place, part, leaf, merge)).collect();
        self.joined(sums, merge)
    }

    /// Runs a [`reduce`] over the values of all ranks; `leaf` gets ranges of the values of this rank, counted from its
    /// first value.
    pub fn reduce<R: Serialise>(
        &self,
        leaf: &(impl Fn(Range<usize>) -> R + Sync),
        merge: &(impl Fn(R, R) -> R + Sync),
    ) -> R {
        if self.faces == 1 {
            return self.reduce_face(leaf, merge);
        }
        let points = self.values(self.ranks.rank()).len();
        let of_face = |face: usize| {
            self.reduce_face(&|range| leaf(face * points + range.start..face * points + range.end), merge)
        };
        (1..self.faces).fold(of_face(0), |result, face| merge(result, of_face(face)))
    }

    /// Runs a reduction over the values of one face.
    fn reduce_face<R: Serialise>(
        &self,
        leaf: &(impl Fn(Range<usize>) -> R + Sync),
        merge: &(impl Fn(R, R) -> R + Sync),
    ) -> R {
        let own = self.values(self.ranks.rank());
        if self.is_whole() {
            return reduce(own.len(), leaf, merge);
        }
        let places = self.branches(self.ranks.rank()).into_par_iter();
        let place = |branch: Range<usize>| [branch.start - own.start, branch.len()];
        let leaf = |start: usize, Count(length): Count| leaf(start..start + length);
        let sums = places.map(|branch| tree(LEAF, place(branch.clone()), Count(branch.len()), &leaf, merge)).collect();
        self.joined(sums, merge)
    }

    /// Reduces a vector of several components, which follow one another, each with the values of this rank; `leaf` gets
    /// ranges of one component, counted from the first value of the vector.
    pub fn reduce_components<R: Serialise>(
        &self,
        components: usize,
        leaf: &(impl Fn(Range<usize>) -> R + Sync),
        merge: &(impl Fn(R, R) -> R + Sync),
    ) -> R {
        let own = self.own().len();
        let of = |c: usize| self.reduce(&|range| leaf(range.start + c * own..range.end + c * own), merge);
        (1..components).fold(of(0), |result, c| merge(result, of(c)))
    }

    /// Returns the sum over the values of all ranks; `leaf` returns the sum over a range of the values of this rank.
    pub fn sum(&self, leaf: &(impl Fn(Range<usize>) -> f64 + Sync)) -> f64 {
        self.reduce(leaf, &|a, b| a + b)
    }

    /// Returns the sum of the values of all ranks, in double precision.
    pub fn total_of<T: Copy + Into<f64> + Sync>(&self, values: &[T]) -> f64 {
        self.sum(&|range| values[range].iter().map(|value| (*value).into()).sum())
    }

    /// Returns the scalar product Σ a b over the values of all ranks, in double precision.
    pub fn dot<T: Copy + Into<f64> + Sync>(&self, a: &[T], b: &[T]) -> f64 {
        self.sum(&|range| a[range.clone()].iter().zip(&b[range]).map(|(a, b)| (*a).into() * (*b).into()).sum())
    }

    /// Gathers the values of all ranks in rank order; rank r has `lengths[r]` values.
    pub fn collect<R: Serialise>(&self, own: &[R], lengths: &[usize]) -> Vec<R> {
        let mut words = vec![0; own.len() * R::WORDS];
        own.iter().enumerate().for_each(|(i, value)| value.put(&mut words[i * R::WORDS..][..R::WORDS]));
        let lengths: Vec<usize> = lengths.iter().map(|length| length * R::WORDS).collect();
        let mut all = vec![0; lengths.iter().sum()];
        self.ranks.gather(&words, &mut all, &lengths);
        if R::WORDS == 0 { Vec::new() } else { all.chunks_exact(R::WORDS).map(R::get).collect() }
    }

    /// Gathers one value from each rank.
    pub fn each<R: Serialise>(&self, own: R) -> Vec<R> {
        self.collect(&[own], &vec![1; self.rows.len()])
    }

    /// Returns true if `own` is true on any rank.
    pub fn any(&self, own: bool) -> bool {
        if self.is_whole() { own } else { self.each(own).contains(&true) }
    }

    /// Gathers the whole field from the rows `own` of each rank, of `columns` values each.
    pub fn gather<T: Word>(&self, own: &[T], columns: usize) -> Vec<T> {
        self.gather_rows(own, columns, &self.rows)
    }

    /// Gathers a field with another partition: `rows` holds the rows of each rank, one range after another.
    pub fn gather_rows<T: Word>(&self, own: &[T], columns: usize, rows: &[Range<usize>]) -> Vec<T> {
        let words = |rank: usize| T::words(rows[rank].len() * columns);
        let lengths: Vec<usize> = (0..rows.len()).map(words).collect();
        let mut packed = vec![0; lengths[self.ranks.rank()]];
        T::pack(own, &mut packed);
        let mut all = vec![0; lengths.iter().sum()];
        self.ranks.gather(&packed, &mut all, &lengths);
        T::joined(all, rows.iter().map(|rows| rows.len() * columns))
    }

    /// Moves the rows of a field from one division among the ranks to another. Both have the rows of each rank, one
    /// range after another; `own` holds the rows of this rank in the first one, of `columns` values each.
    pub fn moved<T: Word>(&self, own: &[T], columns: usize, [from, to]: [&[Range<usize>]; 2]) -> Vec<T> {
        let rank = self.ranks.rank();
        let common = |a: &Range<usize>, b: &Range<usize>| a.start.max(b.start)..a.end.min(b.end);
        let values = |rows: &Range<usize>| rows.len() * columns;
        let sent: Vec<Range<usize>> = to.iter().map(|rows| common(&from[rank], rows)).collect();
        let got: Vec<Range<usize>> = from.iter().map(|rows| common(rows, &to[rank])).collect();
        let lengths = |parts: &[Range<usize>]| parts.iter().map(|rows| T::words(values(rows))).collect::<Vec<_>>();
        let (out_lengths, into_lengths) = (lengths(&sent), lengths(&got));
        let mut out = vec![0; out_lengths.iter().sum()];
        let mut rest = &mut out[..];
        for (rows, length) in sent.iter().zip(&out_lengths) {
            let (words, after) = rest.split_at_mut(*length);
            rest = after;
            if !rows.is_empty() {
                T::pack(&own[(rows.start - from[rank].start) * columns..][..values(rows)], words);
            }
        }
        let into = vec![0; into_lengths.iter().sum()];
        let messages = Messages { out, out_lengths, into, into_lengths };
        let Messages { into, .. } = self.ranks.post(messages).wait();
        T::joined(into, got.iter().map(values))
    }

    /// Gathers rows around the cell: rank r gets the rows `to[r]`, which may go on past the last row with the first
    /// ones, and may overlap the rows of other ranks. `own` holds the rows `from[rank]`, of `columns` values each;
    /// `from` has the rows of each rank, one range after another.
    pub fn around<T: Word>(&self, own: &[T], columns: usize, [from, to]: [&[Range<usize>]; 2]) -> Vec<T> {
        let (rank, all) = (self.ranks.rank(), from.last().map_or(0, |rows| rows.end));
        // The rows of one rank that another gets, counted as by the latter, in its first turn around the cell and in
        // its second one.
        let common = |from: &Range<usize>, to: &Range<usize>| {
            [0, all].map(|turn| {
                let start = (from.start + turn).max(to.start);
                (turn, start..(from.end + turn).min(to.end).max(start))
            })
        };
        type Parts = [(usize, Range<usize>); 2];
        let sent: Vec<Parts> = to.iter().map(|rows| common(&from[rank], rows)).collect();
        let got: Vec<Parts> = from.iter().map(|rows| common(rows, &to[rank])).collect();
        let values = |rows: &Range<usize>| rows.len() * columns;
        let words = |parts: &Parts| parts.iter().map(|(_, rows)| T::words(values(rows))).sum::<usize>();
        let [out_lengths, into_lengths] = [&sent, &got].map(|parts| parts.iter().map(words).collect::<Vec<_>>());
        let [mut out, into] = [&out_lengths, &into_lengths].map(|lengths| vec![0; lengths.iter().sum()]);
        let mut rest = &mut out[..];
        for (turn, rows) in sent.iter().flatten().filter(|(_, rows)| !rows.is_empty()) {
            let (words, after) = rest.split_at_mut(T::words(values(rows)));
            rest = after;
            T::pack(&own[(rows.start - turn - from[rank].start) * columns..][..values(rows)], words);
        }
        let messages = Messages { out, out_lengths, into, into_lengths };
        let Messages { into, .. } = self.ranks.post(messages).wait();
        let mut rest = &into[..];
        let mut arrived = vec![T::default(); values(&to[rank])];
        for (_, rows) in got.iter().flatten().filter(|(_, rows)| !rows.is_empty()) {
            let (words, after) = rest.split_at(T::words(values(rows)));
            rest = after;
            T::unpack(words, &mut arrived[(rows.start - to[rank].start) * columns..][..values(rows)]);
        }
        arrived
    }

    /// Exchanges border rows around the cell: each rank sends its `first` and its `last` row, and gets the last row of
    /// the rank before and the first row of the rank after.
    pub fn beside<T: Word>(&self, first: &[T], last: &[T]) -> [Vec<T>; 2] {
        let (rank, size) = (self.ranks.rank(), self.rows.len());
        let (before, after) = ((rank + size - 1) % size, (rank + 1) % size);
        let words = T::words(first.len());
        let to = |other: usize| [(other == before, first), (other == after, last)];
        let mut messages = Messages::default();
        for other in 0..size {
            let mut length = 0;
            for (_, row) in to(other).into_iter().filter(|(goes, _)| *goes) {
                messages.out.resize(messages.out.len() + words, 0);
                let start = messages.out.len() - words;
                T::pack(row, &mut messages.out[start..]);
                length += words;
            }
            messages.out_lengths.push(length);
            // The rank after sends its first row, the rank before its last row; a rank that is both sends them in this
            // order.
            messages.into_lengths.push(usize::from(other == after) * words + usize::from(other == before) * words);
        }
        messages.into.resize(messages.into_lengths.iter().sum(), 0);
        let Messages { into, into_lengths, .. } = self.ranks.post(messages).wait();
        let start = |other: usize| into_lengths[..other].iter().sum::<usize>();
        let place = [start(before) + usize::from(before == after) * words, start(after)];
        place.map(|start| {
            let mut row = vec![T::default(); first.len()];
            T::unpack(&into[start..start + words], &mut row);
            row
        })
    }

    /// Returns the largest branches of the tree inside the values of a rank, in order.
    fn branches(&self, rank: usize) -> Vec<Range<usize>> {
        fn find(branch: Range<usize>, own: &Range<usize>, found: &mut Vec<Range<usize>>) {
            if branch.end <= own.start || own.end <= branch.start {
                return;
            }
            if own.start <= branch.start && branch.end <= own.end {
                found.push(branch);
                return;
            }
            let middle = branch.start + half(branch.len(), LEAF).expect("ranks own whole leaves");
            find(branch.start..middle, own, found);
            find(middle..branch.end, own, found);
        }
        let mut found = Vec::new();
        find(0..self.of_face(), &self.values(rank), &mut found);
        found
    }

    /// Reduces the whole tree from the results of the branches of this rank.
    fn joined<R: Serialise>(&self, own: Vec<R>, merge: &impl Fn(R, R) -> R) -> R {
        let branches: Vec<Vec<Range<usize>>> = (0..self.rows.len()).map(|rank| self.branches(rank)).collect();
        if R::WORDS == 0 {
            // There is nothing to exchange or to wait for.
            return R::get(&[]);
        }
        let lengths: Vec<usize> = branches.iter().map(Vec::len).collect();
        let all = self.collect(&own, &lengths);
        let mut branches = branches.into_iter().flatten().zip(all).peekable();
        walk(0..self.of_face(), &mut branches, merge)
    }
}

/// Returns the number of rows that fill whole leaves and whole rows of coarser grids, both powers of two.
fn unit(columns: usize, levels: u32) -> usize {
    (LEAF >> columns.trailing_zeros().min(LEAF.ilog2())).max(1 << levels)
}

/// Reduces a branch of the tree from the results of the branches inside it.
fn walk<R>(
    branch: Range<usize>,
    known: &mut std::iter::Peekable<impl Iterator<Item = (Range<usize>, R)>>,
    merge: &impl Fn(R, R) -> R,
) -> R {
    if let Some((_, result)) = known.next_if(|(range, _)| *range == branch) {
        return result;
    }
    let middle = branch.start + half(branch.len(), LEAF).expect("ranks own whole leaves");
    let left = walk(branch.start..middle, known, merge);
    merge(left, walk(middle..branch.end, known, merge))
}

/// Number of values without contents.
struct Count(usize);

impl Split for Count {
    fn length(&self) -> usize {
        self.0
    }

    fn split(self, middle: usize) -> (Self, Self) {
        (Self(middle), Self(self.0 - middle))
    }
}

impl fmt::Debug for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Share").field("rows", &self.rows()).field("ranks", &self.rows.len()).finish_non_exhaustive()
    }
}
