//! The numbers of the cells through which something flows: cells that are worked on together lie together.

use std::ops::Range;

use gfmd_field::Grid;
use gfmd_measure::{Boundary, Patches};

/// The number of a cell that takes no part.
pub(crate) const CLOSED: u32 = u32::MAX;

/// Cells along a side of a block, about. What is worked on of a block fits the second-level cache.
const BLOCK: usize = 96;

/// The open cells in three groups: those inside of blocks, block by block, those on borders, by which blocks are
/// separated, and the cells of one colour of a chequerboard, none of which has another one beside it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Numbering {
    /// The number of each cell, or [`CLOSED`].
    pub(crate) numbers: Vec<u32>,
    /// The cell with each number.
    pub(crate) open: Vec<u32>,
    /// The first number of each block, and of the borders.
    blocks: Vec<usize>,
    /// The first number of the chequerboard's colour.
    halves: usize,
}

impl Numbering {
    /// Numbers the cells of these patches.
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

    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.open.len()
    }

    /// Number of cells without those of the chequerboard's colour, which come last.
    pub(crate) fn kept(&self) -> usize {
        self.halves
    }

    /// The cells inside of each block.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.blocks.windows(2).map(|ends| ends[0]..ends[1])
    }

    /// The first number on the borders.
    pub(crate) fn border(&self) -> usize {
        self.blocks.last().copied().unwrap_or(0)
    }
}

/// The place of an index on an axis.
struct Place {
    block: usize,
    is_border: bool,
    alternates: bool,
}

/// The division of an axis.
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

    /// True if another block begins within two cells: without the cells of one colour, others are neighbours at that
    /// distance.
    fn is_border(&self, index: usize) -> bool {
        let block = self.block(index);
        (1..=2).any(|step| match index + step {
            next if next < self.points => self.block(next) != block,
            next => self.repeats && self.block(next % self.points) != block,
        })
    }

    /// False at the seam of an odd number of cells, where a chequerboard does not go on.
    fn alternates(&self, index: usize) -> bool {
        !self.repeats || self.points.is_multiple_of(2) || index + 1 < self.points
    }
}
