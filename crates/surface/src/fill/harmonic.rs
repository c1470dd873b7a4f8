//! Laplace's equation on the undefined points, solved by conjugate gradients with a multigrid preconditioner. Coarse
//! points are blocks of two by two points. Each coarse system is solved by up to two steps of conjugate gradients,
//! preconditioned by the next level (a K cycle; Notay and Vassilevski 2008), so that corrections have the right size on
//! every level.

use ndarray::{Array2, ArrayRef2};
use rayon::prelude::*;

use crate::SurfaceError;

/// Residual at which the iteration ends, relative to the residual of zero heights.
const RESIDUAL: f64 = 1e-12;

/// Largest relative residual of a solution. It is recomputed at the end because rounding adds to the iterated residual.
const ALLOWED: f64 = 1e-9;

/// Largest number of iterations; ten to thirty usually suffice.
const MOST_ITERATIONS: usize = 500;

/// Damping factor of the smoother (Jacobi's method).
const DAMPING: f64 = 0.7;

/// Number of smoothing sweeps before and after each correction.
const SWEEPS: usize = 2;

/// Reduction of the residual on a coarse level that makes the second step unnecessary.
const ENOUGH: f64 = 0.25;

/// Number of values below which a pass uses one thread.
const SINGLE_THREAD_LENGTH: usize = 1 << 14;

/// Fills NaN. At least one height must be defined.
pub(super) fn fill(mut heights: Array2<f64>, spacing: [f64; 2]) -> Result<Array2<f64>, SurfaceError> {
    let ny = heights.ncols();
    // Heights are taken relative to one defined height, so that rounding errors scale with height differences.
    let origin = heights.iter().copied().find(|height| !height.is_nan()).unwrap_or(0.0);
    let (finest, load) = Level::finest(&heights, origin, spacing);
    let levels = hierarchy(finest);
    let (solution, residual) = solve(&levels, &load);
    if residual.is_nan() || residual > ALLOWED {
        return Err(SurfaceError::Unsolved { residual, allowed: ALLOWED });
    }
    for ((i, j), height) in heights.indexed_iter_mut() {
        if height.is_nan() {
            *height = origin + solution[i * ny + j];
        }
    }
    Ok(heights)
}

/// Grid of unknowns: (A u)(p) = diagonal(p) u(p) − Σ link u(neighbour). Points without an unknown hold zeros.
struct Level {
    points: [usize; 2],
    diagonal: Vec<f64>,
    /// Coupling of a point to the next one along x and y.
    links: [Vec<f64>; 2],
}

impl Level {
    /// Returns the equations of the undefined points and their right-hand side.
    fn finest(heights: &ArrayRef2<f64>, origin: f64, spacing: [f64; 2]) -> (Self, Vec<f64>) {
        let (nx, ny) = heights.dim();
        let mut level =
            Self { points: [nx, ny], diagonal: vec![0.0; nx * ny], links: [vec![0.0; nx * ny], vec![0.0; nx * ny]] };
        let mut load = vec![0.0; nx * ny];
        // Only the ratio of the spacings matters.
        let weight = [1.0, (spacing[0] / spacing[1]).powi(2)];
        for i in 0..nx {
            for j in 0..ny {
                for (axis, next) in [[i + 1, j], [i, j + 1]].into_iter().enumerate() {
                    if next[0] == nx || next[1] == ny {
                        continue;
                    }
                    let [here, there] = [heights[[i, j]], heights[next]];
                    let [p, q] = [i * ny + j, next[0] * ny + next[1]];
                    let w = weight[axis];
                    if here.is_nan() {
                        level.diagonal[p] += w;
                        load[p] += if there.is_nan() { 0.0 } else { w * (there - origin) };
                    }
                    if there.is_nan() {
                        level.diagonal[q] += w;
                        load[q] += if here.is_nan() { 0.0 } else { w * (here - origin) };
                    }
                    if here.is_nan() && there.is_nan() {
                        level.links[axis][p] = w;
                    }
                }
            }
        }
        (level, load)
    }

