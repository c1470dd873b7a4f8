//! Response of a body between few points of a grid.

mod blocks;
mod near_part;
mod sources;
mod splines;
mod stencil;
mod window;

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};
use std::ops::Range;
use std::sync::Arc;

use gfmd_field::{Grid, Mode, Rows, Share, Transform, Workspace};
use rayon::prelude::*;

pub use blocks::{BlockRows, Blocks};
use near_part::near_part;
use sources::Sources;
use splines::{BEFORE, Lines, ORDER, Splines, repeat};
use stencil::Stencil;
use window::Window;

use crate::NormalResponse;
use crate::elastic::fits;
use crate::units::power_of_two;

/// Compliance between few points of a periodic grid, in single precision, and the parts of an approximate stiffness. It
/// suits contacts so small that transforms of the whole surface would act mostly on zeros.
///
/// The compliance is split as in the Ewald (1921) sum. With g = q G for the shortest waves, the part
/// `g (1 − Φ(r))/(2π r)` vanishes beyond a radius of several points, and is summed over pairs of points. The rest,
/// `g Φ(r)/(2π r)` on a half-space, has hardly any short waves. It is computed on a grid with four times the spacing;
/// B-splines (Essmann et al. 1995) spread pressures to this grid and interpolate displacements from it. Φ is the
/// integral of a Kaiser-Bessel window, which separates short distances from long waves better than Ewald's error
/// function. The error of displacements is at most 4e-4 of the largest one.
///
/// The points come in [`Blocks`] of [`LANES`] neighbours in a row.
///
/// The processes of a distributed response divide the work: each computes the products at its [`own`](Self::own)
/// blocks, and its [`rows`](Self::rows) of the coarse grid. Every process knows all blocks, and all make the same
/// calls.
#[derive(Clone, Debug)]
pub struct Scattered {
    coarse: Arc<Transform<f32>>,
    /// Rows of the coarse grid of each process.
    share: Share,
    /// Compliance of long waves on the coarse grid, divided by the unit.
    smooth: Vec<f32>,
    /// Stiffness of waves interpolated from the coarse grid, times the unit.
    stiffness: Vec<f32>,
    /// Short-wave compliance between two points, divided by the unit.
    near: Arc<Stencil<NEAR>>,
    /// Stiffness between two points times the unit, cut off at a short distance.
    stiff: Arc<Stencil<NEXT>>,
    splines: Arc<Splines>,
    unit: f64,
    /// Part of the compliance of the uniform mode between near points, in length/stress.
    near_uniform: f64,
}

/// Number of rows of points that one task processes.
const ROWS: usize = 16;

/// Number of neighbouring points in a block.
pub const LANES: usize = 8;

/// Spacing of the coarse grid of [`Scattered`], in points.
pub const COARSENING: usize = 4;

/// Distance in points at which short waves have decayed. Ripples along the axes, caused by the spectral cut-off of the
/// grid, are summed up to a longer distance.
const RADIUS: f64 = 10.0;
const REACH: usize = 16;

/// Number of blocks of a row with points within that distance.
const NEAR: usize = 2 * REACH.div_ceil(LANES) + 1;

/// Distance in points up to which the stiffness couples points.
const STIFF: usize = 6;

/// Number of blocks of a row with points within that distance.
const NEXT: usize = 2 * STIFF.div_ceil(LANES) + 1;

/// Each process has a multiple of this number of rows of the coarse grid.
const UNIT: usize = 8;

/// Largest relative difference from a half-space for the shortest waves of the coarse grid.
const DEEP: f64 = 1e-3;

/// Smallest number of points along a cell in which the response to a point has decayed.
const BOX: usize = 2 * REACH + LANES;

impl Scattered {
    /// Returns the split response, with the given compliance (length/stress) and stiffness (stress/length) of the
    /// uniform mode. Returns `None` if the grid is small, elongated or not made of whole blocks and coarse cells, if
    /// layers are only a few points thick, or if the response is tabulated or differs between waves of equal length.
    pub fn of(response: &NormalResponse, [compliance, stiffness]: [f64; 2]) -> Option<Self> {
        let mut scattered = response.scattered()?.clone();
        if scattered.coarse.lanes().contains(&0) {
            // Splines interpolate a constant exactly.
            let splines = (COARSENING * COARSENING) as f64;
            let Self { smooth, stiffness: stiff, near_uniform, unit, .. } = &mut scattered;
            smooth[0] = ((compliance - *near_uniform) / (splines * *unit)) as f32;
            stiff[0] = (stiffness * splines * *unit) as f32;
        }
        Some(scattered)
    }

