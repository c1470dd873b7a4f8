//! Surfaces and statistics over ranks, run as threads, are bitwise identical to one process.

use gfmd_field::{Grid, Share};
use gfmd_surface::{Amplitudes, Moments, Normalisation, Scaling, SelfAffine, Statistics, SurfaceError};
use gfmd_vector::ThreadRanks;
use ndarray::{Array2, s};
use proptest::prelude::*;

fn spectrum(grid: &Grid) -> SelfAffine {
    let [dx, dy] = grid.spacing();
    let [x, y] = grid.lengths();
    let shortest = 2.0 * dx.max(dy);
    SelfAffine {
        hurst: 0.7,
        longest_wavelength: (0.7 * x.max(y)).max(shortest),
        shortest_wavelength: shortest,
        ..SelfAffine::with_rms_gradient(0.2)
    }
}

/// Compares the heights and their statistics between one process and `size` ranks.
fn compare(grid: &Grid, spectrum: &SelfAffine, seed: u64, size: usize) {
    let heights = spectrum.heights(grid, seed).unwrap();
    let statistics = Statistics::of(&heights, grid).unwrap();
    let each = ThreadRanks::of(size, |ranks| {
        let share = Share::among(ranks, grid.points(), 1).unwrap();
        let own = spectrum.heights_over(grid, seed, &share).unwrap();
        assert_eq!(own, heights.slice(s![share.rows(), ..]), "the rows of {size} ranks on {grid:?}");
        assert_eq!(Statistics::distributed(&own, grid, &share).unwrap(), statistics, "{size} ranks on {grid:?}");
        let moments = Moments::distributed(own.as_slice().unwrap(), grid, &share).unwrap();
        assert_eq!(moments, statistics.moments);
        own.len()
    });
    assert_eq!(each.into_iter().sum::<usize>(), grid.len());
}

#[test]
fn surfaces_and_statistics_over_ranks_have_the_bits_of_one_process() {
    // Tasks of modes that end inside the lanes of a rank, that span several ranks, and ranks without lanes.
    for points in [[256, 256], [1000, 512], [96, 2048], [2048, 64], [33, 4096], [4096, 4], [300, 6]] {
        let grid = Grid::new(points, [1.0, 1.3]).unwrap();
        let rough = spectrum(&grid);
        for size in [2, 3, 7].into_iter().filter(|size| *size <= Share::most(points, 1)) {
            compare(&grid, &rough, 5, size);
        }
    }
    let grid = Grid::square(256, 1.0).unwrap();
    let others = SelfAffine {
        scaling: Scaling::Ensemble,
        amplitudes: Amplitudes::Fixed,
        normalisation: Normalisation::RmsHeight(0.01),
        ..spectrum(&grid)
    };
    compare(&grid, &others, 6, 4);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn surfaces_over_ranks_have_the_bits_of_one_process_whatever_the_shape(
        rows in 8_usize..300, columns in 1_usize..40, exponent in 1_u32..6, size in 2_usize..=7, seed in 0_u64..100,
    ) {
        let columns = (columns << exponent).max(4);
        let grid = Grid::new([rows, columns], [1.0, columns as f64 / rows as f64]).unwrap();
        compare(&grid, &spectrum(&grid), seed, size.min(Share::most([rows, columns], 1)));
    }
}

#[test]
fn a_hole_that_one_rank_has_is_refused_by_all() {
    let grid = Grid::square(128, 1.0).unwrap();
    let mut heights = Array2::zeros((128, 128));
    (heights[[70, 3]], heights[[100, 5]]) = (f64::NAN, f64::INFINITY);
    let refused = ThreadRanks::of(3, |ranks| {
        let share = Share::among(ranks, grid.points(), 1).unwrap();
        Statistics::distributed(&heights.slice(s![share.rows(), ..]).to_owned(), &grid, &share).unwrap_err()
    });
    let is_hole = |error: &SurfaceError| matches!(error, SurfaceError::NotFinite { count: 2, first: [70, 3], .. });
    assert!(refused.iter().all(is_hole), "{refused:?}");
}
