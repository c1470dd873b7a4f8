//! Few points of a surface in blocks, with the compliance between them and its preconditioner.

use std::array::from_fn;
use std::ops::Range;

use gfmd_response::{Blocks, COARSENING, Cells, LANES, Scattered, ScatteredMemory};
use gfmd_vector::{Serialise, Share};
use multiversion::multiversion;
use rayon::prelude::*;

use crate::Contact;
use crate::pull_push::PullPush;

/// Number of blocks that one thread handles alone, and number of their points.
const FEW: usize = 64;
const STRETCH: usize = FEW * LANES;

/// Blocks of points, with the compliance G between them and a preconditioner M, which is about the inverse of G between
/// the free points. Vectors of all processes have all points; the processes divide the products, and exchange them.
///
/// M continues a gap from the points in contact to the coarse grid, as the preconditioner of the whole surface does
/// ([`PullPush`]), with the mean gap of a coarse cell in place of the mean of four points. The part interpolated from
/// there is stiffened on the coarse grid, and the rest of the gap by the stiffness between near points:
/// `M = Eᵀ Iᵀ K I E + (1 − I E)ᵀ S (1 − I E)` with the continuation E and the interpolation I.
pub(crate) struct Points {
    scattered: Scattered,
    memory: ScatteredMemory,
    blocks: Blocks,
    extension: PullPush,
    /// Rest of the gap at the points.
    rest: Vec<f32>,
    /// 1 for free points, else 0.
    free: Vec<f32>,
    /// Number of transform pairs on the coarse grid.
    pairs: u64,
}

impl Points {
    /// Makes the blocks at these `places`. `floating` has the meaning of [`PullPush::new`].
    pub(crate) fn new(contact: &Contact, scattered: Scattered, floating: bool, places: Vec<usize>) -> Self {
        let cells = scattered.coarse().points();
        Self {
            memory: scattered.memory(),
            blocks: Blocks::new(contact.response.grid(), places),
            extension: PullPush::on_cells(cells, floating, contact.stiffness_of_waves()).cells_over(scattered.rows()),
            scattered,
            rest: Vec::new(),
            free: Vec::new(),
            pairs: 0,
        }
    }

    /// Moves to the blocks at other places.
    pub(super) fn move_to(&mut self, contact: &Contact, places: Vec<usize>) {
        self.blocks = Blocks::new(contact.response.grid(), places);
    }

    pub(crate) fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    /// Frees memory until the next image.
    pub(super) fn release(&mut self) {
        (self.rest, self.free) = Default::default();
        self.memory.release();
    }

    /// Returns the unit of compliances, in length/stress.
    pub(crate) fn unit(&self) -> f64 {
        self.scattered.unit()
    }

    /// Returns the number of transforms so far, in pairs of transforms of the whole surface.
    pub(crate) fn pairs(&self) -> f64 {
        self.pairs as f64 * self.scattered.effort()
    }

    /// Returns the counter of [`pairs`](Self::pairs).
    pub(super) fn counter(&mut self) -> &mut u64 {
        &mut self.pairs
    }

    /// Returns true if M maps constants to zero.
    pub(crate) fn keeps_constants(&self) -> bool {
        self.extension.keeps_constants()
    }

    /// Computes `out` = G `pressure` divided by the unit.
    pub(crate) fn displace(&mut self, pressure: &[f32], out: &mut [f32]) {
        self.pairs += 1;
        self.scattered.compliance(&self.blocks, pressure, &mut self.memory, out);
        self.scattered.complete(&self.blocks, out);
    }

