//! Points of the cells that belong to this process, and sums over the points of all processes.

use std::collections::BTreeMap;
use std::ops::Range;

use gfmd_field::{Grid, Share};
use gfmd_vector::LEAF;
use rayon::prelude::*;

use crate::Cell;

/// Points of the surface and of each cell that belong to this process: whole rows of their grids. Points are numbered
/// from the first one of this process.
#[derive(Clone, Debug)]
pub(crate) struct Division {
    /// Rows of the surface.
    pub(crate) surface: Share,
    cells: Vec<Share>,
}

/// The rows, whatever the processes that have them.
impl PartialEq for Division {
    fn eq(&self, other: &Self) -> bool {
        let rows = |of: &Self| of.cells.iter().map(|share| share.all_rows().to_vec()).collect::<Vec<_>>();
        self.surface.all_rows() == other.surface.all_rows() && rows(self) == rows(other)
    }
}

impl Division {
    /// Divides the points of cells below a surface, whose rows `surface` divides. All processes make this call.
    pub(crate) fn new(surface: &Share, grid: &Grid, cells: &[Cell]) -> Self {
        let mut coarser = BTreeMap::new();
        let of_cell = |cell: &Cell| {
            let [rows, columns] = cell.grid(grid).rows();
            let divided = || match (surface.is_whole(), cell.coarsening) {
                (true, _) => Share::whole(rows, columns),
                (false, 1) => surface.clone(),
                (false, _) => {
                    let (rank, size) = (surface.ranks().rank(), surface.ranks().size());
                    // The first process has a row of every grid.
                    let cut = |rank: usize| (rows * rank).div_ceil(size);
                    surface.of_lengths(cut(rank + 1) - cut(rank), columns)
                }
            };
            coarser.entry(cell.coarsening).or_insert_with(divided).clone()
        };
        let cells = cells.iter().map(of_cell).collect();
        Self { surface: surface.clone(), cells }
    }

    /// Returns the rows of a cell.
    pub(crate) fn of(&self, cell: usize) -> &Share {
        &self.cells[cell]
    }

    /// Returns the number of points of a cell.
    pub(crate) fn points(&self, cell: usize) -> usize {
        self.cells[cell].own().len()
    }

    /// Returns the shape `[x, y]` of a field of this process in a cell with this `grid`.
    pub(crate) fn shape(&self, cell: usize, grid: &Grid) -> [usize; 2] {
        let [nx, ny] = grid.points();
        let share = &self.cells[cell];
        if share.is_whole() { [nx, ny] } else { [share.rows().len(), ny] }
    }

    /// Sums over the points of each cell and all processes; `of(cell, range)` returns the sum over a range of points of
    /// this process. Each row is summed by itself: the bits are the same for any number of processes.
    pub(crate) fn sums(&self, of: &(impl Fn(usize, Range<usize>) -> f64 + Sync)) -> Vec<f64> {
        let mut stretches = Vec::new();
        for (cell, share) in self.cells.iter().enumerate() {
            let points = share.own().len();
            let length = if share.all_rows().last().is_some_and(|rows| rows.end == 1) { LEAF } else { share.columns() };
            let starts = (0..points).step_by(length);
            stretches.extend(starts.map(|start| (cell, start..points.min(start + length))));
        }
        let own: Vec<f64> = stretches.par_iter().map(|(cell, range)| of(*cell, range.clone())).collect();
        let tree = |values: &[f64]| gfmd_vector::sum(values.len(), &|range| values[range].iter().sum());
        if self.surface.is_whole() {
            let of_cell = |cell: usize| {
                let range = |limit: usize| stretches.partition_point(|(cell, _)| *cell < limit);
                tree(&own[range(cell)..range(cell + 1)])
            };
            return (0..self.cells.len()).map(of_cell).collect();
        }
        let rows = |rank: usize| self.cells.iter().map(move |share| share.all_rows()[rank].len());
        let size = self.surface.ranks().size();
        let lengths: Vec<usize> = (0..size).map(|rank| rows(rank).sum()).collect();
        let all = self.surface.collect(&own, &lengths);
        let mut of_cells = vec![Vec::new(); self.cells.len()];
        let mut rest = &all[..];
        for rank in 0..size {
            for (sums, count) in of_cells.iter_mut().zip(rows(rank)) {
                let (found, after) = rest.split_at(count);
                sums.extend_from_slice(found);
                rest = after;
            }
        }
        of_cells.iter().map(|sums| tree(sums)).collect()
    }

    /// Returns the worst value of all processes; `worse` chooses one of two.
    pub(crate) fn worst<const N: usize>(
        &self,
        own: [f64; N],
        worse: impl Fn([f64; N], [f64; N]) -> [f64; N],
    ) -> [f64; N] {
        self.surface.each(own).into_iter().fold(own, worse)
    }

    /// Returns the largest value of all processes, at least zero.
    pub(crate) fn largest(&self, own: f64) -> f64 {
        self.surface.each(own).into_iter().fold(0.0, f64::max)
    }

    /// Returns the flags that are set on any process, one of each cell.
    pub(crate) fn any(&self, own: &[bool]) -> Vec<bool> {
        let all = self.surface.collect(own, &vec![own.len(); self.surface.ranks().size()]);
        (0..own.len()).map(|cell| all.iter().skip(cell).step_by(own.len()).any(|flag| *flag)).collect()
    }
}
