use gfmd_field::Grid;
use gfmd_measure::quantile;
use ndarray::Array2;

use crate::SurfaceError;
use crate::statistics::checked;

/// The number of intervals of the curve.
const INTERVALS: usize = 200;

/// The fraction of the points from which the line of the core is found.
const CORE: f64 = 0.4;

/// The difference of heights, as a fraction of the range, that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// The bearing curve of Abbott and Firestone: the fraction of points at or above a height, which is the areal material
/// ratio of ISO 25178-2.
#[derive(Clone, Debug, PartialEq)]
pub struct Bearing {
    /// Material ratios from 0 to 1, in steps of 0.005.
    pub ratio: Vec<f64>,
    /// The height above the mean at which the surface has this ratio, from the highest to the lowest; length.
    pub height: Vec<f64>,
    /// The parameters of the curve; `None` for a flat surface.
    pub core: Option<Core>,
}

/// The parameters of the bearing curve, ISO 25178-2 and 13565-2, without a filter. The core is the straight line of
/// least squares through the least steep 40 % of the curve, the first of these if several are equally steep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Core {
    /// The height above the mean of the line of the core at the ratio 0, length.
    pub top: f64,
    /// Sk: height of the core, between the ends of its line at the ratios 0 and 1, length.
    pub sk: f64,
    /// Spk: reduced height of the peaks above the core, length: that of a triangle of equal area.
    pub spk: f64,
    /// Svk: reduced depth of the valleys below it, length.
    pub svk: f64,
    /// Smr1: material ratio between peaks and core.
    pub smr1: f64,
    /// Smr2: material ratio between core and valleys.
    pub smr2: f64,
}

impl Bearing {
    /// The curve of heights `[nx, ny]`, or of a profile `[n, 1]`.
    ///
    /// # Errors
    /// Heights of another shape than the grid, or not finite.
    pub fn of(heights: &Array2<f64>, grid: &Grid) -> Result<Self, SurfaceError> {
        let mut sorted = checked(heights, grid)?.into_owned();
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        sorted.sort_unstable_by(f64::total_cmp);
        sorted.iter_mut().for_each(|height| *height -= mean);
        let at = |ratio: f64| quantile(&sorted, 1.0 - ratio).unwrap_or(0.0);
        let ratio: Vec<f64> = (0..=INTERVALS).map(|k| k as f64 / INTERVALS as f64).collect();
        Ok(Self { height: ratio.iter().map(|ratio| at(*ratio)).collect(), ratio, core: Core::of(&sorted, at) })
    }
}

impl Core {
    /// The parameters from heights in ascending order and the function `at`, the height at a ratio.
    fn of(sorted: &[f64], at: impl Fn(f64) -> f64) -> Option<Self> {
        let (Some(lowest), Some(highest)) = (sorted.first(), sorted.last()) else { return None };
        let rounding = ROUNDING * (highest - lowest);
        if lowest == highest {
            return None;
        }
        let last = sorted.len() - 1;
        let ratio = |k: usize| k as f64 / last as f64;
        // The fall within a window is linear between windows that begin or end at a point.
        let starts = (0..=last).map(ratio).chain((0..=last).map(|k| ratio(k) - CORE));
        let falls: Vec<(f64, f64)> = starts
            .filter(|start| (0.0..=1.0 - CORE).contains(start))
            .map(|start| (start, at(start) - at((start + CORE).min(1.0))))
            .collect();
        let least = falls.iter().map(|(_, fall)| *fall).fold(f64::INFINITY, f64::min);
        let start = falls.iter().filter(|(_, fall)| *fall <= least + rounding).map(|(start, _)| *start);
        let start = start.fold(f64::INFINITY, f64::min);
        // The line of least squares, from the integrals of z and of (q - middle) z over the window.
        let middle = start + 0.5 * CORE;
        let [area, moment] = integrals(&at, last, [start, (start + CORE).min(1.0)], middle);
        let sk = -12.0 * moment / CORE.powi(3);
        let top = area / CORE + sk * middle;
        let bottom = top - sk;
        // The ratio at which the curve meets a level, and the area between both beyond it.
        let meets = |level: f64| {
            let below = sorted.partition_point(|height| *height <= level).clamp(1, last);
            let [low, high] = [sorted[below - 1], sorted[below]];
            1.0 - (below as f64 - 1.0 + (level - low) / (high - low)) / last as f64
        };
        let reduced = |area: f64, base: f64| if base > 0.0 { (2.0 * area / base).max(0.0) } else { 0.0 };
        let (mut smr1, mut spk, mut smr2, mut svk) = (0.0, 0.0, 1.0, 0.0);
        if highest - top > rounding {
            smr1 = meets(top);
            spk = reduced(integrals(&at, last, [0.0, smr1], 0.0)[0] - top * smr1, smr1);
        }
        if bottom - lowest > rounding {
            smr2 = meets(bottom);
            let base = 1.0 - smr2;
            svk = reduced(bottom * base - integrals(&at, last, [smr2, 1.0], 0.0)[0], base);
        }
        Some(Self { top, sk, spk, svk, smr1, smr2 })
    }
}

