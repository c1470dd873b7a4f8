use std::array::from_fn;
use std::ops::Range;

use multiversion::multiversion;

use super::stencil::{NARROW, Stencil};
use super::window::Window;
use super::{Blocks, LANES};

/// Blocks with nonzero values, placed first in the range of blocks of their row.
#[derive(Debug, Default)]
pub(super) struct Sources(Vec<Source>);

#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    column: u32,
    /// Number of lanes with nonzero values; zero after the last source of a row.
    filled: u32,
    /// Indices of these lanes, followed by lanes with zero values.
    lanes: [u8; LANES],
    values: [f32; LANES],
}

const END: Source = Source { column: 0, filled: 0, lanes: [0; LANES], values: [0.0; LANES] };

impl Source {
    /// Returns the column, counted in blocks.
    pub(super) fn column(&self) -> usize {
        self.column as usize
    }

    /// Returns the values of all lanes.
    pub(super) fn values(&self) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        for (value, lane) in self.values.iter().zip(self.lanes) {
            values[lane as usize % LANES] += value;
        }
        values
    }

    /// Creates the source of a block.
    fn new(column: usize, values: &[f32; LANES]) -> Self {
        let filled: usize = (0..LANES).map(|lane| usize::from(values[lane] != 0.0) << lane).sum();
        let lanes = ORDER[filled];
        Self {
            column: column as u32,
            filled: filled.count_ones(),
            lanes,
            values: from_fn(|i| values[lanes[i] as usize % LANES]),
        }
    }
}

