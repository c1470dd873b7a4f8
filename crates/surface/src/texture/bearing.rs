use gfmd_field::Grid;
use gfmd_measure::quantile;
use ndarray::Array2;

use crate::SurfaceError;
use crate::statistics::checked;

/// Number of intervals of the curve.
const INTERVALS: usize = 200;

/// Height difference that counts as rounding, as a fraction of the range.
const ROUNDING_OF_HEIGHT: f64 = 1e-9;

/// Bearing curve of Abbott and Firestone: fraction of points at or above a height (areal material ratio, ISO 25178-2).
#[derive(Clone, Debug, PartialEq)]
pub struct Bearing {
    /// Material ratios from 0 to 1, in steps of 0.005.
    pub ratio: Vec<f64>,
    /// Height above the mean at each ratio, from the highest to the lowest; length.
    pub height: Vec<f64>,
    /// Parameters of the curve; `None` for a flat surface.
    pub core: Option<Core>,
}

/// Parameters of the bearing curve of ISO 25178-2 and 13565-2, without a filter. The core is the least-squares line
/// through the least steep 40 % of the curve, the first one if several are equally steep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Core {
    /// Height of the core line above the mean at the ratio 0, length.
    pub top: f64,
    /// Sk: height of the core, between the ends of its line at the ratios 0 and 1, length.
    pub sk: f64,
    /// Spk: reduced height of the peaks above the core, the height of a triangle of equal area; length.
    pub spk: f64,
    /// Svk: reduced depth of the valleys below the core, length.
    pub svk: f64,
    /// Smr1: material ratio between peaks and core.
    pub smr1: f64,
    /// Smr2: material ratio between core and valleys.
    pub smr2: f64,
}

impl Bearing {
    /// Computes the curve of heights `[nx, ny]`, or of a profile `[n, 1]`.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &Array2<f64>, grid: &Grid) -> Result<Self, SurfaceError> {
        let mut sorted = checked(heights, grid)?.into_owned();
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        sorted.sort_unstable_by(f64::total_cmp);
        sorted.iter_mut().for_each(|height| *height -= mean);
        let at = |ratio: f64| quantile(&sorted, 1.0 - ratio).unwrap_or(0.0);
        let ratio: Vec<f64> = (0..=INTERVALS).map(|k| k as f64 / INTERVALS as f64).collect();
        Ok(Self { height: ratio.iter().map(|ratio| at(*ratio)).collect(), ratio, core: Core::of(&sorted) })
    }
}

impl Core {
    /// Computes the parameters from heights in ascending order. Point k from the highest has the ratio (k + 1/2)/n.
    /// Peaks and valleys are triangles with the area of the points beyond a level.
    fn of(sorted: &[f64]) -> Option<Self> {
        let (Some(lowest), Some(highest)) = (sorted.first(), sorted.last()) else { return None };
        let rounding = ROUNDING_OF_HEIGHT * (highest - lowest);
        if lowest == highest {
            return None;
        }
        let count = sorted.len();
        let of_core = (2 * count).div_ceil(5).max(2);
        let height = |k: usize| sorted[count - 1 - k];
        let fall = |start: usize| height(start) - height(start + of_core - 1);
        let least = (0..=count - of_core).map(fall).fold(f64::INFINITY, f64::min);
        let start = (0..=count - of_core).find(|start| fall(*start) <= least + rounding)?;
        let ratio = |k: usize| (k as f64 + 0.5) / count as f64;
        let core = start..start + of_core;
        let middle = ratio(start) + 0.5 * (of_core - 1) as f64 / count as f64;
        let mean = core.clone().map(height).sum::<f64>() / of_core as f64;
        let with = |of: &dyn Fn(usize) -> f64| core.clone().map(|k| (ratio(k) - middle) * of(k)).sum::<f64>();
        let sk = -with(&|k| height(k) - mean) / with(&|k| ratio(k) - middle);
        let top = mean + sk * middle;
        let bottom = top - sk;
        // Fraction of the points and twice their mean excess.
        let beyond = |excess: &dyn Fn(f64) -> f64| {
            let found = sorted.iter().map(|height| excess(*height)).filter(|excess| *excess > rounding);
            let (sum, points) = found.fold((0.0, 0.0), |(sum, points), excess| (sum + excess, points + 1.0));
            (points / count as f64, if points > 0.0 { 2.0 * sum / points } else { 0.0 })
        };
        let ((smr1, spk), (below, svk)) = (beyond(&|height| height - top), beyond(&|height| bottom - height));
        Some(Self { top, sk, spk, svk, smr1, smr2: 1.0 - below })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilted_plane_is_all_core() {
        let grid = Grid::new([100, 100], [1.0, 1.0]).unwrap();
        let plane = Array2::from_shape_fn((100, 100), |(i, j)| 5.0 + (i * 100 + j) as f64 / 9999.0);
        let found = Bearing::of(&plane, &grid).unwrap();
        assert!(found.ratio.iter().zip(&found.height).all(|(ratio, height)| (height - (0.5 - ratio)).abs() < 1e-12));
        let core = found.core.unwrap();
        // Each of the 10,000 points represents its part of the ratio.
        assert!((core.sk - 10_000.0 / 9999.0).abs() < 1e-9, "{core:?}");
        assert!(core.spk < 1e-3, "{core:?}");
        assert!(core.svk < 1e-3, "{core:?}");
        assert_eq!(Bearing::of(&Array2::zeros((100, 100)), &grid).unwrap().core, None);
    }

    #[test]
    fn a_gaussian_has_the_parameters_of_its_integrals() {
        // Heights at equal steps, repeated in proportion to the density.
        let heights: Vec<f64> = (-2500..=2500)
            .flat_map(|k| {
                let z = f64::from(k) / 500.0;
                let count = (500.0 * (-0.5 * z * z).exp()).round() as usize;
                std::iter::repeat_n(z, count)
            })
            .collect();
        let grid = Grid::line(heights.len(), 1.0).unwrap();
        let field = Array2::from_shape_vec((heights.len(), 1), heights).unwrap();
        let core = Bearing::of(&field, &grid).unwrap().core.unwrap();
        // The window is centred, from z = 0.524401 to its negative. With x = 1/2 - q the moment of x z is 2 [(Φ(√2 z) -
        // 1/2)/(2√π) - 0.2 φ(z)] = 0.013726, and Sk = 12 × 0.013726/0.4³; beyond Sk/2 = 1.2868 lie Q = 0.09908 of the
        // points, with the area φ − 1.2868 Q = 0.046810. Its triangle has the height 2 × 0.04681/Q.
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 0.006, "{found} {wanted}");
        close(core.sk, 2.5737);
        close(core.spk, 0.9449);
        close(core.svk, 0.9449);
        close(core.smr1, 0.0991);
        close(core.smr2, 0.9009);
    }

