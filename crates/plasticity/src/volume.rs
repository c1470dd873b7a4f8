//! The waves of the volume below the surface, and the cells that have them.

use std::ops::Range;
use std::sync::Arc;

use gfmd_field::{Grid, Mode, Real, Share, Transform};
use gfmd_green::{Blocks, Body, Ground};
use rayon::prelude::*;

use crate::cells::{Below, Cell, Mesh};
use crate::pack::{Pack, WIDTH};
use crate::sweep::{self, Support, Waves};

/// Number of components of a deviatoric strain.
pub(crate) const COMPONENTS: usize = 5;

/// Volume of a body on a grid, described by its cells and by the stiffness of what lies below them. Shared by all
/// operators on it.
#[derive(Debug)]
pub(crate) struct Volume {
    pub(crate) mesh: Arc<Mesh>,
    /// Lanes of the half spectrum of this process.
    pub(crate) lanes: Range<usize>,
    /// Packs of wave vectors, lane after lane of this process.
    pub(crate) packs: Vec<WavePack>,
    /// Places of the components that do not vanish: all of them, or three in plane strain.
    pub(crate) components: Vec<usize>,
    /// Number of the level of each cell.
    pub(crate) levels: Vec<usize>,
    /// Cells with one grid have one level; the first level is the full grid.
    pub(crate) scales: Vec<Scale>,
}

/// Grid of a level, and the modes of the full grid that it has.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    pub(crate) grid: Grid,
    /// Number of lanes with modes that are not Nyquist; all lanes on the full grid.
    pub(crate) lanes: usize,
    /// Places of each pack in a lane of this grid.
    pub(crate) places: Vec<Places>,
    /// Rows of this process.
    pub(crate) share: Share,
    /// Lanes of each process: those that it has of the full grid.
    owned: Vec<Range<usize>>,
}

/// Places of the modes of a pack in a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Places {
    /// Neighbours from this place on.
    From(usize),
    /// One by one; [`NOWHERE`] for modes that the grid does not have.
    Each([u32; WIDTH]),
}

/// Place of a mode that a grid does not have.
const NOWHERE: u32 = u32::MAX;

impl Places {
    fn new(each: [u32; WIDTH]) -> Self {
        let neighbours = each.windows(2).all(|pair| pair[0] != NOWHERE && pair[1] == pair[0] + 1);
        if neighbours { Self::From(each[0] as usize) } else { Self::Each(each) }
    }
}

/// Neighbouring wave vectors of a lane.
#[derive(Clone, Debug)]
pub(crate) struct WavePack {
    /// Number of cells, from the surface, with a grid that has one of these waves.
    pub(crate) depth: usize,
    /// Stiffness below these cells.
    pub(crate) support: Support,
    pub(crate) waves: Waves,
    /// Set if a wave is Nyquist.
    pub(crate) flipped: Option<Box<Flipped>>,
}

/// Waves of a pack with one Nyquist component reversed, which the grid cannot distinguish from the waves themselves.
#[derive(Clone, Debug)]
pub(crate) struct Flipped {
    pub(crate) waves: Waves,
    /// Shares of the stored waves and of these in the mean.
    pub(crate) shares: [Pack; 2],
}

/// Stiffness of a rigid ground divided by the stiffness of a cell above it: so large that the displacement of the
/// ground vanishes in double precision.
const RIGID: f64 = 1e40;

/// Share of the stored wave vector in the mean over the waves that the grid cannot distinguish, for a mode that is
/// Nyquist along one axis, and along both. A wave with both components reversed is the same wave, so that two remain.
/// In the corner the mean is taken along x first, then along y, where the reversed wave counts as well: contacts with
/// mirrored surfaces differ a little there.
const STORED: [f64; 2] = [0.5, 0.75];

/// Returns the share of each wave of a pack in the mean over the waves that the grid cannot distinguish, and the share
/// of the wave with one Nyquist component reversed.
fn shares(grid: &Grid, lane: usize, pack: usize) -> [Pack; 2] {
    let [_, positions] = grid.spectrum_shape();
    let (mut first, mut second) = (Pack::all(1.0), Pack::ZERO);
    for k in 0..WIDTH.min(positions - pack * WIDTH) {
        let nyquist = grid.mode(lane, pack * WIDTH + k).nyquist;
        if let Some(last) = nyquist.iter().filter(|nyquist| **nyquist).count().checked_sub(1) {
            first.0[k] = STORED[last];
            second.0[k] = 1.0 - STORED[last];
        }
    }
    [first, second]
}

/// Returns the wave vectors of a pack, or those with one Nyquist component `flipped`. Places beyond the lane repeat its
/// last mode; the uniform mode gets a wavenumber of one, since its strain is computed apart.
fn waves(grid: &Grid, lane: usize, pack: usize, flipped: bool) -> Waves {
    let [_, positions] = grid.spectrum_shape();
    let mut waves = Waves { wavenumber: Pack::all(1.0), direction: [Pack::all(1.0), Pack::ZERO] };
    for k in 0..WIDTH {
        let mode = grid.mode(lane, (pack * WIDTH + k).min(positions - 1));
        if mode.is_uniform() {
            continue;
        }
        let q = mode.wavenumber();
        waves.wavenumber.0[k] = q;
        let flips = [mode.nyquist[0] && !mode.nyquist[1], mode.nyquist[1]];
        for (axis, flip) in flips.into_iter().enumerate() {
            let sign = if flipped && flip { -1.0 } else { 1.0 };
            waves.direction[axis].0[k] = sign * mode.wavevector[axis] / q;
        }
    }
    waves
}