    /// Returns the equations of blocks of two by two points, in which the unknowns of a block move together.
    fn coarser(&self) -> Self {
        let [nx, ny] = self.points;
        let [cx, cy] = [nx.div_ceil(2), ny.div_ceil(2)];
        let mut coarse =
            Self { points: [cx, cy], diagonal: vec![0.0; cx * cy], links: [vec![0.0; cx * cy], vec![0.0; cx * cy]] };
        for i in 0..nx {
            for j in 0..ny {
                let (p, block) = (i * ny + j, i / 2 * cy + j / 2);
                coarse.diagonal[block] += self.diagonal[p];
                for (axis, odd) in [i % 2 == 1, j % 2 == 1].into_iter().enumerate() {
                    let link = self.links[axis][p];
                    if odd {
                        coarse.links[axis][block] += link;
                    } else {
                        coarse.diagonal[block] -= 2.0 * link;
                    }
                }
            }
        }
        coarse
    }

    /// Writes out(p) = f(p, (A u)(p)).
    fn apply(&self, u: &[f64], out: &mut [f64], f: impl Fn(usize, f64) -> f64 + Sync) {
        let [nx, ny] = self.points;
        let [along_x, along_y] = &self.links;
        let row = |i: usize, out: &mut [f64]| {
            for (j, out) in out.iter_mut().enumerate() {
                let p = i * ny + j;
                if self.diagonal[p] == 0.0 {
                    *out = 0.0;
                    continue;
                }
                let mut sum = self.diagonal[p] * u[p];
                if i > 0 {
                    sum -= along_x[p - ny] * u[p - ny];
                }
                if i + 1 < nx {
                    sum -= along_x[p] * u[p + ny];
                }
                if j > 0 {
                    sum -= along_y[p - 1] * u[p - 1];
                }
                if j + 1 < ny {
                    sum -= along_y[p] * u[p + 1];
                }
                *out = f(p, sum);
            }
        };
        if u.len() < SINGLE_THREAD_LENGTH {
            out.chunks_mut(ny).enumerate().for_each(|(i, out)| row(i, out));
        } else {
            out.par_chunks_mut(ny).enumerate().for_each(|(i, out)| row(i, out));
        }
    }

    /// Performs one smoothing sweep: out = u + ω (b − A u)/diagonal.
    fn sweep(&self, load: &[f64], u: &[f64], out: &mut [f64]) {
        self.apply(u, out, |p, product| u[p] + DAMPING * (load[p] - product) / self.diagonal[p]);
    }
}

/// Returns the levels from the finest to a single point.
fn hierarchy(finest: Level) -> Vec<Level> {
    let mut levels = vec![finest];
    while let Some(last) = levels.last().filter(|level| level.points != [1, 1]) {
        let coarser = last.coarser();
        levels.push(coarser);
    }
    levels
}

/// Returns an approximate solution of A u = load on the first level: smoothing, correction from blocks, smoothing.
fn cycle(levels: &[Level], load: &[f64]) -> Vec<f64> {
    let level = &levels[0];
    let scaled = |p: usize| if level.diagonal[p] > 0.0 { load[p] / level.diagonal[p] } else { 0.0 };
    if levels.len() == 1 {
        return (0..load.len()).map(scaled).collect();
    }
    let mut u: Vec<f64> = (0..load.len()).map(|p| DAMPING * scaled(p)).collect();
    let mut other = vec![0.0; load.len()];
    for _ in 1..SWEEPS {
        level.sweep(load, &u, &mut other);
        std::mem::swap(&mut u, &mut other);
    }
    level.apply(&u, &mut other, |p, product| load[p] - product);
    let correction = correct(&levels[1..], restrict(level.points, &other));
    add_blocks(level, &correction, &mut u);
    for _ in 0..SWEEPS {
        level.sweep(load, &u, &mut other);
        std::mem::swap(&mut u, &mut other);
    }
    u
}

/// Performs up to two steps of conjugate gradients for A u = residual from u = 0, preconditioned with the cycle.
fn correct(levels: &[Level], mut residual: Vec<f64>) -> Vec<f64> {
    let level = &levels[0];
    let ny = level.points[1];
    let mut u = cycle(levels, &residual);
    let size = dot(ny, &residual, &residual);
    if levels.len() == 1 || size == 0.0 {
        return u;
    }
    let mut product = vec![0.0; u.len()];
    level.apply(&u, &mut product, |_, product| product);
    let energy = dot(ny, &u, &product);
    let step = dot(ny, &u, &residual) / energy;
    residual.iter_mut().zip(&product).for_each(|(r, product)| *r -= step * product);
    if dot(ny, &residual, &residual) <= ENOUGH * ENOUGH * size {
        u.iter_mut().for_each(|u| *u *= step);
        return u;
    }
    let mut second = cycle(levels, &residual);
    let overlap = dot(ny, &second, &product) / energy;
    second.iter_mut().zip(&u).for_each(|(second, first)| *second -= overlap * first);
    level.apply(&second, &mut product, |_, product| product);
    let other = dot(ny, &second, &residual) / dot(ny, &second, &product);
    u.iter_mut()
        .zip(&second)
        .for_each(|(u, second)| *u = step * *u + if other.is_finite() { other * second } else { 0.0 });
    u
}

