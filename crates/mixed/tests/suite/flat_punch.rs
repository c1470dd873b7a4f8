//! Points below a flat punch.

use gfmd_field::Grid;
use gfmd_mixed::{Edge, FlatPunch, MixedError};

#[test]
fn points_on_the_edge_are_told_whatever_the_rounding() {
    for (fraction, n, strict) in [(0.25, 128, 31), (0.25, 16, 3), (0.3, 100, 29), (0.7, 1000, 699), (0.1, 70, 7)] {
        let grid = Grid::square(n, 1.3).unwrap();
        let [inner, outer] = [Edge::Strict, Edge::Inclusive].map(|edge| FlatPunch::new(fraction, edge).unwrap());
        assert_eq!(inner.points_across(&grid), strict);
        let on_edge = if (fraction * n as f64).round() as usize % 2 == n % 2 { 2 } else { 0 };
        assert_eq!(outer.points_across(&grid), strict + on_edge, "{fraction} {n}");
        assert_eq!(inner.points(&grid).iter().filter(|under| **under).count(), strict * strict);
    }
}

#[test]
fn a_punch_narrower_than_the_grid_may_miss_every_point() {
    let punch = FlatPunch::new(0.05, Edge::Inclusive).unwrap();
    assert!(!punch.points(&Grid::line(15, 1.0).unwrap()).iter().any(|under| *under));
    for fraction in [0.0, -0.1, 1.0, 2.0, f64::NAN] {
        assert!(matches!(FlatPunch::new(fraction, Edge::Strict), Err(MixedError::Fraction(_))));
    }
}
