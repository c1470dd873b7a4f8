use std::sync::OnceLock;

use gfmd_field::Grid;
use gfmd_surface::PowerSpectrum;
use ndarray::{Array2, ArrayRef2};

use crate::Refusal;

/// A rigid rough surface, stored as the distance from its highest point. A constant in the heights has no effect.
#[derive(Clone, Debug)]
pub struct RigidSurface {
    grid: Grid,
    clearance: Vec<f64>,
    mean_clearance: f64,
    rms_height: f64,
    rms_gradient: OnceLock<f64>,
}

impl PartialEq for RigidSurface {
    fn eq(&self, other: &Self) -> bool {
        self.grid == other.grid && self.clearance == other.clearance
    }
}

impl RigidSurface {
    /// The surface with the profile `heights`, whose peaks point at the body, in length. It may be flat.
    ///
    /// # Errors
    /// Heights of another shape than the grid, not finite, or so different that their mean square overflows.
    pub fn new(grid: &Grid, heights: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let (found, expected) = (heights.dim().into(), grid.points());
        if found != expected {
            return Err(Refusal::Shape { found, expected });
        }
        if let Some(hole) = heights.iter().position(|h| !h.is_finite()) {
            let index = [hole / expected[1], hole % expected[1]];
            return Err(Refusal::Height { index, value: heights[index] });
        }
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let clearance: Vec<f64> = heights.iter().map(|h| highest - h).collect();
        let n = clearance.len() as f64;
        let mean_clearance = gfmd_vector::sum(clearance.len(), &|range| clearance[range].iter().sum()) / n;
        let squares = gfmd_vector::sum(clearance.len(), &|range| {
            clearance[range].iter().map(|c| (c - mean_clearance).powi(2)).sum()
        });
        let rms_height = (squares / n).sqrt();
        if !rms_height.is_finite() {
            return Err(Refusal::RmsHeight { found: rms_height });
        }
        Ok(Self { grid: *grid, clearance, mean_clearance, rms_height, rms_gradient: OnceLock::new() })
    }

    /// The grid of the heights.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The clearance, max h − h ≥ 0, the distance of the surface from its highest point, in length, row by row.
    pub fn clearance(&self) -> &[f64] {
        &self.clearance
    }

    /// Mean of the clearance, in length.
    pub fn mean_clearance(&self) -> f64 {
        self.mean_clearance
    }

    /// Root mean square of the heights about their mean, in length.
    pub fn rms_height(&self) -> f64 {
        self.rms_height
    }

    /// Spectral root mean square of the gradient |∇h| over the whole surface, dimensionless. Computed at the first
    /// call, by one transform.
    pub fn rms_gradient(&self) -> f64 {
        *self.rms_gradient.get_or_init(|| {
            let clearance = Array2::from_shape_vec(self.grid.points(), self.clearance.clone()).ok();
            let spectrum = clearance.and_then(|clearance| PowerSpectrum::of(&clearance, &self.grid).ok());
            spectrum.map_or(f64::NAN, |spectrum| spectrum.moments().rms_gradient())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_has_the_numbers_of_a_wave() {
        let grid = Grid::line(64, 2.0).unwrap();
        let heights = Array2::from_shape_fn((64, 1), |(i, _)| 0.3 * (std::f64::consts::TAU * i as f64 / 64.0).cos());
        let surface = RigidSurface::new(&grid, &heights).unwrap();
        approx::assert_relative_eq!(surface.mean_clearance(), 0.3, max_relative = 1e-14);
        approx::assert_relative_eq!(surface.rms_height(), 0.3 / 2_f64.sqrt(), max_relative = 1e-14);
        let gradient = surface.rms_height() * std::f64::consts::PI;
        approx::assert_relative_eq!(surface.rms_gradient(), gradient, max_relative = 1e-13);
    }

    #[test]
    fn unusable_heights_are_refused_and_flat_ones_are_not() {
        let grid = Grid::square(4, 1.0).unwrap();
        assert!(RigidSurface::new(&grid, &Array2::zeros((4, 4))).is_ok_and(|flat| flat.rms_height() == 0.0));
        let mut heights = Array2::zeros((4, 4));
        heights[[1, 2]] = f64::NAN;
        assert!(matches!(RigidSurface::new(&grid, &heights), Err(Refusal::Height { index: [1, 2], .. })));
        assert!(matches!(RigidSurface::new(&grid, &Array2::zeros((4, 5))), Err(Refusal::Shape { .. })));
        heights[[1, 2]] = 1e200;
        assert!(matches!(RigidSurface::new(&grid, &heights), Err(Refusal::RmsHeight { .. })));
    }
}
