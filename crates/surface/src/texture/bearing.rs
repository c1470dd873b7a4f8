use gfmd_field::Grid;
use gfmd_measure::quantile;
use ndarray::Array2;

use crate::SurfaceError;
use crate::statistics::checked;

/// The number of intervals of the curve.
const INTERVALS: usize = 200;

/// The number of intervals over which the secant of the core is sought.
const FINE: usize = 1000;

/// The fraction of the points that the secant spans.
const SECANT: f64 = 0.4;

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

/// The parameters of the bearing curve, ISO 25178-2 and 13565-2, without a filter. The core is the straight line
/// through the least steep 40 % of the curve.
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
        if sorted.first() == sorted.last() {
            return None;
        }
        let span = (SECANT * FINE as f64).round() as usize;
        let curve: Vec<f64> = (0..=FINE).map(|k| at(k as f64 / FINE as f64)).collect();
        let fall = |start: usize| curve[start] - curve[start + span];
        let start = (0..=FINE - span).min_by(|a, b| fall(*a).total_cmp(&fall(*b)))?;
        let slope = fall(start) / SECANT;
        let top = curve[start] + slope * start as f64 / FINE as f64;
        let bottom = top - slope;
        let count = sorted.len() as f64;
        let above = sorted.iter().filter(|height| **height > top);
        let below = sorted.iter().filter(|height| **height < bottom);
        let (peaks, valleys) = (above.clone().count() as f64 / count, below.clone().count() as f64 / count);
        let reduced = |area: f64, base: f64| if base > 0.0 { 2.0 * area / (count * base) } else { 0.0 };
        Some(Self {
            top,
            sk: slope,
            spk: reduced(above.map(|height| height - top).sum(), peaks),
            svk: reduced(below.map(|height| bottom - height).sum(), valleys),
            smr1: peaks,
            smr2: 1.0 - valleys,
        })
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
        // The secant is centred: z(0.3) = 0.524401, so Sk = 2 × 0.524401/0.4; beyond Sk/2 = 1.311 lie Q = 0.0949 of the
        // points, with the area φ − 1.311 Q = 0.04449, whose triangle has the height 2 × 0.04449/0.0949.
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 0.006, "{found} {wanted}");
        close(core.sk, 2.6220);
        close(core.spk, 0.9377);
        close(core.svk, 0.9377);
        close(core.smr1, 0.0949);
        close(core.smr2, 0.9051);
    }
}
