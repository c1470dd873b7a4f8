use std::ops::Range;

use gfmd_field::{Grid, Split};

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

/// Values of the blocks of several rows, for transforms row by row; its length is the number of rows.
pub struct BlockRows<'a, V> {
    /// Values, [`LANES`] per block.
    pub values: V,
    /// First block of every row, followed by the end of the last row.
    starts: &'a [usize],
}

impl<V: Split> Split for BlockRows<'_, V> {
    fn length(&self) -> usize {
        self.starts.len() - 1
    }

    fn split(self, middle: usize) -> (Self, Self) {
        let Self { values, starts } = self;
        let (above, below) = values.split((starts[middle] - starts[0]) * LANES);
        (Self { values: above, starts: &starts[..=middle] }, Self { values: below, starts: &starts[middle..] })
    }
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

    /// Returns the range of the values of some `rows` among the values of all blocks.
    pub fn values_in(&self, rows: &Range<usize>) -> Range<usize> {
        self.starts[rows.start] * LANES..self.starts[rows.end] * LANES
    }

    /// Makes the `values` of the blocks in some `rows` a vector of rows.
    pub fn split_rows<V: Split>(&self, rows: &Range<usize>, values: V) -> BlockRows<'_, V> {
        BlockRows { values, starts: &self.starts[rows.start..=rows.end] }
    }

    /// Returns the columns of the points of each block in a row.
    pub fn columns_in_row(&self, row: usize) -> impl Iterator<Item = Range<usize>> {
        self.in_row(row).map(|block| {
            let first = self.column(block) * LANES;
            first..first + LANES
        })
    }

    /// Writes the `values` of the blocks of one row into all columns of the `row`, zero between the blocks.
    pub fn write_row(&self, number: usize, values: &[f64], row: &mut [f64]) {
        row.fill(0.0);
        for (columns, values) in self.columns_in_row(number).zip(values.as_chunks::<LANES>().0) {
            row[columns].copy_from_slice(values);
        }
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