/// The integrals over a range of ratios q of z and of (q - middle) z, where z is linear between the ratios k/last.
fn integrals(at: impl Fn(f64) -> f64, last: usize, [from, to]: [f64; 2], middle: f64) -> [f64; 2] {
    let inner = (0..=last).map(|k| k as f64 / last as f64).filter(|q| from < *q && *q < to);
    let mut sums = [0.0; 2];
    let mut before = (from, at(from));
    for q in inner.chain([to]) {
        let next = (q, at(q));
        let ((a, low), (b, high)) = (before, next);
        let (left, right) = (a - middle, b - middle);
        sums[0] += 0.5 * (b - a) * (low + high);
        sums[1] += (b - a) / 6.0 * (low * (2.0 * left + right) + high * (left + 2.0 * right));
        before = next;
    }
    sums
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
        assert!((core.sk - 1.0).abs() < 1e-9 && core.spk < 1e-3 && core.svk < 1e-3, "{core:?}");
        assert_eq!(Bearing::of(&Array2::zeros((100, 100)), &grid).unwrap().core, None);
    }

    #[test]
    fn a_gaussian_has_the_parameters_of_its_integrals() {
        // Heights at equal steps, as often as the density says.
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
        // The window is centred, from z = 0.524401 to its negative. With x = 1/2 - q the moment of x z is
        // 2 [(Φ(√2 z) - 1/2)/(2√π) - 0.2 φ(z)] = 0.013726, and Sk = 12 × 0.013726/0.4³; beyond Sk/2 = 1.2868 lie
        // Q = 0.09908 of the points, with the area φ − 1.2868 Q = 0.046810, whose triangle has the height 2 × 0.04681/Q.
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 0.006, "{found} {wanted}");
        close(core.sk, 2.5737);
        close(core.spk, 0.9449);
        close(core.svk, 0.9449);
        close(core.smr1, 0.0991);
        close(core.smr2, 0.9009);
    }

    /// The parameters from a curve sampled at many ratios: each window is fitted by sums.
    fn sampled(sorted: &[f64]) -> Core {
        const SAMPLES: usize = 20_000;
        let curve: Vec<f64> =
            (0..SAMPLES).map(|k| quantile(sorted, 1.0 - (k as f64 + 0.5) / SAMPLES as f64).unwrap()).collect();
        let span = SAMPLES * 2 / 5;
        let fall = |start: usize| curve[start] - curve[start + span - 1];
        let start = (0..=SAMPLES - span).min_by(|a, b| fall(*a).total_cmp(&fall(*b))).unwrap();
        let ratio = |k: usize| (k as f64 + 0.5) / SAMPLES as f64;
        let window: Vec<[f64; 2]> = (start..start + span).map(|k| [ratio(k), curve[k]]).collect();
        let mean = [0, 1].map(|c| window.iter().map(|point| point[c]).sum::<f64>() / span as f64);
        let with = |c: usize| window.iter().map(|point| (point[0] - mean[0]) * (point[c] - mean[c])).sum::<f64>();
        let slope = with(1) / with(0);
        let top = mean[1] - slope * mean[0];
        let bottom = top + slope;
        let (above, below): (Vec<f64>, Vec<f64>) = (curve.iter().map(|z| z - top).filter(|z| *z > 0.0).collect(), {
            curve.iter().map(|z| bottom - z).filter(|z| *z > 0.0).collect()
        });
        let mean = |all: &[f64]| if all.is_empty() { 0.0 } else { 2.0 * all.iter().sum::<f64>() / all.len() as f64 };
        let part = |all: &[f64]| all.len() as f64 / SAMPLES as f64;
        let (smr1, smr2) = (part(&above), 1.0 - part(&below));
        Core { top, sk: -slope, spk: mean(&above), svk: mean(&below), smr1, smr2 }
    }

    #[test]
    fn any_surface_has_the_parameters_of_its_sampled_curve() {
        // Plateaus with deep valleys, sharp peaks, and few points; heights by a generator of equal numbers.
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
            let expected = sampled(&sorted);
            let range = sorted[count - 1] - sorted[0];
            let lengths = [found.top - expected.top, found.sk - expected.sk];
            let reduced = [found.spk - expected.spk, found.svk - expected.svk];
            let ratios = [found.smr1 - expected.smr1, found.smr2 - expected.smr2];
            // The samples are 5e-5 apart; ends of the window and levels lie between two of them.
            assert!(lengths.iter().all(|off| off.abs() < 3e-4 * range), "{case}: {found:?} {expected:?}");
            assert!(reduced.iter().all(|off| off.abs() < 2e-3 * range), "{case}: {found:?} {expected:?}");
            assert!(ratios.iter().all(|off| off.abs() < 1e-3), "{case}: {found:?} {expected:?}");
        }
    }
}
