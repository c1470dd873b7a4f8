use std::ops::Range;

use gfmd_field::{Grid, Mode};
use rayon::prelude::*;

use crate::{Body, Matrix3};

/// Number of modes that one thread takes at a time.
const CHUNK: usize = 4096;

/// Returns the frictionless normal stiffness 1/G_zz (stress/length) of every mode, in the order of [`Grid::modes`].
///
/// `uniform` is the entry of the mode q = 0. The value of the body is
/// [`body.normal_stiffness(0.0)`](Body::normal_stiffness): 0 for a half-space, and infinite for a bonded incompressible
/// slab, which has zero mean displacement (theory.md, section 3). At a Nyquist mode, the entry is 1/G_zz(|q|), as at
/// any other mode (theory.md, section 0).
pub fn normal_stiffness_table(body: &Body, grid: &Grid, uniform: f64) -> Vec<f64> {
    if !body.is_isotropic() {
        return table_of_modes(grid, all_lanes(grid), uniform, |mode| body.normal_stiffness_of(mode));
    }
    table_of_lanes(grid, all_lanes(grid), uniform, |q| body.normal_stiffness(q))
}

/// Returns the normal stiffness K_N (stress/length) of every mode of `grid` for a surface without lateral displacement,
/// in the order of [`Grid::modes`]. `uniform` is as in [`normal_stiffness_table`].
pub fn restricted_normal_stiffness_table(body: &Body, grid: &Grid, uniform: f64) -> Vec<f64> {
    table_of_lanes(grid, all_lanes(grid), uniform, |q| body.restricted_normal_stiffness(q))
}

/// Tabulates a function of |q| for the modes in some lanes of the half spectrum ([`Grid::spectrum_shape`]), for example
/// the lanes of one process. The function is evaluated once for ±m; `uniform` is the entry of the mode q = 0.
pub fn table_of_lanes(grid: &Grid, lanes: Range<usize>, uniform: f64, value: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
    let [_, positions] = grid.spectrum_shape();
    let mut table = vec![0.0; lanes.len() * positions];
    if grid.is_line() {
        table.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, entries)| {
            for (offset, entry) in entries.iter_mut().enumerate() {
                let mode = grid.mode(0, chunk * CHUNK + offset);
                *entry = if mode.is_uniform() { uniform } else { value(mode.wavenumber()) };
            }
        });
    } else {
        let across: Vec<f64> = (0..=positions / 2).map(|position| grid.mode(0, position).wavevector[0]).collect();
        table.par_chunks_mut(positions).enumerate().for_each(|(lane, entries)| {
            let lane = lanes.start + lane;
            let along = grid.mode(lane, 0).wavevector[1];
            let (half, mirrored) = entries.split_at_mut(positions / 2 + 1);
            for (position, (entry, across)) in half.iter_mut().zip(&across).enumerate() {
                *entry = if [lane, position] == [0, 0] { uniform } else { value(across.hypot(along)) };
            }
            for (entry, same) in mirrored.iter_mut().rev().zip(&half[1..]) {
                *entry = *same;
            }
        });
    }
    table
}

/// Tabulates a function of the mode in some lanes of the half spectrum, in the order of [`table_of_lanes`], for bodies
/// that are not [isotropic](Body::is_isotropic). `uniform` is the entry of the mode q = 0.
pub fn table_of_modes(grid: &Grid, lanes: Range<usize>, uniform: f64, value: impl Fn(&Mode) -> f64 + Sync) -> Vec<f64> {
    let [_, positions] = grid.spectrum_shape();
    let mut table = vec![0.0; lanes.len() * positions];
    table.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, entries)| {
        for (offset, entry) in entries.iter_mut().enumerate() {
            let index = chunk * CHUNK + offset;
            let mode = grid.mode(lanes.start + index / positions, index % positions);
            *entry = if mode.is_uniform() { uniform } else { value(&mode) };
        }
    });
    table
}

fn all_lanes(grid: &Grid) -> Range<usize> {
    0..grid.spectrum_shape()[0]
}

/// Softest and stiffest mode of a body on a grid, which limit time steps and damping (theory.md, section 6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessRange {
    /// Smallest stiffness, in stress/length.
    pub softest: f64,
    /// Mode with the smallest stiffness.
    pub softest_mode: Mode,
    /// Largest stiffness, in stress/length.
    pub stiffest: f64,
    /// Mode with the largest stiffness.
    pub stiffest_mode: Mode,
}

