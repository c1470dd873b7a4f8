//! Level of a pull-push. A process may hold only its own rows.

use std::ops::Range;

use gfmd_vector::Share;
use rayon::prelude::*;

use super::{Edges, rows as row};

pub(super) struct Level {
    /// Number of cells of all processes.
    pub(super) cells: [usize; 2],
    /// Rows computed by this process, all of them if it is alone.
    own: Range<usize>,
    /// Rows held by this process.
    held: Range<usize>,
    /// Rows computed by each process, for a level that all of them hold.
    parts: Vec<Range<usize>>,
    /// Known weight above which the value of the cell has full weight.
    pub(super) full: f32,
    /// Factor on the value of the next level, for cells without known values; between zero and one.
    pub(super) trust: f32,
    /// Known weight of each cell held, the sum of the weights of its children; empty between two uses.
    pub(super) known: Vec<f32>,
    pub(super) value: Vec<f32>,
    known_beside: Beside,
    value_beside: Beside,
}

/// Rows of a level held by other processes: the one before the own rows and the one after them.
type Beside = [Vec<f32>; 2];

/// Steps from one level to the next, row by row.
impl Level {
    pub(super) fn new(cells: [usize; 2], full: f32, trust: f32) -> Self {
        let rows = 0..cells[0];
        Self {
            cells,
            own: rows.clone(),
            held: rows,
            parts: Vec::new(),
            full,
            trust,
            known: Vec::new(),
            value: Vec::new(),
            known_beside: Beside::default(),
            value_beside: Beside::default(),
        }
    }

    /// Shares the rows like the rows of the points; a row stands for 2^`height` rows of points. If `is_last`, every
    /// process computes its part of this level, and holds all of it and of the levels above.
    pub(super) fn distribute(&mut self, share: &Share, height: u32, is_last: bool) {
        let part = |rows: &Range<usize>| rows.start >> height..rows.end.div_ceil(1 << height);
        let parts: Vec<Range<usize>> = share.all_rows().iter().map(part).collect();
        self.own = parts[share.ranks().rank()].clone();
        if is_last {
            self.parts = parts;
            return;
        }
        self.held = self.own.clone();
    }

    /// Allocates the values, if they are not.
    pub(super) fn reserve(&mut self) {
        let values = self.held.len() * self.cells[1];
        self.known.resize(values, 0.0);
        self.value.resize(values, 0.0);
    }

    /// Frees the values until the next use.
    pub(super) fn release(&mut self) {
        (self.known, self.value) = Default::default();
    }

    /// Receives the known weights computed by other processes: all of them, or the rows beside the own ones.
    pub(super) fn exchange_known(&mut self, share: &Share) {
        let width = self.cells[1];
        exchange(&self.own, &self.parts, width, &mut self.known, &mut self.known_beside, share);
    }

    /// Receives the values computed by other processes.
    pub(super) fn exchange_values(&mut self, share: &Share) {
        let width = self.cells[1];
        exchange(&self.own, &self.parts, width, &mut self.value, &mut self.value_beside, share);
    }

    /// Receives the values beside the own rows, after a step on all rows held.
    pub(super) fn exchange_halo(&mut self, share: &Share) {
        if self.parts.is_empty() {
            self.exchange_values(share);
        }
    }

    /// Returns the range of the own rows among the values held.
    fn own_values(&self) -> Range<usize> {
        let (first, width) = (self.held.start, self.cells[1]);
        (self.own.start - first) * width..(self.own.end - first) * width
    }

    /// Returns the values held, and their rows.
    pub(super) fn values(&mut self) -> (&mut [f32], Range<usize>) {
        (&mut self.value, self.held.clone())
    }

    /// Returns the known weights of row i.
    pub(super) fn known(&self, i: usize) -> &[f32] {
        self.row(&self.known, &self.known_beside, i)
    }

    /// Returns the values of row i.
    pub(super) fn value(&self, i: usize) -> &[f32] {
        self.row(&self.value, &self.value_beside, i)
    }

    fn row<'a>(&self, field: &'a [f32], beside: &'a Beside, i: usize) -> &'a [f32] {
        held_row(field, beside, &self.held, self.cells, i)
    }

    pub(super) fn weight(&self, known: f32) -> f32 {
        row::weight(known, self.full)
    }

    /// Computes the weighted mean of the children; `read(i, weights, weights times values)` reads row i below.
    pub(super) fn pull(&mut self, [height, columns]: [usize; 2], read: impl Fn(usize, &mut [f32], &mut [f32]) + Sync) {
        let (own, width) = (self.own_values(), self.cells[1]);
        let first = self.own.start;
        let rows = rows(&mut self.value[own.clone()], width).zip(self.known[own].par_chunks_mut(width)).enumerate();
        rows.for_each_init(
            || [vec![0.0; columns], vec![0.0; columns]],
            |[weights, values], (a, (value, known))| {
                value.fill(0.0);
                known.fill(0.0);
                let a = first + a;
                for i in 2 * a..height.min(2 * a + 2) {
                    read(i, weights, values);
                    row::add_pairs(weights, known);
                    row::add_pairs(values, value);
                }
                row::divide(value, known);
            },
        );
    }

