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
    /// The blocks at these places among all of `grid`, in ascending order.
    pub fn new(scattered: &Scattered, grid: &Grid, places: Vec<usize>) -> Self {
        let [rows, columns] = grid.points();
        let width = columns / LANES;
        let mut starts = vec![0; rows + 1];
        places.iter().for_each(|place| starts[place / width + 1] += 1);
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        let blocks = Self { width, places, starts, near: Pairs::default(), stiff: Pairs::default() };
        let (near, stiff) = (blocks.pairs(&scattered.near), blocks.pairs(&scattered.stiff));
        Self { near, stiff, ..blocks }
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

    /// The number of pairs of blocks that are near each other: the effort of a sum over short waves.
    pub fn pairs_near(&self) -> usize {
        self.near.sources.len()
    }

    pub(super) fn row(&self, block: usize) -> usize {
        self.places[block] / self.width
    }

    pub(super) fn column(&self, block: usize) -> usize {
        self.places[block] % self.width
    }

    fn pairs(&self, stencil: &Stencil) -> Pairs {
        let rows = 0..self.starts.len() - 1;
        let of_rows: Vec<Pairs> = rows.into_par_iter().map(|row| self.pairs_of_row(row, stencil)).collect();
        let mut pairs = Pairs { ends: Vec::with_capacity(self.len()), sources: Vec::new() };
        pairs.sources.reserve(of_rows.iter().map(|row| row.sources.len()).sum());
        for row in of_rows {
            let before = pairs.sources.len();
            pairs.ends.extend(row.ends.iter().map(|end| before + end));
            pairs.sources.extend(row.sources);
        }
        pairs
    }

    fn pairs_of_row(&self, row: usize, stencil: &Stencil) -> Pairs {
        let (rows, reach) = (self.starts.len() - 1, stencil.reach);
        let mut pairs = Pairs::default();
        if self.in_row(row).is_empty() {
            return pairs;
        }
        // The target lies between `reach` rows before the source and as many behind it.
        let mut windows: Vec<Window> = (0..=2 * reach).map(|k| self.window((row + rows + reach - k) % rows)).collect();
        for target in self.in_row(row) {
            let column = self.column(target) as isize;
            for (down, window) in (-(reach as isize)..).zip(&mut windows) {
                let beside = window.around(column, stencil.blocks as isize);
                let source = |(block, along)| Source { block, place: stencil.place(down, along) };
                pairs.sources.extend(beside.map(source));
            }
            pairs.ends.push(pairs.sources.len());
        }
        pairs
    }

    fn window(&self, row: usize) -> Window<'_> {
        let blocks = self.in_row(row);
        let all = blocks.len() as isize;
        Window { first: blocks.start, places: &self.places[blocks], row, width: self.width, low: -all }
    }
}

/// The blocks of a row from some column on, continued periodically.
struct Window<'a> {
    first: usize,
    places: &'a [usize],
    row: usize,
    width: usize,
    low: isize,
}

impl Window<'_> {
    /// Its block `number`, and the column of that.
    fn block(&self, number: isize) -> (usize, isize) {
        let all = self.places.len() as isize;
        let within = number.rem_euclid(all) as usize;
        let column = (self.places[within] - self.row * self.width) as isize;
        (within, column + number.div_euclid(all) * self.width as isize)
    }

    /// The blocks at most `reach` blocks beside a column, with the number of blocks by which it lies behind them. Columns ascend from
    /// call to call.
    fn around(&mut self, column: isize, reach: isize) -> impl Iterator<Item = (u32, isize)> {
        let any = !self.places.is_empty();
        while any && self.block(self.low).1 < column - reach {
            self.low += 1;
        }
        let end = if any { isize::MAX } else { self.low };
        let this = &*self;
        let all = (this.low..end).map(|number| this.block(number));
        let beside = all.take_while(move |(_, found)| *found <= column + reach);
        beside.map(move |(within, found)| ((this.first + within) as u32, column - found))
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
