//! Grids and their modes.

use gfmd_field::{Grid, GridError, Mode};
use num_complex::Complex64;

/// Largest number of modes with a spectrum that fits into memory.
const MOST_POINTS: usize = isize::MAX as usize / size_of::<Complex64>();

#[test]
fn weights_count_the_full_spectrum() {
    for points in [[8, 8], [7, 8], [8, 7], [9, 5], [1, 6], [6, 1], [7, 1], [1, 1], [2, 2]] {
        let grid = Grid::new(points, [1.0, 2.0]).unwrap();
        let total: f64 = grid.modes().map(|mode| mode.weight).sum();
        assert_eq!(total, grid.len() as f64, "{points:?}");
        assert_eq!(grid.modes().count(), grid.spectrum_len());
        assert_eq!(grid.modes().filter(Mode::is_uniform).count(), 1);
    }
}

#[test]
fn each_stored_mode_is_found_at_its_place_and_no_other_mode_is() {
    for points in [[8, 8], [7, 8], [8, 7], [9, 5], [1, 6], [6, 1], [7, 1], [1, 1], [2, 2]] {
        let grid = Grid::new(points, [1.0, 2.0]).unwrap();
        for (index, mode) in grid.modes().enumerate() {
            assert_eq!(grid.mode_at(index), mode);
            assert_eq!(grid.index_of(mode.number), Some(index), "{points:?}");
        }
        let stored = (-9..=9).flat_map(|m| (-9..=9).map(move |n| [m, n]));
        assert_eq!(stored.filter(|number| grid.index_of(*number).is_some()).count(), grid.spectrum_len());
    }
}

#[test]
fn grids_beyond_memory_are_refused() {
    for points in [[usize::MAX, 2], [1 << 32, 1 << 32], [1 << 60, 1], [1, 1 << 60], [1 << 30, 1 << 30]] {
        let refused = Grid::new(points, [1.0, 1.0]);
        assert_eq!(refused, Err(GridError::TooManyPoints { found: points, most: MOST_POINTS }));
    }
    let largest = Grid::new([MOST_POINTS, 1], [1.0, 1.0]).unwrap();
    assert!(largest.spectrum_len() <= MOST_POINTS);
}

#[test]
fn impossible_grids_are_refused() {
    assert_eq!(Grid::square(0, 1.0), Err(GridError::NoPoints([0, 0])));
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Grid::line(4, length), Err(GridError::Length(_))));
    }
}
