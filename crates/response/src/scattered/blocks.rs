use std::ops::Range;

use gfmd_field::Grid;

use super::window::Window;
use super::{LANES, ROWS};

/// Blocks of [`LANES`] neighbouring points in a row, in the order of the grid points. Values of the points are stored
/// block by block.
#[derive(Debug)]
pub struct Blocks {
    /// Number of blocks in a row of the grid.
    width: usize,
    /// Index of each block among all blocks of the grid.
    places: Vec<usize>,
    /// First block of every row, followed by the number of blocks.
    starts: Vec<usize>,
}

/// Number of blocks below which a single thread processes them.
const FEW: usize = 64;

impl Blocks {
    /// Creates the blocks with these indices among all blocks of `grid`, in ascending order.
    pub fn new(grid: &Grid, places: Vec<usize>) -> Self {
        let [rows, columns] = grid.points();
        let width = columns / LANES;
        let mut starts = vec![0; rows + 1];
        places.iter().for_each(|place| starts[place / width + 1] += 1);
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        Self { width, places, starts }
    }

    /// Returns the number of blocks.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Returns true if there are no blocks.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Returns the index of each block among all blocks of the grid.
    pub fn places(&self) -> &[usize] {
        &self.places
    }

    /// Returns the blocks of a row.
    pub fn in_row(&self, row: usize) -> Range<usize> {
        self.starts[row]..self.starts[row + 1]
    }

    /// Returns the number of rows of the grid.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the number of blocks in a row of the grid.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the row of a block.
    pub fn row(&self, block: usize) -> usize {
        self.places[block] / self.width
    }

    /// Returns the column of a block, counted in blocks.
    pub fn column(&self, block: usize) -> usize {
        self.places[block] % self.width
    }

    /// Returns the blocks of several rows.
    pub(super) fn in_rows(&self, rows: &Range<usize>) -> Range<usize> {
        self.starts[rows.start]..self.starts[rows.end]
    }

    /// Returns the blocks in the rows of a window, counted on past the last block.
    pub(super) fn in_window(&self, window: Window) -> Range<usize> {
        let [first, others] = window.pieces().map(|rows| self.in_rows(&rows));
        first.start..first.end + others.len()
    }

    /// Returns the rows of one of several processes, which have about equal numbers of blocks.
    pub(super) fn rows_of(&self, rank: usize, size: usize) -> Range<usize> {
        let cut = |rank: usize| match rank {
            0 => 0,
            _ if rank == size => self.rows(),
            _ => self.starts.partition_point(|start| start * size < rank * self.len()),
        };
        cut(rank)..cut(rank + 1)
    }

    /// Calls `each` on several threads, for at most [`ROWS`] of the `rows` at a time, with the values of their blocks,
    /// `size` per block. Rows without blocks may be left out. `values` holds all blocks.
    pub(super) fn for_rows<T: Send>(
        &self,
        rows: Range<usize>,
        size: usize,
        values: &mut [T],
        each: &(impl Fn(Range<usize>, &mut [T]) + Sync),
    ) {
        let Range { start, end } = self.in_rows(&rows);
        self.for_some(rows, size, &mut values[start * size..end * size], each);
    }

    /// Iterates over `rows`: the number of each row, its blocks, and their values, `size` per block. `values` holds all
    /// blocks of the rows.
    pub(super) fn by_row<'a, T>(
        &'a self,
        rows: Range<usize>,
        size: usize,
        mut values: &'a mut [T],
    ) -> impl Iterator<Item = (usize, Range<usize>, &'a mut [T])> {
        rows.map(move |row| {
            let of_row = self.in_row(row);
            let (own, behind) = std::mem::take(&mut values).split_at_mut(of_row.len() * size);
            values = behind;
            (row, of_row, own)
        })
    }

    fn for_some<T: Send>(
        &self,
        rows: Range<usize>,
        size: usize,
        values: &mut [T],
        each: &(impl Fn(Range<usize>, &mut [T]) + Sync),
    ) {
        let [first, end] = [rows.start, rows.end].map(|row| self.starts[row]);
        if first == end {
            return;
        }
        if rows.len() <= ROWS {
            each(rows, values);
            return;
        }
        let middle = rows.start + rows.len() / 2;
        let (before, behind) = values.split_at_mut((self.starts[middle] - first) * size);
        let mut one = || self.for_some(rows.start..middle, size, before, each);
        let mut other = || self.for_some(middle..rows.end, size, behind, each);
        if end - first < FEW {
            (one(), other())
        } else {
            rayon::join(one, other)
        };
    }
}