    /// Interpolates row i of the level below bilinearly.
    pub(super) fn interpolate(&self, edges: Edges, i: usize, children: &mut [f32]) {
        let [height, width] = self.cells;
        let beside = if i % 2 == 1 { edges.after(i / 2, height) } else { edges.before(i / 2, height) };
        let (near, far) = (self.value(i / 2), self.value(beside));
        let parts = [0.75, 0.25].map(|part| part * self.trust);
        for b in [0, width - 1] {
            let three = [edges.before(b, width), b, edges.after(b, width)];
            let pair = row::pair_of(three.map(|b| near[b]), three.map(|b| far[b]), parts);
            children[2 * b..].iter_mut().zip(pair).for_each(|(value, child)| *value = child);
        }
        // A row may have only one child.
        let inner = children.get_mut(2..).unwrap_or_default().as_chunks_mut::<2>().0;
        row::interpolate(near, far, parts, inner);
    }

    /// Interpolates the whole level below and calls `write(i, row, interpolated)` for each of its rows.
    pub(super) fn push(
        &self,
        edges: Edges,
        (below, held): (&mut [f32], Range<usize>),
        columns: usize,
        write: impl Fn(usize, &mut [f32], &[f32]) + Sync,
    ) {
        rows(below, columns).enumerate().for_each_init(
            || vec![0.0; columns],
            |pushed, (i, row)| {
                let i = held.start + i;
                self.interpolate(edges, i, pushed);
                write(i, row, pushed);
            },
        );
    }

    /// Applies the transpose of [`push`](Self::push); `add(i, line, part)` adds row i below times `part`.
    pub(super) fn push_transposed(
        &mut self,
        edges: Edges,
        [below, columns]: [usize; 2],
        add: impl Fn(usize, &mut [f32], f32) + Sync,
    ) {
        let [height, width] = self.cells;
        let (own, first) = (self.own_values(), self.own.start);
        rows(&mut self.value[own], width).enumerate().for_each_init(
            // With an odd number of columns the last child is missing and counts as zero.
            || vec![0.0; 2 * width],
            |line, (a, image)| {
                line.fill(0.0);
                for (i, part) in edges.children(first + a, height).into_iter().filter(|child| child.0 < below) {
                    add(i, &mut line[..columns], part);
                }
                let pairs = line.as_chunks::<2>().0;
                row::gather(pairs, self.trust, &mut image[1..]);
                for b in [0, width - 1] {
                    let along = edges.children(b, width).map(|(j, part)| part * line[j]);
                    image[b] = self.trust * along.into_iter().sum::<f32>();
                }
            },
        );
    }

    /// Applies the transpose of [`pull`](Self::pull); calls `write(i, row, share)` with the share of the parent for a
    /// child of unit weight.
    pub(super) fn pull_transposed(
        &self,
        (below, held): (&mut [f32], Range<usize>),
        columns: usize,
        write: impl Fn(usize, &mut [f32], &[f32]) + Sync,
    ) {
        let width = self.cells[1];
        rows(below, columns).enumerate().for_each_init(
            || vec![0.0; 2 * width],
            |share, (i, row)| {
                let i = held.start + i;
                row::split(self.known(i / 2), self.value(i / 2), share.as_chunks_mut::<2>().0);
                write(i, row, share);
            },
        );
    }
}

/// Returns row i of a field with `height` rows, from the rows held or the rows beside them.
pub(super) fn held_row<'a, T>(
    field: &'a [T],
    beside: &'a [Vec<T>; 2],
    held: &Range<usize>,
    [height, columns]: [usize; 2],
    i: usize,
) -> &'a [T] {
    if held.contains(&i) {
        return row_of(field, i - held.start, columns);
    }
    &beside[usize::from(i == held.end % height)]
}

/// Completes a field after every process has computed its `own` rows: by all `parts` of a level that all processes
/// hold, otherwise by the rows beside.
fn exchange(
    own: &Range<usize>,
    parts: &[Range<usize>],
    width: usize,
    field: &mut Vec<f32>,
    beside: &mut Beside,
    share: &Share,
) {
    if parts.is_empty() {
        *beside = share.beside(&field[..width], &field[field.len() - width..]);
    } else {
        *field = share.gather_rows(&field[own.start * width..own.end * width], width, parts);
    }
}

/// Returns row i of a field.
pub(super) fn row_of<T>(field: &[T], i: usize, columns: usize) -> &[T] {
    &field[i * columns..][..columns]
}

/// Returns all rows of a field in parallel, in tasks of at least some 8000 values.
fn rows(field: &mut [f32], columns: usize) -> impl IndexedParallelIterator<Item = &mut [f32]> {
    field.par_chunks_mut(columns).with_min_len(1 + 8192 / columns)
}