/// Returns true if the grid of a cell has the mode. A coarser grid has no Nyquist modes.
fn has(cell: &Cell, points: [usize; 2], mode: &Mode) -> bool {
    cell.coarsening == 1
        || (0..2).all(|axis| {
            let coarse = points[axis].div_ceil(cell.coarsening) as u64;
            points[axis] == 1 || 2 * mode.number[axis].unsigned_abs() < coarse
        })
}

impl Scale {
    fn new(full: &Grid, coarsening: usize, share: &Share, owned: &[Range<usize>]) -> Self {
        let points = full.points().map(|points| points.div_ceil(coarsening));
        let grid = Grid::new(points, full.lengths()).expect("a grid with fewer points is a grid");
        let [lanes, positions] = full.spectrum_shape();
        let places = (0..positions.div_ceil(WIDTH)).map(|pack| {
            Places::new(std::array::from_fn(|k| {
                let position = pack * WIDTH + k;
                if position >= positions {
                    return NOWHERE;
                }
                let [number, _] = full.mode(0, position).number;
                let coarse = points[0] as i64;
                let has = coarsening == 1 || points[0] == 1 || 2 * number.abs() < coarse;
                if has {
                    if full.is_line() { position as u32 } else { number.rem_euclid(coarse) as u32 }
                } else {
                    NOWHERE
                }
            }))
        });
        let lanes = if coarsening == 1 || full.is_line() { lanes } else { points[1].div_ceil(2) };
        let [all, _] = grid.spectrum_shape();
        let owned = owned.iter().map(|own| own.start.min(all)..own.end.min(all)).collect();
        Self { grid, lanes, places: places.collect(), share: share.clone(), owned }
    }

    /// Plans the transforms.
    pub(crate) fn transform<T: Real>(&self) -> Transform<T> {
        Transform::with_lanes(self.grid, &self.share, &self.owned)
    }

    /// Returns the number of points of this process.
    pub(crate) fn points(&self) -> usize {
        self.share.own().len()
    }

    /// Returns the number of modes of this process.
    pub(crate) fn modes(&self) -> usize {
        let [_, positions] = self.grid.spectrum_shape();
        self.owned[self.share.ranks().rank()].len() * positions
    }
}

fn support_of(blocks: &Blocks) -> [f64; 4] {
    [blocks.longitudinal, blocks.coupling[0], blocks.normal, blocks.transverse]
}

fn ground_support(ground: Ground, lowest: &Cell) -> [f64; 4] {
    let rigid = RIGID * lowest.p_wave_modulus / lowest.thickness;
    let of = |condition| if condition == gfmd_green::Condition::Fixed { rigid } else { 0.0 };
    [of(ground.lateral), 0.0, of(ground.normal), of(ground.lateral)]
}

impl Volume {
    pub(crate) fn new(mesh: Mesh) -> Self {
        let (grid, cells, surface) = (mesh.grid, &mesh.cells, &mesh.division.surface);
        let [_, positions] = grid.spectrum_shape();
        let per_lane = positions.div_ceil(WIDTH);
        let lanes = Transform::<f64>::distributed(grid, surface).lanes();
        let owned: Vec<Range<usize>> =
            surface.each([lanes.start, lanes.end]).into_iter().map(|[start, end]| start..end).collect();
        let of_pack = |index: usize| {
            let (lane, pack) = (lanes.start + index / per_lane, index % per_lane);
            let modes: Vec<Mode> =
                (pack * WIDTH..((pack + 1) * WIDTH).min(positions)).map(|position| grid.mode(lane, position)).collect();
            let held = |cell: &Cell| modes.iter().any(|mode| has(cell, grid.points(), mode));
            let depth = cells.iter().rposition(held).map_or(0, |last| last + 1);
            let waves = waves(&grid, lane, pack, false);
            let is_nyquist = modes.iter().any(|mode| mode.nyquist.contains(&true));
            let flipped = is_nyquist.then(|| {
                Box::new(Flipped { waves: self::waves(&grid, lane, pack, true), shares: shares(&grid, lane, pack) })
            });
            let mut support = [Pack::ZERO; 4];
            for k in 0..WIDTH {
                let entries = match &mesh.below {
                    Below::Body(body) => support_of(&Body::stiffness_blocks(body, waves.wavenumber.0[k])),
                    Below::Ground(ground) => ground_support(*ground, &cells[cells.len() - 1]),
                };
                support.iter_mut().zip(entries).for_each(|(pack, entry)| pack.0[k] = entry);
            }
            let support = sweep::stiffness(&cells[depth..], waves.wavenumber, &support);
            WavePack { depth, support, waves, flipped }
        };
        let packs = (0..lanes.len() * per_lane).into_par_iter().with_min_len(16).map(of_pack).collect();
        let mut coarsenings: Vec<usize> = cells.iter().map(|cell| cell.coarsening).chain([1]).collect();
        coarsenings.sort_unstable();
        coarsenings.dedup();
        let of_cell = |cell: &Cell| coarsenings.partition_point(|coarsening| *coarsening < cell.coarsening);
        let levels = cells.iter().map(of_cell).collect();
        let scale = |coarsening: &usize| {
            let cell = cells.iter().position(|cell| cell.coarsening == *coarsening);
            let share = cell.map_or(surface, |cell| mesh.division.of(cell));
            Scale::new(&grid, *coarsening, share, &owned)
        };
        let scales = coarsenings.iter().map(scale).collect();
        let components = match grid.points() {
            [_, 1] => vec![0, 1, 3],
            [1, _] => vec![0, 1, 4],
            _ => (0..COMPONENTS).collect(),
        };
        Self { lanes, mesh: Arc::new(mesh), packs, components, levels, scales }
    }
}
