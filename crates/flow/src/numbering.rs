//! Numbers of the open cells, through which something flows: cells that are processed together lie together.

use std::ops::Range;

use gfmd_field::Grid;
use gfmd_measure::{Boundary, Patches};

/// Number of a closed cell.
pub(crate) const CLOSED: u32 = u32::MAX;

/// Approximate number of cells along a side of a block. The data of a block fit the second-level cache.
const BLOCK: usize = 96;

/// Open cells in three groups: cells inside blocks, block by block; cells on the borders between blocks; and cells of
/// one colour of a chequerboard, no two of them adjacent.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Numbering {
    /// Number of each cell, or [`CLOSED`].
    pub(crate) numbers: Vec<u32>,
    /// Cell with each number.
    pub(crate) open: Vec<u32>,
    /// First number of each block, followed by the first number on the borders.
    blocks: Vec<usize>,
    /// First number of the chequerboard colour.
    halves: usize,
}

impl Numbering {
    /// Numbers the cells of the chosen patches.
    pub(crate) fn new(grid: &Grid, boundary: Boundary, patches: &Patches, chosen: &[bool]) -> Self {
        let points = grid.points();
        let [rows, columns] = points.map(|n| Axis::new(n, boundary));
        let blocks = rows.blocks * columns.blocks;
        let places = [&rows, &columns].map(Axis::places);
        let classes = |i: usize| {
            let (row, labels) = (&places[0][i], patches.labels.row(i));
            places[1]
                .iter()
                .zip(labels)
                .enumerate()
                .filter(|(_, (_, label))| **label > 0 && chosen[**label as usize - 1])
                .map(move |(j, (column, _))| {
                    let block = row.block * columns.blocks + column.block;
                    if (i + j).is_multiple_of(2) && row.alternates && column.alternates {
                        (j, blocks + 1 + block)
                    } else if row.is_border || column.is_border {
                        (j, blocks)
                    } else {
                        (j, block)
                    }
                })
        };
        let mut starts = vec![0; 2 * blocks + 2];
        (0..points[0]).flat_map(classes).for_each(|(_, class)| starts[class + 1] += 1);
        (1..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        let mut next = starts.clone();
        let (mut numbers, mut open) = (vec![CLOSED; grid.len()], vec![0; starts[2 * blocks + 1]]);
        for i in 0..points[0] {
            for (j, class) in classes(i) {
                let cell = i * points[1] + j;
                numbers[cell] = next[class] as u32;
                open[next[class]] = cell as u32;
                next[class] += 1;
            }
        }
        let halves = starts[blocks + 1];
        starts.truncate(blocks + 1);
        Self { numbers, open, blocks: starts, halves }
    }

    /// Returns the number of cells.
    pub(crate) fn len(&self) -> usize {
        self.open.len()
    }

    /// Returns the number of cells without the chequerboard colour, which comes last.
    pub(crate) fn kept(&self) -> usize {
        self.halves
    }

    /// Iterates over the numbers of the cells inside each block.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.blocks.windows(2).map(|ends| ends[0]..ends[1])
    }

    /// Returns the first number on the borders.
    pub(crate) fn border(&self) -> usize {
        self.blocks.last().copied().unwrap_or(0)
    }
}

/// Place of an index on an axis.
struct Place {
    block: usize,
    is_border: bool,
    alternates: bool,
}

/// Division of an axis.
struct Axis {
    points: usize,
    blocks: usize,
    repeats: bool,
}

impl Axis {
    fn new(points: usize, boundary: Boundary) -> Self {
        Self { points, blocks: (points / BLOCK).max(1), repeats: boundary == Boundary::Periodic }
    }

    fn places(&self) -> Vec<Place> {
        let of = |index| Place {
            block: self.block(index),
            is_border: self.is_border(index),
            alternates: self.alternates(index),
        };
        (0..self.points).map(of).collect()
    }

    fn block(&self, index: usize) -> usize {
        index * self.blocks / self.points
    }

    /// Returns true if another block begins within two cells: without the cells of one colour, cells at that distance
    /// are neighbours.
    fn is_border(&self, index: usize) -> bool {
        let block = self.block(index);
        (1..=2).any(|step| match index + step {
            next if next < self.points => self.block(next) != block,
            next => self.repeats && self.block(next % self.points) != block,
        })
    }

    /// Returns false where cells are not eliminated: at the seam of an odd number of cells, where the chequerboard does
    /// not continue; on so few cells that both neighbours of a cell are the same; at an edge, beside a reservoir.
    fn alternates(&self, index: usize) -> bool {
        let is_last = index + 1 == self.points;
        if self.repeats {
            self.points >= 4 && (self.points.is_multiple_of(2) || !is_last)
        } else {
            index > 0 && !is_last
        }
    }
}
