use gfmd_field::Grid;
use ndarray::ArrayRef2;

use super::ratio::{Core, MaterialRatio};
use crate::SurfaceError;
use crate::statistics::checked;

/// Number of intervals of the curve.
const INTERVALS: usize = 200;

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

impl Bearing {
    /// Computes the curve of heights `[nx, ny]`, or of a profile `[n, 1]`.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid) -> Result<Self, SurfaceError> {
        let curve = MaterialRatio::of(&checked(heights, grid)?);
        let ratio: Vec<f64> = (0..=INTERVALS).map(|k| k as f64 / INTERVALS as f64).collect();
        let height = |ratio: &f64| curve.as_ref().map_or(0.0, |curve| curve.height(*ratio));
        Ok(Self { height: ratio.iter().map(height).collect(), ratio, core: curve.as_ref().map(MaterialRatio::core) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn a_tilted_plane_is_all_core() {
        let grid = Grid::new([100, 100], [1.0, 1.0]).unwrap();
        let plane = Array2::from_shape_fn((100, 100), |(i, j)| 5.0 + (i * 100 + j) as f64 / 9999.0);
        let found = Bearing::of(&plane, &grid).unwrap();
        assert!(found.ratio.iter().zip(&found.height).all(|(ratio, height)| (height - (0.5 - ratio)).abs() < 1e-12));
        let core = found.core.unwrap();
        assert!((core.sk - 1.0).abs() < 1e-9, "{core:?}");
        assert_eq!([core.spk, core.svk, core.spkx, core.svkx, core.smr1, core.smr2], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
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
}
