//! Two-dimensional grids with rows shared by several processes.
//!
//! A rank computes the half spectra of its rows and transforms the columns that it owns. Columns are exchanged in
//! rounds, each with some of the columns of every rank, so that messages are small compared with a field:
//!
//! ```text
//!   rows ahead │ pack k+1 ─▶ post │ wait k │ columns of k: transform, multiply, transform back ─▶ post │
//!   unpack k−1 │ rows back
//! ```
//!
//! Every row and every column is transformed on one rank, with the same bits as in a single process.

use std::ops::Range;

use gfmd_vector::{Messages, Pending, Rows, Share, Split, distribute, lock};
use num_complex::Complex;

use crate::Real;
use crate::plane::{self, BLOCK, Plane, Worker};
use crate::real::copy;

/// Number of rounds: the messages of a round carry 1/16 of a field, and up to three rounds are pending at once.
const ROUNDS: usize = 16;

/// Plans for the rows of one rank.
pub(crate) struct Shared<T> {
    /// Transforms of all points, for the rows of this rank.
    plane: Plane<T>,
    share: Share,
    /// Columns of the half spectrum that belong to each rank.
    columns: Vec<Range<usize>>,
    /// Number of columns of each rank in a round.
    width: usize,
}

/// Working memory for the rows of this rank, and message buffers.
#[derive(Default)]
pub(crate) struct Memory<T> {
    plane: plane::Memory<T>,
    messages: Vec<Messages>,
}

/// Transfers of the columns: to the ranks that own them, and back.
#[derive(Clone, Copy)]
struct Direction {
    there: bool,
    back: bool,
}

impl<T: Real> Shared<T> {
    /// Creates plans for the rows of `share`, which fill the first `shown` points of the first rows of a plane. Each
    /// rank has its `columns`, by default about the same number.
    pub(crate) fn new(
        [rows, points]: [usize; 2],
        shown: usize,
        share: &Share,
        columns: Option<&[Range<usize>]>,
    ) -> Self {
        let (half, size) = (points / 2 + 1, share.all_rows().len());
        let even = || (0..size).map(|rank| half * rank / size..half * (rank + 1) / size).collect();
        let columns: Vec<Range<usize>> = columns.map_or_else(even, <[_]>::to_vec);
        let most = columns.iter().map(Range::len).max().unwrap_or(0);
        Self {
            plane: Plane::new([rows, points], [share.rows().len(), shown]),
            share: share.clone(),
            columns,
            width: most.div_ceil(ROUNDS).max(1),
        }
    }

    /// Returns the columns of the half spectrum that belong to this rank.
    pub(crate) fn columns(&self) -> Range<usize> {
        self.columns[self.share.ranks().rank()].clone()
    }

    pub(crate) fn memory(&self, threads: usize) -> Memory<T> {
        Memory { plane: self.plane.memory(threads), messages: Vec::new() }
    }

    /// Computes this rank's columns of the spectrum from the rows that `source` fills.
    pub(crate) fn forward(
        &self,
        source: &(impl Fn(usize, &mut [T]) + Sync),
        spectrum: &mut [Complex<T>],
        memory: &mut Memory<T>,
    ) {
        self.plane.rows_ahead((), &|i, (), row| source(i, row), self.plane.shown(), &mut memory.plane);
        let output = Rows(spectrum, self.plane.rows());
        let take = |_: usize, Rows(to, _): Rows<&mut [Complex<T>]>, column: &mut [Complex<T>], scratch: &mut Vec<_>| {
            self.plane.ahead(column, scratch);
            to.copy_from_slice(column);
            to.iter_mut().for_each(|mode| *mode *= self.plane.scale());
        };
        self.rounds(Direction { there: true, back: false }, output, &take, memory);
    }