/// Permutation of all lanes for each subset of lanes, with the subset first.
const ORDER: [[u8; LANES]; 1 << LANES] = {
    let mut orders = [[0; LANES]; 1 << LANES];
    let mut set = 0;
    while set < orders.len() {
        let (mut place, mut lane) = (0, 0);
        while lane < 2 * LANES {
            let is_first = set >> (lane % LANES) & 1 == 1;
            if is_first == (lane < LANES) {
                orders[set][place] = (lane % LANES) as u8;
                place += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    orders
};

impl Sources {
    /// Takes the `values` of the points of the blocks in the rows of a window. Other rows keep their sources.
    pub(super) fn take(&mut self, blocks: &Blocks, values: &[f32], window: Window) {
        self.0.resize(blocks.len(), END);
        window.pieces().into_iter().for_each(|rows| self.take_rows(blocks, values, rows));
    }

    fn take_rows(&mut self, blocks: &Blocks, values: &[f32], rows: Range<usize>) {
        let values = values.as_chunks::<LANES>().0;
        blocks.for_rows(rows, 1, &mut self.0, &|rows, sources| {
            for (_, of_row, sources) in blocks.by_row(rows, 1, sources) {
                let mut number = 0;
                for block in of_row {
                    // The next source overwrites a block without nonzero values.
                    sources[number] = Source::new(blocks.column(block), &values[block]);
                    number += usize::from(sources[number].filled != 0);
                }
                if let Some(end) = sources.get_mut(number) {
                    *end = END;
                }
            }
        });
    }

    /// Returns the sources of a row.
    pub(super) fn in_row(&self, blocks: &Blocks, row: usize) -> &[Source] {
        let sources = &self.0[blocks.in_row(row)];
        let number = sources.iter().position(|source| source.filled == 0);
        &sources[..number.unwrap_or(sources.len())]
    }

    /// Adds to `out`, for each point of the blocks in these rows, the sum of all values times the kernel to this point.
    /// The sources within reach of the rows must be known.
    pub(super) fn add<const N: usize>(
        &self,
        stencil: &Stencil<N>,
        blocks: &Blocks,
        rows: Range<usize>,
        out: &mut [f32],
    ) {
        let length = blocks.width() + N - 1;
        blocks.for_rows(rows, LANES, out, &|rows, out| {
            let mut sums = vec![[0.0; LANES]; rows.len() * length];
            sum(self, stencil, blocks, rows.clone(), &mut sums);
            for ((_, of_row, out), sums) in blocks.by_row(rows, LANES, out).zip(sums.chunks_exact_mut(length)) {
                hand_out(sums, N / 2, (blocks, of_row), out);
            }
        });
    }
}

/// Adds to `out` the sums for these blocks of a row. `sums` covers the whole row and `beyond` blocks past each end,
/// which belong to the opposite end.
#[multiversion(targets = "simd")]
fn hand_out(sums: &mut [[f32; LANES]], beyond: usize, (blocks, of_row): (&Blocks, Range<usize>), out: &mut [f32]) {
    let width = blocks.width();
    let mut add = |to: usize, from: usize| {
        let added = sums[from];
        sums[to].iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
    };
    (0..beyond).for_each(|i| add(width + i, i));
    (beyond..2 * beyond).for_each(|i| add(i, width + i));
    for (block, out) in of_row.zip(out.as_chunks_mut::<LANES>().0) {
        let sums = &sums[blocks.column(block) + beyond];
        out.iter_mut().zip(sums).for_each(|(out, sum)| *out += sum);
    }
}

/// Adds to the sums of some rows the values of all nearby sources times the kernel.
// Wider vectors would straddle vectors that have just been written, which takes longer.
#[multiversion(targets("x86_64+avx+avx2"))]
fn sum<const N: usize>(
    sources: &Sources,
    stencil: &Stencil<N>,
    blocks: &Blocks,
    targets: Range<usize>,
    sums: &mut [[f32; LANES]],
) {
    let (rows, reach) = (blocks.rows(), stencil.reach());
    let length = sums.len() / targets.len();
    let narrow = (N - NARROW) / 2;
    // The row of the sources plus the reach.
    for ahead in targets.start..targets.end + 2 * reach {
        let near = targets.start.max(ahead.saturating_sub(2 * reach))..targets.end.min(ahead + 1);
        let sums = &mut sums[(near.start - targets.start) * length..(near.end - targets.start) * length];
        let kernel = near.start + 2 * reach - ahead..near.end + 2 * reach - ahead;
        let [begin, end] = [stencil.wide().start, stencil.wide().end].map(|k| k.clamp(kernel.start, kernel.end));
        let (above, others) = sums.split_at_mut((begin - kernel.start) * length);
        let (beside, below) = others.split_at_mut((end - begin) * length);
        for source in sources.in_row(blocks, (ahead + rows - reach) % rows) {
            let column = source.column();
            source.add::<NARROW>(stencil.rows(kernel.start..begin, narrow), rows_of(above, length, column + narrow));
            source.add::<N>(stencil.rows(begin..end, 0), rows_of(beside, length, column));
            source.add::<NARROW>(stencil.rows(end..kernel.end, narrow), rows_of(below, length, column + narrow));
        }
    }
}

/// Iterates over rows of `length` blocks, from the block `first` on.
#[inline(always)]
fn rows_of(sums: &mut [[f32; LANES]], length: usize, first: usize) -> impl Iterator<Item = &mut [[f32; LANES]]> {
    sums.chunks_exact_mut(length).map(move |row| &mut row[first..])
}

impl Source {
    /// Adds the values times the rows of a kernel to the sums for N blocks in each row.
    #[inline(always)]
    fn add<'a, const N: usize>(
        &self,
        kernel: impl Iterator<Item = &'a [f32]>,
        sums: impl Iterator<Item = &'a mut [[f32; LANES]]>,
    ) {
        // The compiler knows the lengths of the loops over lanes.
        match self.filled {
            1 => self.add_lanes::<N, 1>(kernel, sums),
            2 => self.add_lanes::<N, 2>(kernel, sums),
            3 => self.add_lanes::<N, 3>(kernel, sums),
            4 => self.add_lanes::<N, 4>(kernel, sums),
            5 | 6 => self.add_lanes::<N, 6>(kernel, sums),
            _ => self.add_lanes::<N, LANES>(kernel, sums),
        }
    }

    #[inline(always)]
    fn add_lanes<'a, const N: usize, const L: usize>(
        &self,
        kernel: impl Iterator<Item = &'a [f32]>,
        sums: impl Iterator<Item = &'a mut [[f32; LANES]]>,
    ) {
        for (kernel, sums) in kernel.zip(sums) {
            let sums: &mut [[f32; LANES]; N] = sums.first_chunk_mut().expect("blocks of a row");
            let mut added = *sums;
            for (value, lane) in self.values.iter().zip(&self.lanes).take(L) {
                let kernel: &[[f32; LANES]; N] = kernel[LANES - 1 - *lane as usize % LANES..]
                    .as_chunks()
                    .0
                    .first_chunk()
                    .expect("a kernel as long as its sums");
                for (sum, kernel) in added.iter_mut().zip(kernel) {
                    sum.iter_mut().zip(kernel).for_each(|(sum, kernel)| *sum += value * kernel);
                }
            }
            *sums = added;
        }
    }
}