    /// Computes `out` = M g times the unit, with the gaps g of the points of each block from `gaps`; zero if a point is
    /// not free. Free points are in contact, or about to enter: with a negative gap below the gap continued to them.
    pub(crate) fn press(&mut self, gaps: impl Fn(usize) -> Gaps + Sync, out: &mut [f32]) {
        self.pairs += 1;
        // Points outside the coupled blocks keep stale values.
        for vector in [&mut self.rest, &mut self.free] {
            vector.resize(out.len(), 0.0);
        }
        let Self { scattered, memory, blocks, extension, rest, free, .. } = self;
        let (columns, first) = (scattered.coarse().points()[1], scattered.rows().rows().start);
        let (own, coupled) = (scattered.own(blocks), scattered.coupled(blocks));
        let blocks_of = |some: &Range<usize>, stretch: usize| {
            some.start + stretch * FEW..some.end.min(some.start + (stretch + 1) * FEW)
        };
        let (weights, values) = extension.cells();
        let cells = weights.par_chunks_mut(columns).zip(values.par_chunks_mut(columns));
        cells.enumerate().for_each(|(row, cells)| pull(blocks, first + row, &gaps, cells));
        extension.fill_cells();
        scattered.interpolate(blocks, extension.cells().1, memory, out);
        for some in &coupled {
            let [far, rest, free] = [&mut *out, rest, free].map(|vector| values_of(vector, some));
            let points = far.par_chunks_mut(STRETCH).zip(rest.par_chunks_mut(STRETCH));
            points.zip(free.par_chunks_mut(STRETCH)).enumerate().for_each(|(stretch, ((far, rest), free))| {
                take_away(blocks_of(some, stretch), &gaps, far, (rest, free));
            });
        }
        scattered.stiffness(blocks, rest, memory, out);
        gfmd_vector::for_each((values_of(out, &own), &*values_of(free, &own)), &|_, (out, free)| {
            out.iter_mut().zip(free).for_each(|(out, free)| *out *= free);
        });
        scattered.stiffen(blocks, extension.cells().1, out, memory);
        extension.fill_cells_transposed();
        let (weights, values) = extension.cells();
        gfmd_vector::for_each((values, &*weights), &|_, (values, weights)| divide(values, weights));
        let cells = scattered.cells(blocks, extension.cells().1);
        values_of(out, &own).par_chunks_mut(STRETCH).enumerate().for_each(|(stretch, out)| {
            push((blocks, blocks_of(&own, stretch)), &gaps, (&cells, scattered.coarse().points()), out);
        });
        out[blocks.len() * LANES..].fill(0.0);
        scattered.complete(blocks, out);
    }
}

/// Returns the values of these blocks.
fn values_of<'a>(values: &'a mut [f32], blocks: &Range<usize>) -> &'a mut [f32] {
    &mut values[blocks.start * LANES..blocks.end * LANES]
}

/// Gaps of the points of a block.
#[derive(Clone, Copy)]
pub(crate) struct Gaps {
    /// True for points in contact.
    pub(crate) touches: [bool; LANES],
    pub(crate) gap: [f32; LANES],
}

/// Number of coarse cells with points of a block. A coarse cell has the points around its coarse point.
const CELLS: usize = LANES / COARSENING + 1;

/// Returns the number of the cell, among these, that contains a lane.
const fn cell_of(lane: usize) -> usize {
    (lane + COARSENING / 2) / COARSENING
}

/// Returns the cells of a row, out of `columns` cells, with points of the block in this column.
#[inline(always)]
fn cells_of(column: usize, columns: usize) -> [usize; CELLS] {
    let first = column * (LANES / COARSENING);
    from_fn(|k| if first + k < columns { first + k } else { 0 })
}