    /// Splits the response; the uniform mode has neither compliance nor stiffness.
    pub(crate) fn tabulated(response: &NormalResponse) -> Option<Self> {
        if !response.is_isotropic() || response.is_tabulated() {
            return None;
        }
        let grid = response.grid();
        let [nx, ny] = grid.points();
        let small = [nx, ny].map(|points| (BOX..=points / 2).find(|side| points.is_multiple_of(*side)));
        let [Some(rows), Some(columns)] = small else { return None };
        let [wide, narrow] = [f64::max, f64::min].map(|pick| {
            let [x, y] = grid.spacing();
            pick(x, y)
        });
        // Otherwise the reach would be too short along one axis, or have too many points along the other.
        if !nx.is_multiple_of(COARSENING) || !ny.is_multiple_of(LANES) || wide > 1.5 * narrow {
            return None;
        }
        let coarse = Grid::new([nx / COARSENING, ny / COARSENING], grid.lengths()).ok()?;
        // Short waves see a half-space: their compliance times wavenumber does not depend on the wavelength.
        let slope = |x: usize, y: usize| {
            let number = [x, y].map(|number| -(number as i64));
            let q = [0, 1].map(|axis| TAU * number[axis] as f64 / grid.lengths()[axis]);
            q[0].hypot(q[1]) * compliance_of(response, number)
        };
        let [rows_of, columns_of] = coarse.points();
        let shortest = slope(nx / 2, ny / 2);
        let is_deep = |slope: f64| (slope / shortest - 1.0).abs() < DEEP;
        if !(is_deep(slope(rows_of / 2, 0)) && is_deep(slope(0, columns_of / 2))) {
            return None;
        }
        let unit = power_of_two(1.0 / response.stiffness_range()[0]);
        let radius = RADIUS * (wide * narrow).sqrt();
        let short = |q: f64| shortest * radius * near_part(q * radius);
        let cell = [rows, columns];
        let near = Stencil::new(response, cell, (REACH, radius), |q, _| short(q) / unit).ok()?;
        let inverse = |_, g: f64| if g > 0.0 { unit / g } else { 0.0 };
        let stiff = Stencil::new(response, cell, (STIFF, f64::INFINITY), inverse).ok()?;
        // Too many processes make the same products, each for itself.
        let share = response.share().without_sums(coarse.points(), UNIT).unwrap_or_else(|| coarse.whole());
        let transform = Transform::distributed(coarse, &share);
        let table = |of: &(dyn Fn(Mode, f64) -> f64 + Sync)| long_waves(grid, (&coarse, transform.lanes()), of);
        let smooth = table(&|mode, splines| {
            let all = if mode.is_uniform() { 0.0 } else { compliance_of(response, mode.number) };
            (all - short(mode.wavenumber())) / (splines * unit)
        });
        let stiffness = table(&|mode, splines| {
            let all = if mode.is_uniform() { 0.0 } else { 1.0 / compliance_of(response, mode.number) };
            all * splines * unit
        });
        Some(Self {
            smooth,
            stiffness,
            coarse: transform.into(),
            share,
            near: near.into(),
            stiff: stiff.into(),
            splines: Splines::new(coarse.points()).into(),
            unit,
            near_uniform: short(0.0),
        })
    }

    /// Returns the unit of compliances, a power of two, in length/stress.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Returns the coarse grid.
    pub fn coarse(&self) -> &Grid {
        self.coarse.grid()
    }

    /// Returns the cost of a transform pair on the coarse grid, in pairs on the whole grid;
    /// [`compliance`](Self::compliance) and [`stiffen`](Self::stiffen) take one pair each.
    pub fn effort(&self) -> f64 {
        1.0 / (COARSENING * COARSENING) as f64
    }