/// Returns the range of the frictionless normal stiffness 1/G_zz over the modes of `grid`.
///
/// The stiffness of the uniform mode is the inverse of [`Body::level_compliance`]. It is omitted if there is no
/// compliance (half-space, incompressible slab), since no solver then uses it. Returns `None` if no mode is left.
pub fn normal_stiffness_range(body: &Body, grid: &Grid) -> Option<StiffnessRange> {
    let [_, uniform] = body.level_compliance();
    range(grid, !body.is_isotropic(), |mode| {
        let stiffness = if mode.is_uniform() { 1.0 / uniform } else { body.normal_stiffness_of(mode) };
        [stiffness; 3]
    })
}

/// Returns the range of the eigenvalues of the stiffness matrix over the modes of `grid`, for problems in which all
/// components of the surface move: x, y, z, or x, z on a line.
///
/// The eigenvalues of the uniform mode are as in [`normal_stiffness_range`].
pub fn stiffness_range(body: &Body, grid: &Grid) -> Option<StiffnessRange> {
    let line = grid.is_line();
    let [lateral, normal] = body.level_compliance().map(f64::recip);
    range(grid, false, |mode| {
        if mode.is_uniform() {
            return [lateral, lateral, normal];
        }
        if mode.nyquist != [false, false] {
            return special_eigenvalues(&body.stiffness_of(mode), mode.nyquist, line);
        }
        let blocks = body.stiffness_blocks(mode.wavenumber());
        let [low, high] = eigenvalues(blocks.longitudinal, blocks.normal, blocks.coupling[0]);
        [low, high, if line { low } else { blocks.transverse }]
    })
}

/// Returns the eigenvalues of [[a, i c], [−i c, b]]. The smaller one comes from the determinant, to keep its digits.
fn eigenvalues(a: f64, b: f64, c: f64) -> [f64; 2] {
    let high = 0.5 * (a + b) + (0.5 * (a - b)).hypot(c);
    [a * (b / high) - c * (c / high), high]
}

/// Returns the eigenvalues of a Nyquist mode. Its matrix couples at most one lateral axis with z.
fn special_eigenvalues(matrix: &Matrix3, nyquist: [bool; 2], line: bool) -> [f64; 3] {
    let (alone, other) = if nyquist[0] { (0, 1) } else { (1, 0) };
    let coupling = matrix[other][2].im;
    let [low, high] = if coupling == 0.0 {
        [matrix[other][other].re, matrix[2][2].re]
    } else {
        eigenvalues(matrix[other][other].re, matrix[2][2].re, coupling)
    };
    match (line, nyquist[0]) {
        // On a line, y does not move: x is `alone` at Nyquist and `other` at q = 0.
        (true, true) => [matrix[0][0].re, high, high],
        (true, false) => [low, high, high],
        _ => [low, high, matrix[alone][alone].re],
    }
}

/// Returns the softest and the stiffest mode by the positive, finite values of `stiffness`, which must be even in m
/// unless `all` modes are evaluated. The first of equal values counts.
fn range(grid: &Grid, all: bool, stiffness: impl Fn(&Mode) -> [f64; 3] + Sync) -> Option<StiffnessRange> {
    let [lanes, positions] = grid.spectrum_shape();
    let different = if all || grid.is_line() { positions } else { positions / 2 + 1 };
    let of_lane = |lane: usize| {
        let mut extremes = [(f64::INFINITY, lane, 0), (0.0, lane, 0)];
        for position in 0..different {
            for value in stiffness(&grid.mode(lane, position)) {
                if value > 0.0 && value < extremes[0].0 {
                    extremes[0] = (value, lane, position);
                }
                if value.is_finite() && value > extremes[1].0 {
                    extremes[1] = (value, lane, position);
                }
            }
        }
        extremes
    };
    let of_lanes: Vec<_> = (0..lanes).into_par_iter().map(of_lane).collect();
    let [low, high] = of_lanes.into_iter().reduce(|[low, high], [other_low, other_high]| {
        [if other_low.0 < low.0 { other_low } else { low }, if other_high.0 > high.0 { other_high } else { high }]
    })?;
    (high.0 > 0.0).then(|| StiffnessRange {
        softest: low.0,
        softest_mode: grid.mode(low.1, low.2),
        stiffest: high.0,
        stiffest_mode: grid.mode(high.1, high.2),
    })
}