    /// Computes the parameters from all windows of two fifths of the points, from the highest, by the normal equations.
    fn fitted(sorted: &[f64]) -> Core {
        let heights: Vec<f64> = sorted.iter().rev().copied().collect();
        let count = heights.len();
        let span = (count * 4).div_ceil(10).max(2);
        let fall = |start: usize| heights[start] - heights[start + span - 1];
        let start = (0..=count - span).min_by(|a, b| fall(*a).total_cmp(&fall(*b))).unwrap();
        let [mut q, mut z, mut qq, mut qz] = [0.0; 4];
        for (k, height) in heights.iter().enumerate().skip(start).take(span) {
            let ratio = (k as f64 + 0.5) / count as f64;
            (q, z, qq, qz) = (q + ratio, z + height, qq + ratio * ratio, qz + ratio * height);
        }
        let n = span as f64;
        let slope = (n * qz - q * z) / (n * qq - q * q);
        let top = (z - slope * q) / n;
        let bottom = top + slope;
        let above: Vec<f64> = heights.iter().map(|z| z - top).filter(|z| *z > 0.0).collect();
        let below: Vec<f64> = heights.iter().map(|z| bottom - z).filter(|z| *z > 0.0).collect();
        let mean = |all: &[f64]| if all.is_empty() { 0.0 } else { 2.0 * all.iter().sum::<f64>() / all.len() as f64 };
        let part = |all: &[f64]| all.len() as f64 / count as f64;
        Core { top, sk: -slope, spk: mean(&above), svk: mean(&below), smr1: part(&above), smr2: 1.0 - part(&below) }
    }

    #[test]
    fn any_surface_has_the_parameters_of_the_line_through_its_points() {
        // Plateaus with deep valleys, sharp peaks, and few points; heights from a linear congruential generator.
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for case in 0..30 {
            let count = [400, 37, 6][case % 3];
            let power = [1.0, 3.0, 0.3, 6.0][case % 4];
            let sign = if case % 2 == 0 { 1.0 } else { -1.0 };
            let heights: Vec<f64> = (0..count).map(|_| sign * (-random().ln()).powf(power)).collect();
            let grid = Grid::line(count, 1.0).unwrap();
            let field = Array2::from_shape_vec((count, 1), heights).unwrap();
            let found = Bearing::of(&field, &grid).unwrap().core.unwrap();
            let mut sorted: Vec<f64> = field.iter().copied().collect();
            let mean = sorted.iter().sum::<f64>() / count as f64;
            sorted.sort_by(f64::total_cmp);
            sorted.iter_mut().for_each(|height| *height -= mean);
            let expected = fitted(&sorted);
            let range = sorted[count - 1] - sorted[0];
            let lengths = [found.top - expected.top, found.sk - expected.sk, found.spk - expected.spk];
            let others = [found.svk - expected.svk, found.smr1 - expected.smr1, found.smr2 - expected.smr2];
            assert!(lengths.iter().all(|off| off.abs() < 1e-9 * range), "{case}: {found:?} {expected:?}");
            assert!(others[0].abs() < 1e-9 * range && others[1..].iter().all(|off| off.abs() < 1e-12), "{case}");
        }
    }
}