/// Writes the numbers of points in contact, and their mean gaps, into a row of coarse cells.
#[multiversion(targets = "simd")]
fn pull<F: Fn(usize) -> Gaps>(blocks: &Blocks, row: usize, gaps: F, (weights, values): (&mut [f32], &mut [f32])) {
    weights.fill(0.0);
    values.fill(0.0);
    let (rows, columns) = (blocks.rows(), weights.len());
    let near = (0..COARSENING).map(|k| (row * COARSENING + k + rows - COARSENING / 2) % rows);
    for block in near.flat_map(|row| blocks.in_row(row)) {
        let Gaps { touches, gap } = gaps(block);
        let mut sums = [[0.0; 2]; CELLS];
        for lane in 0..LANES {
            let [weight, value] = &mut sums[cell_of(lane)];
            *weight += if touches[lane] { 1.0 } else { 0.0 };
            *value += if touches[lane] { gap[lane] } else { 0.0 };
        }
        for (cell, [weight, value]) in cells_of(blocks.column(block), columns).into_iter().zip(sums) {
            weights[cell] += weight;
            values[cell] += value;
        }
    }
    divide(values, weights);
}

/// Divides sums over cells by the numbers of points in contact; zero if there are none.
#[inline(always)]
fn divide(values: &mut [f32], weights: &[f32]) {
    for (value, weight) in values.iter_mut().zip(weights) {
        *value = if *weight > 0.0 { *value / *weight } else { 0.0 };
    }
}

/// Sets `rest` to the gaps of free points minus the gaps continued to them, and `free` to 1 at these points.
#[multiversion(targets = "simd")]
fn take_away<F: Fn(usize) -> Gaps>(
    blocks: Range<usize>,
    gaps: F,
    continued: &[f32],
    (rest, free): (&mut [f32], &mut [f32]),
) {
    let (rest, free) = (rest.as_chunks_mut::<LANES>().0, free.as_chunks_mut::<LANES>().0);
    for (block, (far, (rest, free))) in
        blocks.zip(continued.as_chunks::<LANES>().0.iter().zip(rest.iter_mut().zip(free)))
    {
        let Gaps { touches, gap } = gaps(block);
        for lane in 0..LANES {
            let is_free = touches[lane] | ((gap[lane] < 0.0) & (gap[lane] < far[lane]));
            rest[lane] = if is_free { gap[lane] - far[lane] } else { 0.0 };
            free[lane] = if is_free { 1.0 } else { 0.0 };
        }
    }
}

/// Adds to `out`, at the points in contact, their parts of the `values` of coarse cells: the transpose of [`pull`].
#[multiversion(targets = "simd")]
fn push<F: Fn(usize) -> Gaps>(
    (blocks, some): (&Blocks, Range<usize>),
    gaps: F,
    (cells, [rows, columns]): (&Cells, [usize; 2]),
    out: &mut [f32],
) {
    for (block, out) in some.zip(out.as_chunks_mut::<LANES>().0) {
        let row = (blocks.row(block) + COARSENING / 2) / COARSENING % rows;
        let values = cells.row(row);
        let parts = cells_of(blocks.column(block), columns).map(|cell| values[cell]);
        let Gaps { touches, .. } = gaps(block);
        for lane in 0..LANES {
            out[lane] += if touches[lane] { parts[cell_of(lane)] } else { 0.0 };
        }
    }
}

/// Returns true if there are blocks, with at most the fraction `most` of all points.
pub(crate) fn are_few(places: &[usize], most: f64, points: usize) -> bool {
    !places.is_empty() && (places.len() * LANES) as f64 <= most * points as f64
}

/// Returns the blocks in the own rows: the ranges of their values among all blocks, and among the own rows.
pub(crate) fn own_blocks(blocks: &Blocks, share: &Share) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
    let own = share.own();
    let all = blocks.places().iter().map(|place| place * LANES).enumerate();
    let here = all.filter(move |(_, first)| own.contains(first));
    let start = share.own().start;
    here.map(move |(number, first)| (number * LANES..(number + 1) * LANES, first - start..first - start + LANES))
}

/// Gathers the values at the points of the blocks, from a field with the `own` rows.
pub(crate) fn at_points<T: Copy + Serialise + Sync>(blocks: &Blocks, share: &Share, own: &[T]) -> Vec<T> {
    let values = own.as_chunks::<LANES>().0;
    of_points(blocks, share, |block| values[block])
}

