//! Fields on few blocks of points: every process knows the values at all of them, and owns rows of the whole field.

use std::ops::Range;

use gfmd_field::Grid;
use gfmd_response::{Blocks, LANES, Scattered};
use gfmd_vector::{Parcel, Share};

/// The largest part of the points that may be in blocks.
pub(super) const MOST: f64 = 0.06;

/// The largest number of pairs of blocks, for each point of the grid.
const PAIRS: f64 = 0.5;

/// The blocks at these places; `None` if there are none, or so many that transforms of the whole surface take less time.
pub(crate) fn few_blocks(scattered: &Scattered, grid: &Grid, places: Vec<usize>) -> Option<Blocks> {
    let points = grid.len() as f64;
    let few = !places.is_empty() && (places.len() * LANES) as f64 <= MOST * points;
    few.then(|| Blocks::new(scattered, grid, places, (PAIRS * points) as usize)).flatten()
}

/// The blocks in the own rows: the places of their values among those of all blocks, and among the own rows.
pub(crate) fn own_blocks(blocks: &Blocks, share: &Share) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
    let own = share.own();
    let all = blocks.places().iter().map(|place| place * LANES).enumerate();
    let here = all.filter(move |(_, first)| own.contains(first));
    let start = share.own().start;
    here.map(move |(number, first)| (number * LANES..(number + 1) * LANES, first - start..first - start + LANES))
}

/// The values at the points of the blocks, of a field with these `own` rows.
pub(crate) fn at_points<T: Copy + Parcel>(blocks: &Blocks, share: &Share, own: &[T]) -> Vec<T> {
    let here = own_blocks(blocks, share).flat_map(|(_, row)| &own[row]);
    gathered(share, &here.copied().collect::<Vec<_>>())
}

/// The values of all processes, of which `own` are the own ones.
pub(crate) fn gathered<T: Copy + Parcel>(share: &Share, own: &[T]) -> Vec<T> {
    if share.is_whole() { own.to_vec() } else { share.collect(own, &share.each(own.len())) }
}
