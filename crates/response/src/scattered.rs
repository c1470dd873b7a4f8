//! Response of a body between few points of a grid.

mod blocks;
mod near_part;
mod sources;
mod splines;
mod stencil;

use std::f64::consts::{PI, TAU};

use gfmd_field::{Grid, Mode, Rows, Transform, Workspace};
use rayon::prelude::*;

pub use blocks::Blocks;
use near_part::near_part;
use sources::Sources;
use splines::{Lines, ORDER, Splines, repeat};
use stencil::Stencil;

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
#[derive(Debug)]
pub struct Scattered {
    coarse: Transform<f32>,
    /// Compliance of long waves on the coarse grid, divided by the unit.
    smooth: Vec<f32>,
    /// Stiffness of waves interpolated from the coarse grid, times the unit.
    stiffness: Vec<f32>,
    /// Short-wave compliance between two points, divided by the unit.
    near: Stencil<NEAR>,
    /// Stiffness between two points times the unit, cut off at a short distance.
    stiff: Stencil<NEXT>,
    splines: Splines,
    unit: f64,
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

/// Largest relative difference from a half-space for the shortest waves of the coarse grid.
const DEEP: f64 = 1e-3;

/// Smallest number of points along a cell in which the response to a point has decayed.
const BOX: usize = 2 * REACH + LANES;

impl Scattered {
    /// Splits the response, with the given compliance (length/stress) and stiffness (stress/length) of the uniform
    /// mode. Returns `None` if the grid is small, elongated or not made of whole blocks and coarse cells, if layers are
    /// only a few points thick, or if the response is tabulated or differs between waves of equal length.
    pub fn of(response: &NormalResponse, [compliance, stiffness]: [f64; 2]) -> Option<Self> {
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
        let table = |of: &(dyn Fn(Mode, f64) -> f64 + Sync)| long_waves(grid, &coarse, of);
        let smooth = table(&|mode, splines| {
            let all = if mode.is_uniform() { compliance } else { compliance_of(response, mode.number) };
            (all - short(mode.wavenumber())) / (splines * unit)
        });
        let stiffness = table(&|mode, splines| {
            let all = if mode.is_uniform() { stiffness } else { 1.0 / compliance_of(response, mode.number) };
            all * splines * unit
        });
        Some(Self {
            coarse: Transform::new(coarse),
            smooth,
            stiffness,
            near,
            stiff,
            splines: Splines::new(coarse.points()),
            unit,
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

    /// Creates the memory for images of pressures on the coarse grid.
    pub fn memory(&self) -> ScatteredMemory {
        ScatteredMemory {
            workspace: self.coarse.workspace(),
            far: Vec::new(),
            lines: Lines::default(),
            sources: Sources::default(),
        }
    }

    /// Computes `out` = G `pressure` divided by the unit. Both have a value for each point of the blocks; the pressure
    /// elsewhere is zero.
    pub fn compliance(&self, blocks: &Blocks, pressure: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        let ScatteredMemory { workspace, far, lines, sources } = memory;
        sources.take(blocks, pressure);
        self.splines.spread(blocks, sources, lines);
        let lines = &*lines;
        far.resize(self.coarse.grid().points()[0] * self.splines.line(), 0.0);
        let source = |row: usize, (): (), values: &mut [f32]| self.splines.gather(lines, row, values);
        let copy = |_: usize, row: &mut [f32], Rows(line, _): Rows<&mut [f32]>| repeat(row, line);
        let far_lines = Rows(&mut far[..], self.splines.line());
        fits(self.coarse.convolve_rows(&self.smooth, (), source, far_lines, copy, workspace));
        self.splines.interpolate(blocks, far, out);
        sources.add(&self.near, blocks, out);
    }

    /// Computes `out` = S `gap` times the unit. S, the stiffness up to 6 points apart, is positive definite.
    pub fn stiffness(&self, blocks: &Blocks, gap: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        memory.sources.take(blocks, gap);
        out.fill(0.0);
        memory.sources.add(&self.stiff, blocks, out);
    }

    /// Computes `out` = I `field`: interpolates a field on the coarse grid at the points.
    pub fn interpolate(&self, blocks: &Blocks, field: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        memory.far.resize(self.coarse.grid().points()[0] * self.splines.line(), 0.0);
        let rows = field.par_chunks_exact(self.coarse.grid().points()[1]);
        rows.zip(memory.far.par_chunks_exact_mut(self.splines.line())).for_each(|(row, line)| repeat(row, line));
        self.splines.interpolate(blocks, &memory.far, out);
    }

    /// Replaces `field` by Iᵀ (K I `field` times the unit − `pressure`), with the stiffness K of the body and the
    /// transpose of [`interpolate`](Self::interpolate). K I has the waves of the coarse grid only.
    pub fn stiffen(&self, blocks: &Blocks, field: &mut [f32], pressure: &[f32], memory: &mut ScatteredMemory) {
        let ScatteredMemory { workspace, lines, sources, .. } = memory;
        sources.take(blocks, pressure);
        self.splines.spread(blocks, sources, lines);
        let (lines, columns) = (&*lines, self.coarse.grid().points()[1]);
        let source = |_: usize, Rows(field, _): Rows<&[f32]>, values: &mut [f32]| values.copy_from_slice(field);
        let less = |row: usize, values: &mut [f32], Rows(out, _): Rows<&mut [f32]>| {
            self.splines.gather(lines, row, out);
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
}

impl ScatteredMemory {
    /// Frees the memory that is not needed until the next product.
    pub fn release(&mut self) {
        (self.far, self.lines, self.sources) = Default::default();
    }
}

/// Tabulates `of` for the modes of the coarse grid with q_x ≥ 0; it is even in q_x. `of` gets the mode and the squared
/// transfer factor of the spline interpolation times the number of points per coarse point.
fn long_waves(grid: &Grid, coarse: &Grid, of: &(dyn Fn(Mode, f64) -> f64 + Sync)) -> Vec<f32> {
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
    let modes = (0..along.len() * across.len()).into_par_iter();
    modes.map(|index| value(index / across.len(), index % across.len())).collect()
}

/// Returns the compliance of the mode with these numbers, or of the opposite mode.
fn compliance_of(response: &NormalResponse, number: [i64; 2]) -> f64 {
    let grid = response.grid();
    let index = grid.index_of(number).or_else(|| grid.index_of(number.map(|number| -number)));
    index.map_or(0.0, |index| response.compliance_at(index))
}
