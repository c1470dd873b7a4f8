//! Contacts of a sweep, their order, and their expected work.

use std::ops::Range;

use gfmd_field::Grid;
use gfmd_surface::Discretisation;

use crate::config::{Config, refusal};
use crate::{Place, SweepError};

/// Discretisation of one family of surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Hurst exponent.
    pub hurst: f64,
    /// Discretisation.
    pub discretisation: Discretisation,
    /// Grid on a cell of length 1.
    pub grid: Grid,
    /// Seed of the first realisation; the seeds of a point are consecutive.
    pub first_seed: u64,
}

impl Point {
    /// Returns the number of grid points along one axis.
    pub fn n(&self) -> usize {
        self.grid.points()[0]
    }

    /// Returns true if realisations are computed side by side, one on each thread. On larger grids all threads work on
    /// one realisation.
    pub fn is_small(&self) -> bool {
        self.grid.is_line() || self.n() <= SIDE_BY_SIDE
    }
}

/// Largest number of points along one axis of a square with realisations computed side by side.
const SIDE_BY_SIDE: usize = 512;

/// Realisation of the surface of one point, pressed with all loads of the sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Index of the point.
    pub point: usize,
    /// Number of the realisation.
    pub realisation: u64,
    /// Seed of the surface.
    pub seed: u64,
}

/// Points of a configuration and the runs of each point. A run is identified by its index in [`Plan::runs`].
#[derive(Clone, Debug)]
pub struct Plan {
    /// Configuration.
    pub config: Config,
    /// Points, small grids first.
    pub points: Vec<Point>,
    /// Runs, point by point.
    pub runs: Vec<Run>,
}

/// Difference between the first seeds of two groups of realisations.
const SEEDS_PER_GROUP: u64 = 1_000_000;

/// Largest number of runs of a sweep, so that a plan does not fill the memory.
const MOST_RUNS: u64 = 10_000_000;

/// Work of one load in transform pairs. Between 22 and 34 pairs were measured, for any size. The passes over memory
/// between them take about as long as the transforms, hence the factor 2.
const PAIRS: f64 = 2.0 * 30.0;

impl Plan {
    /// Builds the plan of a configuration.
    ///
    /// # Errors
    /// Returns an error if the configuration cannot be computed.
    pub fn new(config: Config) -> Result<Self, SweepError> {
        config.check()?;
        let cells = config.discretisations()?;
        // The points of a group share their random modes.
        let mut groups: Vec<f64> = cells.iter().map(|(at, _)| at.eps_t_inv).collect();
        groups.sort_by(f64::total_cmp);
        groups.dedup();
        let largest = cells.last().map_or(1, |(_, n)| *n);
        let surfaces = &config.statistics.surfaces;
        let count = cells.len() * config.surface.hurst.len();
        let grows = config.statistics.target > 0.0;
        let none = surfaces.iter().all(|number| *number == 0) || (grows && surfaces.contains(&0));
        if !surfaces.is_empty() && (surfaces.len() != count || none) {
            let least = if grows { "above 0" } else { "(0 leaves a point out)" };
            return Err(SweepError::Field {
                field: "statistics.surfaces",
                found: format!("{surfaces:?}"),
                allowed: format!("{count} numbers {least}, one for each point, or empty"),
            });
        }
        let mut numbers = surfaces.iter().copied();
        let (mut points, mut runs) = (Vec::new(), Vec::new());
        for (discretisation, n) in cells {
            let grid = if config.surface.dim == 2 { Grid::line(n, 1.0) } else { Grid::square(n, 1.0) };
            let grid = grid.map_err(SweepError::Grid)?;
            // Every cell has a group, since the groups come from the cells.
            let group = groups.iter().position(|group| *group == discretisation.eps_t_inv).unwrap_or(0);
            let by_rule = config.realisations(&discretisation, n, largest);
            for (family, &hurst) in config.surface.hurst.iter().enumerate() {
                let realisations = numbers.next().unwrap_or(by_rule);
                if realisations == 0 {
                    continue;
                }
                let offset = SEEDS_PER_GROUP * (family * groups.len() + group) as u64;
                let first_seed = first_seed(config.statistics.seed, offset)?;
                let point = points.len();
                if realisations > SEEDS_PER_GROUP {
                    let allowed = format!("small enough for {SEEDS_PER_GROUP} realisations at the smallest cells");
                    return Err(refusal("statistics.realisations", &config.statistics.realisations, allowed));
                }
                if realisations > MOST_RUNS - runs.len() as u64 {
                    let allowed = format!("small enough for {MOST_RUNS} runs in all");
                    return Err(refusal("statistics.realisations", &config.statistics.realisations, allowed));
                }
                points.push(Point { hurst, discretisation, grid, first_seed });
                runs.extend((0..realisations).map(|realisation| Run {
                    point,
                    realisation,
                    seed: first_seed + realisation,
                }));
            }
        }
        Ok(Self { config, points, runs })
    }

