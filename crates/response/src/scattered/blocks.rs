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
        self.visit(row, stencil, |target, _, window| counts[target] += window.near);
        counts
    }

    /// Writes the blocks that are near those of a row.
    fn fill(&self, row: usize, stencil: &Stencil, sources: &mut [Source]) {
        let mut sources = sources.iter_mut();
        self.visit(row, stencil, |target, down, window| {
            let column = self.column(self.in_row(row).start + target) as isize;
            let mut from = window.start;
            for source in sources.by_ref().take(window.near) {
                let place = stencil.place(down, column - window.column(from));
                *source = Source { block: (window.first + from.block) as u32, place };
                window.advance(&mut from);
            }
        });
    }

    /// Visits each block of a row, and for each the rows that are near it, with the number of rows by which it lies behind them.
    fn visit(&self, row: usize, stencil: &Stencil, mut visitor: impl FnMut(usize, isize, &Window)) {
        let (rows, reach) = (self.starts.len() - 1, stencil.reach);
        if self.in_row(row).is_empty() {
            return;
        }
        let window = |k: usize| (k as isize - reach as isize, (row + rows + reach - k) % rows);
        let near = (0..=2 * reach).map(window).filter(|(_, row)| !self.in_row(*row).is_empty());
        let mut windows: Vec<(isize, Window)> =
            near.map(|(down, row)| (down, self.window(row, stencil.blocks(down)))).collect();
        for (target, block) in self.in_row(row).enumerate() {
            for (down, window) in &mut windows {
                window.move_to(self.column(block) as isize);
                visitor(target, *down, window);
            }
        }
    }

    fn window(&self, row: usize, reach: usize) -> Window<'_> {
        let blocks = self.in_row(row);
        let before = Cursor { block: 0, shift: -(self.width as isize) };
        Window {
            first: blocks.start,
            places: &self.places[blocks],
            origin: row * self.width,
            width: self.width as isize,
            reach: reach as isize,
            start: before,
            end: before,
            near: 0,
        }
    }
}

/// The blocks of a row, continued periodically, of which some are near a column.
struct Window<'a> {
    first: usize,
    /// At least one.
    places: &'a [usize],
    /// The place of the first column.
    origin: usize,
    width: isize,
    /// The largest distance of those that are near.
    reach: isize,
    start: Cursor,
    end: Cursor,
    /// The number of blocks from `start` to `end`.
    near: usize,
}

/// A block of a row, in one of its periods.
#[derive(Clone, Copy)]
struct Cursor {
    block: usize,
    /// The first column of the period.
    shift: isize,
}

impl Window<'_> {
    fn column(&self, at: Cursor) -> isize {
        (self.places[at.block] - self.origin) as isize + at.shift
    }

    fn advance(&self, at: &mut Cursor) {
        at.block += 1;
        if at.block == self.places.len() {
            *at = Cursor { block: 0, shift: at.shift + self.width };
        }
    }

    /// Makes those near that are within reach of a column. Columns ascend from call to call.
    fn move_to(&mut self, column: isize) {
        let (mut start, mut end) = (self.start, self.end);
        while self.column(end) <= column + self.reach {
            self.advance(&mut end);
            self.near += 1;
        }
        while self.column(start) < column - self.reach {
            self.advance(&mut start);
            self.near -= 1;
        }
        (self.start, self.end) = (start, end);
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
        let filled: Vec<bool> = values.iter().map(|values| values.iter().any(|value| *value != 0.0)).collect();
        let out = out.as_chunks_mut::<LANES>().0;
        out.par_iter_mut().take(self.ends.len()).enumerate().with_min_len(64).for_each(|(block, out)| {
            let start = if block > 0 { self.ends[block - 1] } else { 0 };
            let mut sums = sum(&self.sources[start..self.ends[block]], stencil, values, &filled);
            more(block, &mut sums);
            *out = sums;
        });
    }
}

/// The sums over all sources of the kernel times their values; `filled` tells of which a value is not zero.
#[multiversion(targets = "simd")]
fn sum(sources: &[Source], stencil: &Stencil, values: &[[f32; LANES]], filled: &[bool]) -> [f32; LANES] {
    // Sums that do not wait for each other.
    let mut sums = [[0.0; LANES]; 4];
    for source in sources {
        if filled[source.block as usize] {
            for (lane, value) in values[source.block as usize].iter().enumerate() {
                let kernel = stencil.values(source.place, lane);
                sums[lane % 4].iter_mut().zip(kernel).for_each(|(sum, kernel)| *sum += value * kernel);
            }
        }
    }
    std::array::from_fn(|lane| (sums[0][lane] + sums[1][lane]) + (sums[2][lane] + sums[3][lane]))
}
