use gfmd_field::Grid;
use ndarray::{ArrayRef2, Axis};

use crate::SurfaceError;
use crate::statistics::checked;
use crate::texture::ratio::{Core, MaterialRatio, Volumes};

/// Height, function and volume parameters of ISO 25178-2 (ISO 4287 for a profile) about the mean height, without form
/// removal and filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Areal {
    /// Sa: mean distance from the mean height, length.
    pub sa: f64,
    /// Sq: root mean square distance from the mean height, length.
    pub sq: f64,
    /// Sp: highest height above the mean, length.
    pub sp: f64,
    /// Sv: depth of the lowest point below the mean, length.
    pub sv: f64,
    /// Sz = Sp + Sv, length.
    pub sz: f64,
    /// Ssk: mean cubed height divided by Sq³, positive if peaks are sharper than valleys; `None` for a flat surface.
    pub ssk: Option<f64>,
    /// Sku: mean fourth power of the height divided by Sq⁴, 3 for a Gaussian surface; `None` for a flat surface.
    pub sku: Option<f64>,
    /// Sdr: developed area divided by projected area, minus 1; the ratio of lengths for a profile. Each cell of four
    /// neighbours is split into two triangles, the mean of both ways to do so; none crosses the periodic seam.
    pub sdr: f64,
    /// Parameters of the bearing curve; `None` for a flat surface.
    pub core: Option<Core>,
    /// Volumes of material and voids; `None` for a flat surface.
    pub volumes: Option<Volumes>,
}

impl Areal {
    /// Computes the parameters of heights `[nx, ny]`, or of a profile `[n, 1]`.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid) -> Result<Self, SurfaceError> {
        let all = checked(heights, grid)?;
        let count = all.len() as f64;
        let mean_of = |value: &dyn Fn(f64) -> f64| {
            let row = |row: ndarray::ArrayView1<'_, f64>| row.iter().map(|height| value(*height)).sum::<f64>();
            heights.axis_iter(Axis(0)).map(row).sum::<f64>() / count
        };
        let mean = mean_of(&|height| height);
        let power = |power: i32| mean_of(&|height| (height - mean).powi(power));
        let sq = power(2).sqrt();
        let highest = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = all.iter().copied().fold(f64::INFINITY, f64::min);
        let over = |moment: i32| (sq > 0.0).then(|| mean_of(&|height| ((height - mean) / sq).powi(moment)));
        let curve = MaterialRatio::of(&all);
        Ok(Self {
            sa: mean_of(&|height| (height - mean).abs()),
            sq,
            sp: highest - mean,
            sv: mean - lowest,
            sz: highest - lowest,
            ssk: over(3),
            sku: over(4),
            sdr: developed(heights, grid),
            core: curve.as_ref().map(MaterialRatio::core),
            volumes: curve.as_ref().map(MaterialRatio::volumes),
        })
    }
}

/// Returns the area of the triangles between the points divided by their projected area, minus 1.
fn developed(heights: &ArrayRef2<f64>, grid: &Grid) -> f64 {
    let ([nx, ny], [dx, dy]) = (heights.dim().into(), grid.spacing());
    // √(1 + g²) − 1 without cancellation at small slopes.
    let excess = |square: f64| square / (1.0 + (1.0 + square).sqrt());
    let slope = |to: [usize; 2], from: [usize; 2], step: f64| ((heights[to] - heights[from]) / step).powi(2);
    let (mut sum, mut cells) = (0.0, 0_usize);
    for i in 0..nx - 1 {
        if ny == 1 {
            (sum, cells) = (sum + excess(slope([i + 1, 0], [i, 0], dx)), cells + 1);
        }
        for j in 0..ny - 1 {
            let x = [0, 1].map(|b| slope([i + 1, j + b], [i, j + b], dx));
            let y = [0, 1].map(|a| slope([i + a, j + 1], [i + a, j], dy));
            // Both triangles beside one diagonal, and both beside the other one.
            let triangles = [x[0] + y[0], x[1] + y[1], x[0] + y[1], x[1] + y[0]];
            (sum, cells) = (sum + 0.25 * triangles.map(excess).iter().sum::<f64>(), cells + 1);
        }
    }
    sum / cells as f64
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;
    use std::f64::consts::{PI, TAU};

    use super::*;

    #[test]
    fn a_wave_has_its_parameters() {
        let grid = Grid::square(256, 2.0).unwrap();
        let wave = Array2::from_shape_fn((256, 256), |(i, _)| 3.0 + 0.2 * (TAU * i as f64 / 256.0).cos());
        let found = Areal::of(&wave, &grid).unwrap();
        let close =
            |found: f64, expected: f64, error: f64| assert!((found - expected).abs() < error, "{found} {expected}");
        close(found.sa, 0.4 / PI, 1e-5);
        close(found.sq, 0.2 / 2.0_f64.sqrt(), 1e-14);
        close(found.sp, 0.2, 1e-14);
        close(found.sz, 0.4, 1e-14);
        close(found.ssk.unwrap(), 0.0, 1e-13);
        close(found.sku.unwrap(), 1.5, 1e-13);
        // Half the mean square slope minus an eighth of the mean fourth power of the slope.
        let square = (0.2 * PI).powi(2) / 2.0;
        close(found.sdr, square / 2.0 - 1.5 * square * square / 8.0, 0.02 * square);
        let line = Grid::line(256, 2.0).unwrap();
        let profile = Areal::of(&wave.slice(ndarray::s![.., ..1]).to_owned(), &line).unwrap();
        close(profile.sdr, found.sdr, 1e-13);
        close(profile.sa, found.sa, 1e-13);
    }

    #[test]
    fn a_plane_is_as_long_as_its_slope_says() {
        let grid = Grid::new([5, 7], [5.0, 3.5]).unwrap();
        let plane = Array2::from_shape_fn((5, 7), |(i, j)| 3.0 * i as f64 + 2.0 * j as f64);
        let found = Areal::of(&plane, &grid).unwrap();
        assert!((found.sdr - (26.0_f64.sqrt() - 1.0)).abs() < 1e-14, "{found:?}");
        let flat = Areal::of(&Array2::from_elem((5, 7), 2.0), &grid).unwrap();
        assert_eq!((flat.sq, flat.ssk, flat.sku, flat.sdr), (0.0, None, None, 0.0));
        assert!(Areal::of(&Array2::zeros((4, 7)), &grid).is_err());
    }
}