    /// Returns the rows of the coarse grid of each process.
    pub fn rows(&self) -> &Share {
        &self.share
    }

    /// Returns the blocks of this process; all processes have about equal numbers.
    pub fn own(&self, blocks: &Blocks) -> Range<usize> {
        blocks.in_rows(&self.rows_of(blocks, self.rank()))
    }

    /// Returns the own blocks and the blocks to which the stiffness couples them, in two ranges.
    pub fn coupled(&self, blocks: &Blocks) -> [Range<usize>; 2] {
        self.beside(blocks, STIFF).pieces().map(|rows| blocks.in_rows(&rows))
    }

    fn rank(&self) -> usize {
        self.share.ranks().rank()
    }

    fn size(&self) -> usize {
        self.share.all_rows().len()
    }

    /// Returns the rows of points of a process.
    fn rows_of(&self, blocks: &Blocks, rank: usize) -> Range<usize> {
        blocks.rows_of(rank, self.size())
    }

    /// Returns the own rows of points and those up to a `distance` from them.
    fn beside(&self, blocks: &Blocks, distance: usize) -> Window {
        Window::around(&self.rows_of(blocks, self.rank()), [distance; 2], blocks.rows())
    }

    /// Returns the rows of points that spread to the rows of the coarse grid of a process.
    fn spreading(&self, rank: usize) -> Window {
        let rows = &self.share.all_rows()[rank];
        let points = rows.start * COARSENING..rows.end * COARSENING;
        let margins = [ORDER - BEFORE - 1, BEFORE].map(|rows| rows * COARSENING);
        Window::around(&points, margins, self.coarse().points()[0] * COARSENING)
    }

    /// Returns the rows of the coarse grid around the rows of points of a process, with margins before and behind.
    fn cells_of(&self, blocks: &Blocks, rank: usize, margins: [usize; 2]) -> Window {
        let Range { start, end } = self.rows_of(blocks, rank);
        Window::around(&(start / COARSENING..end.div_ceil(COARSENING)), margins, self.coarse().points()[0])
    }

    /// Returns the rows of the coarse grid from which the points up to a `distance` from the rows of a process are
    /// interpolated.
    fn lines_of(&self, blocks: &Blocks, rank: usize, distance: usize) -> Window {
        let distance = distance.div_ceil(COARSENING);
        self.cells_of(blocks, rank, [BEFORE + distance, ORDER - BEFORE - 1 + distance])
    }

    /// Exchanges rows of the coarse grid: from the own rows to the window of each process.
    fn rows_around(&self, own: &[f32], columns: usize, window: impl Fn(usize) -> Window) -> Vec<f32> {
        let to: Vec<Range<usize>> = (0..self.size()).map(|rank| window(rank).range()).collect();
        self.share.around(own, columns, [self.share.all_rows(), &to])
    }

    /// Returns the blocks of each process.
    fn parts(&self, blocks: &Blocks) -> Vec<Range<usize>> {
        (0..self.size()).map(|rank| blocks.in_rows(&self.rows_of(blocks, rank))).collect()
    }

    /// Completes the values of all blocks after each process has computed its own.
    pub fn complete(&self, blocks: &Blocks, values: &mut [f32]) {
        if !self.share.is_whole() {
            let all = self.share.gather_rows(values_of(values, self.own(blocks)), LANES, &self.parts(blocks));
            values[..all.len()].copy_from_slice(&all);
        }
    }