/// Returns the sums over blocks.
fn restrict([nx, ny]: [usize; 2], fine: &[f64]) -> Vec<f64> {
    let cy = ny.div_ceil(2);
    let mut coarse = vec![0.0; nx.div_ceil(2) * cy];
    let row = |block: usize, coarse: &mut [f64]| {
        for i in 2 * block..(2 * block + 2).min(nx) {
            for (j, value) in fine[i * ny..(i + 1) * ny].iter().enumerate() {
                coarse[j / 2] += value;
            }
        }
    };
    if fine.len() < SINGLE_THREAD_LENGTH {
        coarse.chunks_mut(cy).enumerate().for_each(|(block, coarse)| row(block, coarse));
    } else {
        coarse.par_chunks_mut(cy).enumerate().for_each(|(block, coarse)| row(block, coarse));
    }
    coarse
}

/// Adds the value of each block to the unknowns in it.
fn add_blocks(level: &Level, coarse: &[f64], u: &mut [f64]) {
    let ny = level.points[1];
    let cy = ny.div_ceil(2);
    let row = |i: usize, u: &mut [f64]| {
        for (j, u) in u.iter_mut().enumerate() {
            if level.diagonal[i * ny + j] != 0.0 {
                *u += coarse[i / 2 * cy + j / 2];
            }
        }
    };
    if u.len() < SINGLE_THREAD_LENGTH {
        u.chunks_mut(ny).enumerate().for_each(|(i, u)| row(i, u));
    } else {
        u.par_chunks_mut(ny).enumerate().for_each(|(i, u)| row(i, u));
    }
}

/// Solves by conjugate gradients preconditioned with the cycle. Since the cycle is not linear, each direction is made
/// orthogonal to the previous one. Returns the solution and the residual relative to the load.
fn solve(levels: &[Level], load: &[f64]) -> (Vec<f64>, f64) {
    let ny = levels[0].points[1];
    let mut solution = vec![0.0; load.len()];
    let mut residual = load.to_vec();
    let whole = dot(ny, load, load).sqrt();
    let mut direction = vec![0.0; load.len()];
    let mut product = vec![0.0; load.len()];
    let mut energy = 0.0;
    for _ in 0..MOST_ITERATIONS {
        if dot(ny, &residual, &residual).sqrt() <= RESIDUAL * whole {
            break;
        }
        let preconditioned = cycle(levels, &residual);
        let overlap = if energy > 0.0 { dot(ny, &preconditioned, &product) / energy } else { 0.0 };
        direction.par_iter_mut().zip(&preconditioned).for_each(|(d, z)| *d = z - overlap * *d);
        levels[0].apply(&direction, &mut product, |_, product| product);
        energy = dot(ny, &direction, &product);
        let step = dot(ny, &direction, &residual) / energy;
        if !step.is_finite() {
            break; // The residual is zero to rounding.
        }
        solution.par_iter_mut().zip(&direction).for_each(|(u, d)| *u += step * d);
        residual.par_iter_mut().zip(&product).for_each(|(r, product)| *r -= step * product);
    }
    levels[0].apply(&solution, &mut product, |p, product| load[p] - product);
    let left = dot(ny, &product, &product).sqrt();
    (solution, if whole > 0.0 { left / whole } else { 0.0 })
}

/// Returns a scalar product, added row by row so that it is bitwise identical for any number of threads.
fn dot(ny: usize, a: &[f64], b: &[f64]) -> f64 {
    let row = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| a * b).sum();
    if a.len() < SINGLE_THREAD_LENGTH {
        return a.chunks(ny).zip(b.chunks(ny)).map(row).sum();
    }
    let rows: Vec<f64> = a.par_chunks(ny).zip(b.par_chunks(ny)).map(row).collect();
    rows.iter().sum()
}