    /// Computes this rank's rows of the field from its columns of the spectrum.
    pub(crate) fn inverse(&self, spectrum: &[Complex<T>], field: &mut [T], memory: &mut Memory<T>) {
        let input = Rows(spectrum, self.plane.rows());
        let give = |_: usize, Rows(from, _): Rows<&[Complex<T>]>, column: &mut [Complex<T>], scratch: &mut Vec<_>| {
            column.copy_from_slice(from);
            self.plane.back(column, scratch);
        };
        self.rounds(Direction { there: false, back: true }, input, &give, memory);
        self.plane.rows_back(Rows(field, self.plane.shown()), &copy, &mut memory.plane);
    }

    /// Computes the half spectra of this rank's rows of K f; `source` fills the rows of f from the rows of `input`. The
    /// kernel has this rank's columns only.
    pub(crate) fn convolve<I: Split>(
        &self,
        kernel: &[T],
        input: I,
        source: &(impl Fn(usize, I, &mut [T]) + Sync),
        memory: &mut Memory<T>,
    ) {
        self.plane.rows_ahead(input, source, self.plane.shown(), &mut memory.plane);
        let kernel = Rows(kernel, self.line(kernel));
        let filter = |_: usize, Rows(kernel, _): Rows<&[T]>, column: &mut [Complex<T>], scratch: &mut Vec<_>| {
            self.plane.filter(column, kernel, scratch);
        };
        self.rounds(Direction { there: true, back: true }, kernel, &filter, memory);
    }

    /// Passes the rows of the half spectra in the memory to `sink`, with the rows of `output`.
    pub(crate) fn rows_back<O: Split>(
        &self,
        output: O,
        sink: &(impl Fn(usize, &mut [T], O) + Sync),
        memory: &mut Memory<T>,
    ) {
        self.plane.rows_back(output, sink, &mut memory.plane);
    }

    /// Returns Σ_q w k |f̃|² over the rows of all ranks; `source` fills the rows of this rank.
    pub(crate) fn quadratic_form(
        &self,
        kernel: &[T],
        source: &(impl Fn(usize, &mut [T]) + Sync),
        memory: &mut Memory<T>,
    ) -> f64 {
        self.plane.rows_ahead((), &|i, (), row| source(i, row), self.plane.shown(), &mut memory.plane);
        let first = self.columns().start;
        let mut sums = vec![0.0; self.columns().len()];
        let output = (&mut sums[..], Rows(kernel, self.line(kernel)));
        type Both<'a, T> = (&'a mut [f64], Rows<&'a [T]>);
        let add = |local: usize, (sum, Rows(kernel, _)): Both<T>, column: &mut [Complex<T>], scratch: &mut Vec<_>| {
            sum[0] = self.plane.form(first + local, column, kernel, scratch);
        };
        self.rounds(Direction { there: true, back: false }, output, &add, memory);
        let lengths: Vec<usize> = self.columns.iter().map(Range::len).collect();
        self.plane.whole_form(&self.share.collect(&sums, &lengths))
    }

    /// Computes this rank's columns of the spectrum of a kernel that is even in both directions: half of each. `source`
    /// fills the values at the distances 0, 1, … along a row, for the distances of all rows.
    pub(crate) fn even(&self, source: &(impl Fn(usize, &mut [T]) + Sync), memory: &mut Memory<T>) -> Vec<T> {
        let first = self.share.rows().start;
        self.plane.even_rows(&|i: usize, row: &mut [T]| source(first + i, row), &mut memory.plane);
        let line = self.plane.rows() / 2 + 1;
        let mut kernel = vec![T::ZERO; self.columns().len() * line];
        let take = |_: usize, Rows(to, _): Rows<&mut [T]>, column: &mut [Complex<T>], scratch: &mut Vec<_>| {
            self.plane.even_column(self.held(), column, to, scratch);
        };
        self.rounds(Direction { there: true, back: false }, Rows(&mut kernel[..], line), &take, memory);
        kernel
    }

    /// Returns the number of rows of all ranks; a plane may have more, in which fields are zero.
    fn held(&self) -> usize {
        self.share.all_rows().last().map_or(0, |rows| rows.end)
    }

    /// Returns the number of kernel values in a column.
    fn line(&self, kernel: &[T]) -> usize {
        kernel.len().checked_div(self.columns().len()).unwrap_or(1)
    }

