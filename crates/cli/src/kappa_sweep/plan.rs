//! Which contacts a sweep computes, in which order, and what they cost.

use gfmd_field::{Grid, Transform};
use gfmd_surface::Discretisation;
use serde::Serialize;

use super::config::Config;
use crate::failure::Failure;
use crate::memory::Held;

/// Points along one axis up to which realisations run side by side; larger grids use all threads for one.
pub(super) const SIDE_BY_SIDE: usize = 512;

/// One discretisation of one family of surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Hurst exponent.
    pub hurst: f64,
    /// The discretisation.
    pub discretisation: Discretisation,
    /// Grid points along one axis.
    pub n: usize,
    /// Seed of its first realisation; the others follow.
    pub first_seed: u64,
}

/// One realisation at one point: all loads of the sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Index of its point.
    pub point: usize,
    /// Number of the realisation.
    pub realisation: u64,
    /// Seed of the surface.
    pub seed: u64,
}

/// All of a sweep.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Points, small grids first.
    pub points: Vec<Point>,
    /// Runs, point by point.
    pub runs: Vec<Run>,
    dim: u8,
    loads: Vec<f64>,
}

/// A million seeds lie between two groups of realisations.
const SEEDS_PER_GROUP: u64 = 1_000_000;

impl Plan {
    /// The plan of a configuration.
    ///
    /// # Errors
    /// A configuration that cannot be computed.
    pub fn new(config: &Config) -> Result<Self, Failure> {
        config.check()?;
        let cells = config.discretisations()?;
        let mut groups: Vec<[f64; 2]> = cells.iter().map(|(d, _)| [d.eps_t_inv, d.eps_f_inv]).collect();
        groups.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        groups.dedup();
        let mut points = Vec::new();
        for (discretisation, n) in cells {
            let shape = if config.surface.dim == 2 { [n, 1] } else { [n, n] };
            Held::HARD_WALL.check("the grid", shape)?;
            let group = [discretisation.eps_t_inv, discretisation.eps_f_inv];
            let group = groups.iter().position(|other| *other == group).unwrap_or(0);
            for (family, &hurst) in config.surface.hurst.iter().enumerate() {
                let group = (family * groups.len() + group) as u64;
                let first_seed = config.statistics.seed + SEEDS_PER_GROUP * group;
                points.push(Point { hurst, discretisation, n, first_seed });
            }
        }
        let runs = points.iter().enumerate().flat_map(|(point, at): (usize, &Point)| {
            (0..config.realisations(&at.discretisation)).map(move |realisation| Run {
                point,
                realisation,
                seed: at.first_seed + realisation,
            })
        });
        let runs = runs.collect();
        Ok(Self { points, runs, dim: config.surface.dim, loads: config.loads.p_star.clone() })
    }

    /// Number of realisations of a point.
    pub fn realisations(&self, point: usize) -> usize {
        self.runs.iter().filter(|run| run.point == point).count()
    }

    /// The grid of a point, on a cell of length 1.
    ///
    /// # Errors
    /// Never for a point of this plan.
    pub fn grid(&self, point: &Point) -> Result<Grid, Failure> {
        let grid = if self.dim == 2 { Grid::line(point.n, 1.0) } else { Grid::square(point.n, 1.0) };
        grid.map_err(|error| Failure::input("points", error))
    }

    /// Expected cost of one run, in seconds of a machine whose transform pair of a million points takes `pair`.
    pub fn cost(&self, point: &Point, pair: f64) -> f64 {
        let size = if self.dim == 2 { point.n as f64 } else { (point.n as f64).powi(2) };
        let transform = pair * size / MILLION * size.log2() / MILLION.log2();
        // Measured: 22 to 34 pairs whatever the size; passes over memory between two transforms take about as long again.
        let pairs = 30.0;
        let sides = if self.dim == 2 { 2.0 } else { 1.0 };
        2.0 * sides * self.loads.len() as f64 * pairs * transform
    }

    /// Memory that one run takes at its peak, in bytes.
    pub fn memory(&self, point: &Point) -> u64 {
        Held::HARD_WALL.bytes(if self.dim == 2 { [point.n, 1] } else { [point.n; 2] })
    }

    /// Seconds that a transform pair of a million points takes here, now.
    ///
    /// # Errors
    /// Never.
    pub fn calibrate() -> Result<f64, Failure> {
        let n = 256;
        let grid = Grid::square(n, 1.0).map_err(|error| Failure::Computation(error.to_string()))?;
        let transform = Transform::new(grid);
        let mut workspace = transform.workspace();
        let (kernel, field, mut out) = (vec![1.0; grid.spectrum_len()], vec![1.0; grid.len()], vec![0.0; grid.len()]);
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            let started = std::time::Instant::now();
            transform
                .convolve(&kernel, &field, &mut out, &mut workspace)
                .map_err(|error| Failure::Computation(error.to_string()))?;
            best = best.min(started.elapsed().as_secs_f64());
        }
        let size = grid.len() as f64;
        Ok(best * MILLION / size * MILLION.log2() / size.log2())
    }
}

const MILLION: f64 = 1_048_576.0;

/// A line of `--dry-run`.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedPoint {
    pub dim: u8,
    pub hurst: f64,
    pub eps_t_inv: f64,
    pub eps_f_inv: f64,
    pub eps_c_inv: f64,
    pub n: usize,
    pub realisations: usize,
    pub memory_bytes: u64,
    pub seconds: f64,
}