    /// Returns the rows of a field of the coarse grid around the own blocks, from its rows of each process.
    pub fn cells<'a>(&self, blocks: &Blocks, field: &'a [f32]) -> Cells<'a> {
        let columns = self.coarse().points()[1];
        let window = |rank: usize| self.cells_of(blocks, rank, [0, 1]);
        let values = match self.share.is_whole() {
            true => field.into(),
            false => self.rows_around(field, columns, window).into(),
        };
        Cells { values, columns, window: window(self.rank()) }
    }

    /// Creates the memory for images of pressures on the coarse grid.
    pub fn memory(&self) -> ScatteredMemory {
        ScatteredMemory {
            workspace: self.coarse.workspace(),
            far: Vec::new(),
            lines: Lines::default(),
            sources: Sources::default(),
            computed: 0,
        }
    }

    /// Computes `out` = G `pressure` divided by the unit. Both have a value for each point of the blocks; the pressure
    /// elsewhere is zero. `out` is computed at the own blocks, from the whole pressure.
    pub fn compliance(&self, blocks: &Blocks, pressure: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        let ScatteredMemory { workspace, far, lines, sources, computed } = memory;
        let (near, spreading) = (self.beside(blocks, REACH), self.spreading(self.rank()));
        sources.take(blocks, pressure, near);
        if !near.is_whole() {
            sources.take(blocks, pressure, spreading);
        }
        self.splines.spread(blocks, sources, spreading, lines);
        let (lines, first) = ((&*lines, spreading), self.share.rows().start);
        far.resize(self.share.rows().len() * self.splines.line(), 0.0);
        let source = |row: usize, (): (), values: &mut [f32]| self.splines.gather(lines, first + row, values);
        let copy = |_: usize, row: &mut [f32], Rows(line, _): Rows<&mut [f32]>| repeat(row, line);
        let far_lines = Rows(&mut far[..], self.splines.line());
        fits(self.coarse.convolve_rows(&self.smooth, (), source, far_lines, copy, workspace));
        let rows = self.rows_of(blocks, self.rank());
        self.interpolate_lines(blocks, 0, far, out);
        sources.add(&self.near, blocks, rows, out);
        *computed += self.own(blocks).len() as u64;
    }

    /// Computes `out` = S `gap` times the unit at the own blocks, from the gap at the [`coupled`](Self::coupled) ones.
    /// S, the stiffness up to 6 points apart, is positive definite.
    pub fn stiffness(&self, blocks: &Blocks, gap: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        memory.sources.take(blocks, gap, self.beside(blocks, STIFF));
        values_mut(out, self.own(blocks)).fill(0.0);
        memory.sources.add(&self.stiff, blocks, self.rows_of(blocks, self.rank()), out);
        memory.computed += self.own(blocks).len() as u64;
    }

    /// Computes `out` = I `field` at the [`coupled`](Self::coupled) blocks: interpolates a field on the coarse grid,
    /// with the rows of each process, at the points.
    pub fn interpolate(&self, blocks: &Blocks, field: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        let ScatteredMemory { far, computed, .. } = memory;
        far.resize(self.share.rows().len() * self.splines.line(), 0.0);
        let rows = field.par_chunks_exact(self.coarse.grid().points()[1]);
        rows.zip(far.par_chunks_exact_mut(self.splines.line())).for_each(|(row, line)| repeat(row, line));
        *computed += self.coupled(blocks).map(|blocks| blocks.len() as u64).into_iter().sum::<u64>();
        self.interpolate_lines(blocks, STIFF, far, out);
    }

    /// Interpolates the points up to a `distance` from the own rows, from the lines of the coarse grid of each process.
    fn interpolate_lines(&self, blocks: &Blocks, distance: usize, lines: &mut Vec<f32>, out: &mut [f32]) {
        let window = |rank: usize| self.lines_of(blocks, rank, distance);
        if !self.share.is_whole() {
            *lines = self.rows_around(lines, self.splines.line(), window);
        }
        for rows in self.beside(blocks, distance).pieces() {
            self.splines.interpolate(blocks, rows, (lines, window(self.rank())), out);
        }
    }

    /// Replaces `field`, with the rows of each process, by Iᵀ (K I `field` times the unit − `pressure`), with the
    /// stiffness K of the body and the transpose of [`interpolate`](Self::interpolate). K I has the waves of the coarse
    /// grid only. The pressure is known at the own blocks; it becomes known at others as far as it is needed.
    pub fn stiffen(&self, blocks: &Blocks, field: &mut [f32], pressure: &mut [f32], memory: &mut ScatteredMemory) {
        let ScatteredMemory { workspace, lines, sources, .. } = memory;
        let (spreading, first) = (self.spreading(self.rank()), self.share.rows().start);
        if !self.share.is_whole() {
            let to: Vec<Range<usize>> = (0..self.size()).map(|rank| blocks.in_window(self.spreading(rank))).collect();
            let own = values_of(pressure, self.own(blocks));
            let arrived = self.share.around(own, LANES, [&self.parts(blocks), &to]);
            let mut rest = &arrived[..];
            for rows in spreading.pieces() {
                let values = values_mut(pressure, blocks.in_rows(&rows));
                let (now, after) = rest.split_at(values.len());
                values.copy_from_slice(now);
                rest = after;
            }
        }
        sources.take(blocks, pressure, spreading);
        self.splines.spread(blocks, sources, spreading, lines);
        let (lines, columns) = ((&*lines, spreading), self.coarse.grid().points()[1]);
        let source = |_: usize, Rows(field, _): Rows<&[f32]>, values: &mut [f32]| values.copy_from_slice(field);
        let less = |row: usize, values: &mut [f32], Rows(out, _): Rows<&mut [f32]>| {
            self.splines.gather(lines, first + row, out);
            out.iter_mut().zip(values).for_each(|(out, value)| *out = *value - *out);
        };
        fits(self.coarse.convolve_ahead(&self.stiffness, Rows(&*field, columns), source, workspace));
        fits(self.coarse.convolve_back(Rows(field, columns), less, workspace));
    }
}