    /// Applies `work(number, parts, column, scratch)` to each column of this rank, with its parts of `output`.
    fn rounds<V: Split>(
        &self,
        direction: Direction,
        output: V,
        work: &(impl Fn(usize, V, &mut [Complex<T>], &mut Vec<Complex<T>>) + Sync),
        memory: &mut Memory<T>,
    ) {
        let most = self.columns.iter().map(Range::len).max().unwrap_or(0);
        let rounds = most.div_ceil(self.width);
        let mut rest = Some(output);
        let mut arriving = self.send_columns(0, direction, memory);
        let mut returning: Option<(usize, Box<dyn Pending + '_>)> = None;
        for round in 0..rounds {
            let next = self.send_columns(round + 1, direction, memory);
            let mut messages = std::mem::replace(&mut arriving, next).wait();
            let own = self.of_round(self.share.ranks().rank(), round);
            if let Some((output, after)) = rest.take().map(|rest| rest.split(own.len())) {
                self.transform(round, direction, output, work, &mut messages.into, memory);
                rest = Some(after);
            }
            if direction.back {
                let Messages { out, out_lengths, into, into_lengths } = messages;
                let reply = Messages { out: into, out_lengths: into_lengths, into: out, into_lengths: out_lengths };
                let posted = self.share.ranks().post(reply);
                if let Some((round, pending)) = returning.replace((round, posted)) {
                    self.store_columns(round, pending.wait(), memory);
                }
            } else {
                memory.messages.push(messages);
            }
        }
        memory.messages.push(arriving.wait());
        if let Some((round, pending)) = returning {
            self.store_columns(round, pending.wait(), memory);
        }
    }

    /// Sends the columns of a round to the ranks that own them; sends nothing after the last round.
    fn send_columns(&self, round: usize, direction: Direction, memory: &mut Memory<T>) -> Box<dyn Pending + '_> {
        let Memory { plane, messages } = memory;
        let mut messages = messages.pop().unwrap_or_default();
        let size = self.columns.len();
        let words = |rows: usize, columns: usize| rows * columns * T::WORDS;
        let (own, rows) = (self.of_round(self.share.ranks().rank(), round).len(), self.share.rows().len());
        messages.out_lengths = (0..size).map(|rank| words(rows, self.of_round(rank, round).len())).collect();
        messages.into_lengths = self.share.all_rows().iter().map(|rows| words(rows.len(), own)).collect();
        messages.out.resize(messages.out_lengths.iter().sum(), 0);
        messages.into.resize(messages.into_lengths.iter().sum(), 0);
        if !direction.there {
            return Box::new(NotSent(messages));
        }
        let plane::Memory { blocks, workers, .. } = plane;
        let stride = self.plane.stride();
        let items = self.pieces(round, &mut messages.out);
        distribute(workers, items.into_iter(), |(block, columns, piece), _| {
            let lines = piece.chunks_exact_mut(columns.len() * T::WORDS);
            for (line, half) in lines.zip(lock(&blocks[block]).chunks_exact(stride)) {
                let words = line.chunks_exact_mut(T::WORDS);
                words.zip(&half[columns.clone()]).for_each(|(words, mode)| T::put(mode, words));
            }
        });
        self.share.ranks().post(messages)
    }

    /// Stores the columns of a round in the rows of this rank.
    fn store_columns(&self, round: usize, mut messages: Messages, memory: &mut Memory<T>) {
        let plane::Memory { blocks, workers, .. } = &mut memory.plane;
        let stride = self.plane.stride();
        let items = self.pieces(round, &mut messages.into);
        distribute(workers, items.into_iter(), |(block, columns, piece), _| {
            let lines = piece.chunks_exact(columns.len() * T::WORDS);
            for (line, half) in lines.zip(lock(&blocks[block]).chunks_exact_mut(stride)) {
                let words = line.chunks_exact(T::WORDS);
                half[columns.clone()].iter_mut().zip(words).for_each(|(mode, words)| *mode = T::get(words));
            }
        });
        memory.messages.push(messages);
    }

