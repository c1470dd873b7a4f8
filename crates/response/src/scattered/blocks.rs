use std::ops::Range;

use gfmd_field::Grid;
use multiversion::multiversion;
use rayon::prelude::*;

use super::stencil::Stencil;
use super::{LANES, Scattered};

/// Blocks of [`LANES`] neighbouring points in a row, sorted as the points of the grid, with the pairs of those that are near each
/// other. Values of the points come block by block.
#[derive(Debug)]
pub struct Blocks {
    /// The number of blocks in a row of the grid.
    width: usize,
    /// The place of each block among all of the grid.
    places: Vec<usize>,
    /// The first block of every row, and the number of all.
    starts: Vec<usize>,
    pub(super) near: Pairs,
    pub(super) stiff: Pairs,
}

impl Blocks {
    /// The blocks at these places among all of `grid`, in ascending order; `None` if there are more than `most` pairs of blocks that
    /// are near each other: these are the effort of a sum over short waves, and most of the memory.
    pub fn new(scattered: &Scattered, grid: &Grid, places: Vec<usize>, most: usize) -> Option<Self> {
        let [rows, columns] = grid.points();
        let width = columns / LANES;
        let mut starts = vec![0; rows + 1];
        places.iter().for_each(|place| starts[place / width + 1] += 1);
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        let blocks = Self { width, places, starts, near: Pairs::default(), stiff: Pairs::default() };
        let (near, stiff) = (blocks.pairs(&scattered.near, most)?, blocks.pairs(&scattered.stiff, most)?);
        Some(Self { near, stiff, ..blocks })
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

    pub(super) fn row(&self, block: usize) -> usize {
        self.places[block] / self.width
    }

    pub(super) fn column(&self, block: usize) -> usize {
        self.places[block] % self.width
    }

    /// The pairs of blocks that are as near as the stencil reaches; `None` if there are more than `most`.
    fn pairs(&self, stencil: &Stencil, most: usize) -> Option<Pairs> {
        let rows = self.starts.len() - 1;
        let mut ends: Vec<usize> = (0..rows).into_par_iter().flat_map_iter(|row| self.counts(row, stencil)).collect();
        for block in 1..ends.len() {
            ends[block] += ends[block - 1];
        }
        let start = |block: usize| if block > 0 { ends[block - 1] } else { 0 };
        let all = start(self.len());
        if all > most {
            return None;
        }
        let mut sources = vec![Source { block: 0, place: 0 }; all];
        let mut rest = &mut sources[..];
        let of_row = |row| {
            let number = start(self.starts[row + 1]) - start(self.starts[row]);
            rest.split_off_mut(..number).map(|sources| (row, sources))
        };
        let of_rows: Vec<_> = (0..rows).filter_map(of_row).collect();
        of_rows.into_par_iter().for_each(|(row, sources)| self.fill(row, stencil, sources));
        Some(Pairs { ends, sources })
    }

    /// The number of blocks that are near each block of a row.
    fn counts(&self, row: usize, stencil: &Stencil) -> Vec<usize> {
        let mut counts = vec![0; self.in_row(row).len()];
        self.visit(row, stencil, |target, _, window| counts[target] += window.near.len());
        counts
    }

    /// Writes the blocks that are near those of a row.
    fn fill(&self, row: usize, stencil: &Stencil, sources: &mut [Source]) {
        let mut sources = sources.iter_mut();
        self.visit(row, stencil, |target, down, window| {
            let column = self.column(self.in_row(row).start + target) as isize;
            for ((block, found), source) in window.near.clone().map(|number| window.block(number)).zip(&mut sources) {
                *source = Source { block: (window.first + block) as u32, place: stencil.place(down, column - found) };
            }
        });
    }

    /// Visits each block of a row, and for each the rows that are near it, with the number of rows by which it lies behind them.
    fn visit(&self, row: usize, stencil: &Stencil, mut visitor: impl FnMut(usize, isize, &Window)) {
        let (rows, reach) = (self.starts.len() - 1, stencil.reach);
        if self.in_row(row).is_empty() {
            return;
        }
        let mut windows: Vec<Window> = (0..=2 * reach).map(|k| self.window((row + rows + reach - k) % rows)).collect();
        for (target, block) in self.in_row(row).enumerate() {
            for (down, window) in (-(reach as isize)..).zip(&mut windows) {
                window.move_to(self.column(block) as isize, stencil.blocks as isize);
                visitor(target, down, window);
            }
        }
    }

    fn window(&self, row: usize) -> Window<'_> {
        let blocks = self.in_row(row);
        let before = -(blocks.len() as isize);
        Window { first: blocks.start, places: &self.places[blocks], row, width: self.width, near: before..before }
    }
}

/// The blocks of a row, continued periodically, of which some are near a column.
struct Window<'a> {
    first: usize,
    places: &'a [usize],
    row: usize,
    width: usize,
    near: Range<isize>,
}

impl Window<'_> {
    /// Its block `number`, and the column of that.
    fn block(&self, number: isize) -> (usize, isize) {
        let all = self.places.len() as isize;
        let within = number.rem_euclid(all) as usize;
        let column = (self.places[within] - self.row * self.width) as isize;
        (within, column + number.div_euclid(all) * self.width as isize)
    }

    /// Makes those near that are at most `reach` blocks beside a column. Columns ascend from call to call.
    fn move_to(&mut self, column: isize, reach: isize) {
        if self.places.is_empty() {
            return;
        }
        while self.block(self.near.start).1 < column - reach {
            self.near.start += 1;
        }
        while self.block(self.near.end).1 <= column + reach {
            self.near.end += 1;
        }
    }
}

/// For each block those that are near it.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// The end of each block among the sources.
    ends: Vec<usize>,
    sources: Vec<Source>,
}

#[derive(Clone, Copy, Debug)]
struct Source {
    block: u32,
    place: u32,
}

impl Pairs {
    /// `out` ← the sums over all pairs of the kernel times the values; `more` adds to those of a block.
    pub(super) fn apply(
        &self,
        stencil: &Stencil,
        values: &[f32],
        out: &mut [f32],
        more: impl Fn(usize, &mut [f32; LANES]) + Sync,
    ) {
        let values = values.as_chunks::<LANES>().0;
        // One bit for each value that is not zero.
        let filled = |values: &[f32; LANES]| {
            values.iter().enumerate().fold(0, |bits, (lane, value)| bits | u8::from(*value != 0.0) << lane)
        };
        let filled: Vec<u8> = values.iter().map(filled).collect();
        let out = out.as_chunks_mut::<LANES>().0;
        out.par_iter_mut().take(self.ends.len()).enumerate().with_min_len(64).for_each(|(block, out)| {
            let start = if block > 0 { self.ends[block - 1] } else { 0 };
            let mut sums = sum(&self.sources[start..self.ends[block]], stencil, values, &filled);
            more(block, &mut sums);
            *out = sums;
        });
    }
}

/// The sums over all sources of the kernel times their values, of which `filled` has a bit for each that is not zero.
#[multiversion(targets("x86_64+avx2"))]
fn sum(sources: &[Source], stencil: &Stencil, values: &[[f32; LANES]], filled: &[u8]) -> [f32; LANES] {
    let mut sums = [0.0; LANES];
    for source in sources {
        let mut bits = filled[source.block as usize];
        let values = &values[source.block as usize];
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
            let (value, kernel) = (values[lane], stencil.values(source.place, lane));
            sums.iter_mut().zip(kernel).for_each(|(sum, kernel)| *sum += value * kernel);
            bits &= bits - 1;
        }
    }
    sums
}