/// Working memory of a [`Scattered`] response.
#[derive(Debug)]
pub struct ScatteredMemory {
    workspace: Workspace<f32>,
    /// Lines of a field on the coarse grid, such as the long-wave displacement.
    far: Vec<f32>,
    lines: Lines,
    sources: Sources,
    /// Number of blocks computed.
    computed: u64,
}

impl ScatteredMemory {
    /// Returns the number of blocks at which this process has computed products, interpolations included.
    pub fn computed(&self) -> u64 {
        self.computed
    }

    /// Frees the memory that is not needed until the next product.
    pub fn release(&mut self) {
        (self.far, self.lines, self.sources) = Default::default();
    }
}

/// Rows of a field of the coarse grid around the own blocks.
#[derive(Debug)]
pub struct Cells<'a> {
    values: Cow<'a, [f32]>,
    columns: usize,
    window: Window,
}

impl Cells<'_> {
    /// Returns a row of the field.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[f32] {
        &self.values[self.window.place(row) * self.columns..][..self.columns]
    }
}

/// Returns the values of these blocks.
fn values_of(values: &[f32], blocks: Range<usize>) -> &[f32] {
    &values[blocks.start * LANES..blocks.end * LANES]
}

fn values_mut(values: &mut [f32], blocks: Range<usize>) -> &mut [f32] {
    &mut values[blocks.start * LANES..blocks.end * LANES]
}

/// Tabulates `of` for these lanes of the modes of the coarse grid with q_x ≥ 0; it is even in q_x. `of` gets the mode
/// and the squared transfer factor of the spline interpolation times the number of points per coarse point.
fn long_waves(grid: &Grid, (coarse, lanes): (&Grid, Range<usize>), of: &(dyn Fn(Mode, f64) -> f64 + Sync)) -> Vec<f32> {
    let points = grid.len() as f64 / coarse.len() as f64;
    // The squared transforms of the splines along each axis.
    let [across, along] = [0, 1].map(|axis| {
        let points = coarse.points()[axis];
        let sinc = |number: usize| {
            let half = PI * number as f64 / points as f64;
            if number == 0 { 1.0 } else { half.sin() / half }
        };
        (0..=points / 2).map(|number| sinc(number).powi(2 * ORDER as i32)).collect::<Vec<_>>()
    });
    let value = |y: usize, x: usize| of(coarse.mode(y, x), points * across[x] * along[y]) as f32;
    let modes = (lanes.start * across.len()..lanes.end * across.len()).into_par_iter();
    modes.map(|index| value(index / across.len(), index % across.len())).collect()
}

/// Returns the compliance of the mode with these numbers, or of the opposite mode.
fn compliance_of(response: &NormalResponse, number: [i64; 2]) -> f64 {
    let grid = response.grid();
    let index = grid.index_of(number).or_else(|| grid.index_of(number.map(|number| -number)));
    index.map_or(0.0, |index| response.compliance_at(index))
}