    /// Returns the pieces of the messages with the rows of this rank, in order: block of rows, columns, words.
    fn pieces<'a>(&self, round: usize, mut words: &'a mut [u64]) -> Vec<(usize, Range<usize>, &'a mut [u64])> {
        let rows = self.share.rows().len();
        let mut pieces = Vec::new();
        for rank in 0..self.columns.len() {
            for panel in panels::<T>(self.of_round(rank, round)) {
                for (block, first) in (0..rows).step_by(BLOCK).enumerate() {
                    let length = BLOCK.min(rows - first) * panel.len() * T::WORDS;
                    let (piece, rest) = words.split_at_mut(length);
                    pieces.push((block, panel.clone(), piece));
                    words = rest;
                }
            }
        }
        pieces
    }

    /// Processes the columns of this rank in a round; `words` holds them from all ranks.
    fn transform<V: Split>(
        &self,
        round: usize,
        direction: Direction,
        output: V,
        work: &(impl Fn(usize, V, &mut [Complex<T>], &mut Vec<Complex<T>>) + Sync),
        words: &mut [u64],
        memory: &mut Memory<T>,
    ) {
        let rank = self.share.ranks().rank();
        let (own, first) = (self.of_round(rank, round), self.columns[rank].start);
        let mut messages = Vec::new();
        let mut rest = words;
        for rows in self.share.all_rows() {
            let (message, after) = rest.split_at_mut(rows.len() * own.len() * T::WORDS);
            messages.push(message);
            rest = after;
        }
        let mut items = Vec::new();
        for panel in panels::<T>(own) {
            let mut parts = Vec::new();
            for (message, rows) in messages.iter_mut().zip(self.share.all_rows()) {
                let (part, after) = std::mem::take(message).split_at_mut(rows.len() * panel.len() * T::WORDS);
                *message = after;
                parts.push((rows.clone(), part));
            }
            items.push((panel, parts));
        }
        let (rows, held, stride) = (self.plane.rows(), self.held(), self.plane.column());
        let items = items.into_iter().zip(output.parts(Plane::<T>::GAP));
        distribute(
            &mut memory.plane.workers,
            items,
            |((panel, mut parts), output), Worker { columns, scratch, .. }| {
                let width = panel.len();
                for (rows, part) in parts.iter().filter(|_| direction.there) {
                    for (i, line) in rows.clone().zip(part.chunks_exact(width * T::WORDS)) {
                        let line = line.chunks_exact(T::WORDS).enumerate();
                        line.for_each(|(place, words)| columns[place * stride + i] = T::get(words));
                    }
                }
                let all = panel.zip(columns.chunks_exact_mut(stride)).zip(output.parts(1));
                all.for_each(|((number, column), output)| {
                    column[held..rows].fill(Complex::ZERO);
                    work(number - first, output, &mut column[..rows], scratch);
                });
                for (rows, part) in parts.iter_mut().filter(|_| direction.back) {
                    for (i, line) in rows.clone().zip(part.chunks_exact_mut(width * T::WORDS)) {
                        let line = line.chunks_exact_mut(T::WORDS).enumerate();
                        line.for_each(|(place, words)| T::put(&columns[place * stride + i], words));
                    }
                }
            },
        );
    }

    /// Returns the columns of a rank in a round.
    fn of_round(&self, rank: usize, round: usize) -> Range<usize> {
        let Range { start, end } = self.columns[rank];
        end.min(start + round * self.width)..end.min(start + (round + 1) * self.width)
    }
}

/// Iterates over panels of neighbouring columns, one cache line wide.
fn panels<T: Real>(columns: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let Range { start, end } = columns;
    (start..end).step_by(Plane::<T>::GAP).map(move |first| first..end.min(first + Plane::<T>::GAP))
}

/// Message buffers without an exchange.
struct NotSent(Messages);

impl Pending for NotSent {
    fn wait(self: Box<Self>) -> Messages {
        self.0
    }
}
