use std::ops::Range;

use gfmd_field::Grid;

use super::{LANES, ROWS};

/// Blocks of [`LANES`] neighbouring points in a row, in the order of the points of the grid. Values of the points are
/// stored block by block.
#[derive(Debug)]
pub struct Blocks {
    /// The number of blocks in a row of the grid.
    width: usize,
    /// The place of each block among all of the grid.
    places: Vec<usize>,
    /// The first block of every row, and the number of all.
    starts: Vec<usize>,
}

/// The number of blocks below which a single thread processes them.
const FEW: usize = 64;

impl Blocks {
    /// The blocks with these indices among all blocks of `grid`, in ascending order.
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

    /// The number of blocks.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// True without blocks.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The place of each block among all of the grid.
    pub fn places(&self) -> &[usize] {
        &self.places
    }

    /// The blocks of a row.
    pub fn in_row(&self, row: usize) -> Range<usize> {
        self.starts[row]..self.starts[row + 1]
    }

    /// The number of rows of the grid.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// The number of blocks in a row of the grid.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The row of a block.
    pub fn row(&self, block: usize) -> usize {
        self.places[block] / self.width
    }

    /// The column of a block among those of the grid's blocks.
    pub fn column(&self, block: usize) -> usize {
        self.places[block] % self.width
    }

    /// Calls `each` on several threads, for at most [`ROWS`] rows at a time, with the values of their blocks, `size`
    /// per block. Rows without blocks may be left out.
    pub(super) fn for_rows<T: Send>(
        &self,
        size: usize,
        values: &mut [T],
        each: &(impl Fn(Range<usize>, &mut [T]) + Sync),
    ) {
        self.for_some(0..self.rows(), size, values, each);
    }

    /// The numbers of these rows, and the blocks of each with their values, `size` for each, of the `values` of all
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