/// Gathers the values of a function of the blocks of this process at the points of the blocks.
pub(super) fn of_points<T: Copy + Serialise + Sync>(
    blocks: &Blocks,
    share: &Share,
    of: impl Fn(usize) -> [T; LANES] + Sync,
) -> Vec<T> {
    let [first, end] = [share.own().start, share.own().end].map(|point| point / LANES);
    let places = blocks.places();
    let here = &places[places.partition_point(|place| *place < first)..places.partition_point(|place| *place < end)];
    let here = here.par_iter().with_min_len(FEW).map(|place| of(place - first));
    gathered(share, here.collect::<Vec<_>>().into_flattened())
}

/// Gathers `own` from all processes.
pub(crate) fn gathered<T: Copy + Serialise>(share: &Share, own: Vec<T>) -> Vec<T> {
    if share.is_whole() { own } else { share.collect(&own, &share.each(own.len())) }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use gfmd_field::Grid;
    use gfmd_green::{Body, Material};
    use gfmd_surface::{Discretisation, SelfAffine};
    use gfmd_vector::{Ranks, ThreadRanks};

    use super::*;

    /// Returns the blocks with the highest points of a rough surface, a fraction `part` of all, and flags that mark
    /// these points.
    fn highest(height: Option<f64>, part: f64) -> (Points, Vec<bool>) {
        let material = Material::from_contact_modulus(1.0, 0.0).unwrap();
        let body = height.map_or_else(|| Body::half_space(material), |height| Body::slab(material, height).unwrap());
        let grid = Grid::square(256, 1.0).unwrap();
        let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 32.0, eps_c_inv: 4.0 };
        let surface = SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) };
        let heights = numbers.self_affine(1.0, surface).heights(&grid, 1).unwrap();
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        let heights = heights.as_slice().unwrap();
        let mut sorted = heights.to_vec();
        sorted.sort_by(f64::total_cmp);
        let cut = sorted[((1.0 - part) * sorted.len() as f64) as usize];
        let blocks = heights.as_chunks::<LANES>().0.iter().enumerate();
        let places: Vec<usize> =
            blocks.filter(|(_, block)| block.iter().any(|h| *h > cut)).map(|(place, _)| place).collect();
        let scattered = Scattered::of(&contact.response, [0.0; 2]).unwrap();
        let points = Points::new(&contact, scattered, true, places);
        let touches = at_points(points.blocks(), &contact.share, heights).into_iter().map(|h| h > cut).collect();
        (points, touches)
    }

    fn press(points: &mut Points, touches: &[bool], gap: &[f32]) -> Vec<f32> {
        // Stale values of other points do not matter.
        let mut out = vec![1e9; gap.len()];
        let (touches, gap) = (touches.as_chunks().0, gap.as_chunks().0);
        points.press(|block| Gaps { touches: touches[block], gap: gap[block] }, &mut out);
        out
    }

    #[test]
    fn the_preconditioner_is_near_the_inverse_of_the_compliance() {
        for (height, part) in [(None, 0.003), (None, 0.02), (None, 0.06), (Some(0.2), 0.02)] {
            let (mut points, touches) = highest(height, part);
            let count = touches.iter().filter(|touches| **touches).count() as f32;
            for k in 0..12 {
                // Pressures from noise to smooth ones, without a sum.
                let wave = |i: usize| (0.37 + 0.1 * 2.0_f32.powi(k) * i as f32).sin();
                let only = |i: usize, p: f32| if touches[i] { p } else { 0.0 };
                let all: Vec<f32> = (0..touches.len()).map(|i| only(i, wave(i))).collect();
                let mean = all.iter().sum::<f32>() / count;
                let pressure: Vec<f32> = all.iter().enumerate().map(|(i, p)| only(i, p - mean)).collect();
                let mut gap = vec![0.0; pressure.len()];
                points.displace(&pressure, &mut gap);
                // No other point is about to enter.
                let gap: Vec<f32> = gap.iter().enumerate().map(|(i, g)| only(i, *g)).collect();
                let z = press(&mut points, &touches, &gap);
                let quotient = gfmd_vector::dot(&gap, &z) / gfmd_vector::dot(&gap, &pressure);
                assert!((0.75..2.0).contains(&quotient), "{height:?} {part} {k}: {quotient}");
                assert!(z.iter().zip(&touches).all(|(z, touches)| *touches || *z == 0.0));
            }
        }
    }

    #[test]
    fn the_preconditioner_is_symmetric_and_has_no_image_of_constants() {
        let (mut points, touches) = highest(None, 0.02);
        assert!(points.keeps_constants());
        let [a, b] = [0.7_f32, 1.9].map(|seed| {
            let gap = |i: usize| if touches[i] { (seed * i as f32).sin() } else { 0.0 };
            (0..touches.len()).map(gap).collect::<Vec<f32>>()
        });
        let [m_a, m_b] = [&a, &b].map(|gap| press(&mut points, &touches, gap));
        let [cross, transposed, own] = [(&a, &m_b), (&b, &m_a), (&a, &m_a)].map(|(a, b)| gfmd_vector::dot(a, b));
        assert!((cross - transposed).abs() < 1e-5 * own && own > 0.0, "{cross} {transposed} {own}");
        let constant = press(&mut points, &touches, &vec![1.0; touches.len()]);
        let largest = |values: &[f32]| values.iter().fold(0.0, |largest: f32, z| largest.max(z.abs()));
        assert!(largest(&constant) < 1e-5 * largest(&m_a), "{} {}", largest(&constant), largest(&m_a));
    }

    #[test]
    fn processes_divide_the_products_and_get_the_bits_of_one() {
        let (alone, touches) = highest(None, 0.02);
        let places = alone.blocks().places().to_vec();
        let grid = Grid::square(256, 1.0).unwrap();
        let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
        let gap: Vec<f32> = (0..touches.len()).map(|i| if touches[i] { (0.7 * i as f32).sin() } else { 0.0 }).collect();
        let products = |ranks: Arc<dyn Ranks>| {
            let share = Contact::share(ranks, &grid).unwrap();
            let heights = ndarray::Array2::from_shape_fn((share.rows().len(), 256), |(_, j)| (j % 7) as f64);
            let contact = Contact::distributed(&share, &body, &grid, &heights).unwrap();
            let scattered = Scattered::of(&contact.response, [0.0; 2]).unwrap();
            let mut points = Points::new(&contact, scattered, true, places.clone());
            let mut image = vec![0.0; gap.len()];
            points.displace(&gap, &mut image);
            let pressed = press(&mut points, &touches, &gap);
            let all = image.iter().chain(&pressed).map(|value| value.to_bits()).collect::<Vec<_>>();
            (all, points.memory.computed())
        };
        let one = ThreadRanks::of(1, products).remove(0);
        for size in 2..=4 {
            let each = ThreadRanks::of(size, products);
            assert!(each.iter().all(|(all, _)| *all == one.0), "{size}");
            let most = each.iter().map(|(_, work)| *work).max().unwrap();
            // Points near the own rows are interpolated, too.
            assert!((most as f64) < 1.25 * one.1 as f64 / size as f64, "{size}: {most} of {}", one.1);
        }
    }

    #[test]
    fn points_about_to_enter_are_free() {
        let (mut points, touches) = highest(None, 0.02);
        let outside: [usize; 2] = {
            let mut outside = (0..touches.len()).filter(|i| !touches[*i]);
            from_fn(|_| outside.nth(50).unwrap())
        };
        let mut gap: Vec<f32> = touches.iter().map(|touches| if *touches { 0.1 } else { 1.0 }).collect();
        gap[outside[0]] = -1.0;
        let z = press(&mut points, &touches, &gap);
        assert!(z[outside[0]] < 0.0, "{}", z[outside[0]]);
        assert_eq!(z[outside[1]], 0.0);
    }
}
