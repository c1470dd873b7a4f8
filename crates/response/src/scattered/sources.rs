use std::ops::Range;

use multiversion::multiversion;
use rayon::prelude::*;

use super::stencil::Stencil;
use super::{Blocks, LANES};

/// The blocks with values that are not zero. Those of a row come first at the place of its blocks.
#[derive(Debug, Default)]
pub(super) struct Sources(Vec<Source>);

#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    column: u32,
    /// A bit for each lane whose value is not zero; none behind the last source of a row.
    filled: u32,
    values: [f32; LANES],
}

const END: Source = Source { column: 0, filled: 0, values: [0.0; LANES] };

impl Source {
    /// The column among those of the grid's blocks.
    pub(super) fn column(&self) -> usize {
        self.column as usize
    }
}

/// The number of rows whose sums are computed together.
const TILE: usize = 16;

impl Sources {
    /// Takes the `values` of the points of the blocks.
    pub(super) fn take(&mut self, blocks: &Blocks, values: &[f32]) {
        let values = values.as_chunks::<LANES>().0;
        self.0.resize(blocks.len(), END);
        blocks.for_rows(1, 1, &mut self.0, &|row, sources| {
            let mut number = 0;
            for block in blocks.in_row(row.start) {
                let values = values[block];
                let filled = (0..LANES).map(|lane| u32::from(values[lane] != 0.0) << lane).sum();
                // The next one overwrites a block without values.
                sources[number] = Source { column: blocks.column(block) as u32, filled, values };
                number += usize::from(filled != 0);
            }
            if let Some(end) = sources.get_mut(number) {
                *end = END;
            }
        });
    }

    /// The sources of a row, and the place of the first one among all.
    pub(super) fn in_row(&self, blocks: &Blocks, row: usize) -> (&[Source], usize) {
        let places = blocks.in_row(row);
        let sources = &self.0[places.clone()];
        let number = sources.iter().position(|source| source.filled == 0);
        (&sources[..number.unwrap_or(sources.len())], places.start)
    }

    /// The values at all places, of which some have no source.
    pub(super) fn values(&self) -> impl IndexedParallelIterator<Item = &[f32; LANES]> {
        self.0.par_iter().map(|source| &source.values)
    }

    /// `out` ← for each point of the blocks the sum over all values times the kernel to this point, and `more` of its block.
    pub(super) fn sum<const N: usize>(
        &self,
        stencil: &Stencil<N>,
        blocks: &Blocks,
        out: &mut [f32],
        more: impl Fn(usize) -> [f32; LANES] + Sync,
    ) {
        let width = blocks.width();
        // Behind the ends of a row lie the sums for the blocks at its opposite end.
        let (beyond, length) = (N / 2, width + N - 1);
        blocks.for_rows(TILE, LANES, out, &|rows, out| {
            let mut sums = vec![[0.0; LANES]; rows.len() * length];
            sum(self, stencil, blocks, rows.clone(), &mut sums);
            let out = &mut out.as_chunks_mut().0.iter_mut();
            for (row, sums) in rows.zip(sums.chunks_exact(length)) {
                for (block, out) in blocks.in_row(row).zip(&mut *out) {
                    let column = blocks.column(block);
                    let opposite =
                        [(column + beyond).checked_sub(width), (column < beyond).then_some(column + width + beyond)];
                    *out = more(block);
                    for place in [Some(column + beyond)].into_iter().chain(opposite).flatten() {
                        out.iter_mut().zip(sums[place]).for_each(|(out, sum)| *out += sum);
                    }
                }
            }
        });
    }
}

/// Adds to the sums for some rows the values of all sources that are near, times the kernel.
#[multiversion(targets = "simd")]
fn sum<const N: usize>(
    sources: &Sources,
    stencil: &Stencil<N>,
    blocks: &Blocks,
    targets: Range<usize>,
    sums: &mut [[f32; LANES]],
) {
    let (rows, reach) = (blocks.rows(), stencil.reach());
    let length = sums.len() / targets.len();
    // The row of the sources, plus the reach.
    for ahead in targets.start..targets.end + 2 * reach {
        let near = targets.start.max(ahead.saturating_sub(2 * reach))..targets.end.min(ahead + 1);
        for source in sources.in_row(blocks, (ahead + rows - reach) % rows).0 {
            for target in near.clone() {
                let first = (target - targets.start) * length + source.column();
                let sums: &mut [[f32; LANES]; N] = sums[first..].first_chunk_mut().expect("blocks of a row");
                add(source, stencil.row(target + 2 * reach - ahead), sums);
            }
        }
    }
}

/// Adds the values of a source times a row of the kernel.
#[inline(always)]
fn add<const N: usize>(source: &Source, kernel: &[f32], sums: &mut [[f32; LANES]; N]) {
    // In registers.
    let mut added = *sums;
    let mut filled = source.filled;
    while filled != 0 {
        let lane = filled.trailing_zeros() as usize % LANES;
        filled &= filled - 1;
        let value = source.values[lane];
        let kernel: &[[f32; LANES]; N] =
            kernel[LANES - 1 - lane..].as_chunks().0.first_chunk().expect("a kernel as long as its sums");
        for (sum, kernel) in added.iter_mut().zip(kernel) {
            sum.iter_mut().zip(kernel).for_each(|(sum, kernel)| *sum += value * kernel);
        }
    }
    *sums = added;
}