    /// Returns the plan with other numbers of surfaces at its points.
    ///
    /// # Errors
    /// Returns an error if a point has fewer seeds than surfaces.
    pub fn with_surfaces(&self, surfaces: Vec<u64>) -> Result<Self, SweepError> {
        let mut config = self.config.clone();
        config.statistics.surfaces = surfaces;
        Self::new(config)
    }

    /// Returns the indices of the runs of a point.
    pub fn runs_of(&self, point: usize) -> Range<usize> {
        let start = self.runs.partition_point(|run| run.point < point);
        start..self.runs.partition_point(|run| run.point <= point)
    }

    /// Returns the expected work of one run at a point, in transform pairs of a million points. The run time is this
    /// number times the time of one pair.
    pub fn work(&self, point: &Point) -> f64 {
        const MILLION: f64 = 1_048_576.0;
        let size = point.grid.len() as f64;
        // A point of a line costs twice as much as a point of a square.
        let sides = if point.grid.is_line() { 2.0 } else { 1.0 };
        let pair = size / MILLION * size.log2() / MILLION.log2();
        PAIRS * sides * self.config.loads.p_star.len() as f64 * pair
    }

    /// Returns the name of a run in messages.
    pub(crate) fn place(&self, run: &Run, p_star: Option<f64>) -> Place {
        let Point { hurst, discretisation, .. } = self.points[run.point];
        Place { hurst, discretisation, seed: run.seed, p_star }
    }
}

/// Returns the first seed of a group, if all seeds of the group fit into the signed integers of a file.
fn first_seed(seed: u64, offset: u64) -> Result<u64, SweepError> {
    const LARGEST: u64 = i64::MAX as u64 - SEEDS_PER_GROUP;
    let first = seed.checked_add(offset).filter(|first| *first <= LARGEST);
    first.ok_or_else(|| refusal("statistics.seed", &seed, format!("at most {}", LARGEST.saturating_sub(offset))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Preset, StatisticsConfig};

    #[test]
    fn runs_lie_point_by_point_and_only_points_of_equal_cells_share_seeds() {
        let plan = Plan::new(Preset::Smoke.config()).unwrap();
        let all: Vec<usize> = (0..plan.points.len()).flat_map(|point| plan.runs_of(point)).collect();
        assert!(all.into_iter().eq(0..plan.runs.len()));
        for (a, b) in plan.runs.iter().flat_map(|a| plan.runs.iter().map(move |b| (a, b))) {
            let [p, q] = [a, b].map(|run| plan.points[run.point].discretisation);
            let same_modes = (p.eps_t_inv, a.realisation) == (q.eps_t_inv, b.realisation);
            assert_eq!(a.seed == b.seed, same_modes, "{a:?} {b:?}");
        }
    }

    #[test]
    fn plans_that_fill_the_memory_are_refused() {
        let config = Preset::Smoke.config();
        let lists: Vec<f64> = (0..1000).map(|k| 1.0 + f64::from(k)).collect();
        let points = crate::PointsConfig {
            design: crate::Design::Grid,
            eps_t_inv: lists.clone(),
            eps_f_inv: lists.clone(),
            eps_c_inv: lists,
            ..config.points.clone()
        };
        let message = Plan::new(Config { points, ..config.clone() }).unwrap_err().to_string();
        assert!(message.contains("points") && message.contains("1000000000"), "{message}");
        let points = crate::PointsConfig {
            design: crate::Design::Grid,
            eps_t_inv: vec![1.0, 2.0],
            eps_f_inv: (4..14).map(f64::from).collect(),
            eps_c_inv: vec![2.0],
            ..config.points.clone()
        };
        let statistics =
            StatisticsConfig { realisations: 1_000_000, nested: false, equal_area: false, ..config.statistics.clone() };
        let message = Plan::new(Config { points, statistics, ..config }).unwrap_err().to_string();
        assert!(message.contains("10000000 runs in all"), "{message}");
    }

    #[test]
    fn seeds_beyond_what_a_file_holds_are_refused() {
        let with_seed = |seed| {
            let config = Preset::Smoke.config();
            Plan::new(Config { statistics: StatisticsConfig { seed, ..config.statistics }, ..config })
        };
        for seed in [u64::MAX, i64::MAX as u64, i64::MAX as u64 - SEEDS_PER_GROUP] {
            let message = with_seed(seed).unwrap_err().to_string();
            assert!(message.contains("statistics.seed") && message.contains(&seed.to_string()), "{message}");
        }
        let seed = (1 << 53) + 1;
        assert_eq!(with_seed(seed).unwrap().runs[0].seed % SEEDS_PER_GROUP, seed % SEEDS_PER_GROUP);
    }
}
