use ndarray::{Array2, ArrayRef2};

use crate::SurfaceError;
use crate::error::positive;
use crate::names::named;
use crate::random::Normal;

/// Largest number of subdivisions of a profile: 2²⁸ + 1 points.
const MOST_ALONG_A_LINE: u32 = 28;

/// Largest number of subdivisions of a surface: (2¹⁴ + 1)² points.
const MOST_OVER_THE_PLANE: u32 = 14;

/// Fractional Brownian motion by repeated halving of intervals (theory.md, section 9).
///
/// The method is simple, fast and inexact; use [`crate::SelfAffine`] for quantitative work. The heights are not
/// periodic and have no sharp cut-offs (the band ends near the spacing). Surfaces are not isotropic: the lattice of the
/// subdivision appears as creases. With midpoint displacement, increments off that lattice have the wrong variance: up
/// to +24 % for H = 0.3, 0 for H = 0.5, −13 % for H = 0.8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealSpace {
    /// Hurst exponent H, from 0 to 1.
    pub hurst: f64,
    /// Number k of halvings of a side, which give 2^k + 1 points.
    pub subdivisions: u32,
    /// Root-mean-square increment σ of the height over one side, length.
    pub rms_increment: f64,
    /// Points that are displaced.
    pub displaced: Displaced,
}

/// Points that a subdivision displaces, by normal numbers of variance ∝ 2^{−2Hi} in the i-th halving of lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Displaced {
    /// New points only: random midpoint displacement, for a surface by the diamond-square algorithm. The variance is
    /// Δ_i² = σ²(1 − 2^{2H−2}) 2^{−2Hi}, which is exact for increments between lattice neighbours (profiles). Coarse
    /// points do not change when the number of subdivisions grows.
    Midpoints,
    /// All points of the lattice: successive random addition, variance Δ_i²/2. The result is smoother than with
    /// midpoint displacement. All increments on the lattice are too large by one factor, 1 + (1 − 2^{2H−2})/(2^{2H} −
    /// 1) after many subdivisions (profiles).
    AllPoints,
}

named! { Displaced, "method of subdivision":
    AllPoints = "sra", "successive random addition";
    Midpoints = "rmd", "random midpoint displacement";
}

impl RealSpace {
    /// Generates a profile, shape `[2^k + 1, 1]`, length, starting at zero.
    ///
    /// # Errors
    /// H outside \[0, 1\]; a σ that is not positive; no subdivision or more than 28.
    pub fn profile(&self, seed: u64) -> Result<Array2<f64>, SurfaceError> {
        self.check(MOST_ALONG_A_LINE)?;
        let intervals = 1_usize << self.subdivisions;
        let (mut normal, mut heights) = (Normal::new(seed), vec![0.0; intervals + 1]);
        heights[intervals] = self.rms_increment * normal.next();
        for (level, stride) in (1..=self.subdivisions).map(|level| (level, intervals >> level)) {
            let displacement = self.displacement(2.0 * f64::from(level));
            for middle in (stride..intervals).step_by(2 * stride) {
                heights[middle] = 0.5 * (heights[middle - stride] + heights[middle + stride]);
            }
            let (first, step) = match self.displaced {
                Displaced::Midpoints => (stride, 2 * stride),
                Displaced::AllPoints => (0, stride),
            };
            for height in heights[first..].iter_mut().step_by(step) {
                *height += displacement * normal.next();
            }
        }
        let found = [heights.len(), 1];
        Array2::from_shape_vec((intervals + 1, 1), heights).map_err(|_| SurfaceError::Shape { found, expected: found })
    }

    /// Generates a surface, shape `[2^k + 1, 2^k + 1]`, length. The corners are drawn with variance σ²/2. Each
    /// subdivision adds centres of squares from four corners (diamond), then centres of edges from four neighbours,
    /// three at the border (square). Each of the two half-steps shortens lengths by √2: Δ_i² ∝ 2^{−Hi} in half-step i.
    ///
    /// # Errors
    /// H outside \[0, 1\]; a σ that is not positive; no subdivision or more than 14.
    pub fn surface(&self, seed: u64) -> Result<Array2<f64>, SurfaceError> {
        self.check(MOST_OVER_THE_PLANE)?;
        let side = 1_usize << self.subdivisions;
        let (mut normal, mut heights) = (Normal::new(seed), Array2::zeros((side + 1, side + 1)));
        for corner in [[0, 0], [0, side], [side, 0], [side, side]] {
            heights[corner] = self.rms_increment * 0.5_f64.sqrt() * normal.next();
        }
        for level in 0..self.subdivisions {
            let stride = side >> (level + 1);
            let all = self.displaced == Displaced::AllPoints;
            interpolate(&mut heights, stride, is_centre, [[1, 1], [1, -1], [-1, 1], [-1, -1]]);
            let displacement = self.displacement(f64::from(2 * level + 1));
            displace(&mut heights, stride, |at| is_centre(at) || all && !is_edge(at), displacement, &mut normal);
            interpolate(&mut heights, stride, is_edge, [[1, 0], [-1, 0], [0, 1], [0, -1]]);
            let displacement = self.displacement(f64::from(2 * level + 2));
            displace(&mut heights, stride, |at| is_edge(at) || all, displacement, &mut normal);
        }
        Ok(heights)
    }

    /// Returns the root-mean-square displacement after `half_steps` divisions of lengths by √2.
    fn displacement(&self, half_steps: f64) -> f64 {
        let new = (1.0 - 2.0_f64.powf(2.0 * self.hurst - 2.0)) * 2.0_f64.powf(-self.hurst * half_steps);
        let share = match self.displaced {
            Displaced::Midpoints => 1.0,
            Displaced::AllPoints => 0.5,
        };
        self.rms_increment * (share * new).sqrt()
    }

    fn check(&self, most: u32) -> Result<(), SurfaceError> {
        if !(0.0..=1.0).contains(&self.hurst) {
            return Err(SurfaceError::Hurst(self.hurst));
        }
        if !(1..=most).contains(&self.subdivisions) {
            return Err(SurfaceError::Subdivisions { found: self.subdivisions, most });
        }
        positive("rms increment", self.rms_increment).map(|_| ())
    }
}

/// Returns true if a point of the present lattice is the centre of a square of the previous one.
fn is_centre(at: [usize; 2]) -> bool {
    at[0] % 2 == 1 && at[1] % 2 == 1
}

/// Returns true if a point of the present lattice is the centre of an edge of the previous one.
fn is_edge(at: [usize; 2]) -> bool {
    (at[0] + at[1]) % 2 == 1
}

/// Sets every `wanted` point of the lattice with this stride to the mean of its neighbours inside the surface.
fn interpolate(
    heights: &mut Array2<f64>,
    stride: usize,
    wanted: impl Fn([usize; 2]) -> bool,
    neighbours: [[isize; 2]; 4],
) {
    for at in lattice(heights, stride).filter(|&at| wanted(at)) {
        let (mut sum, mut count) = (0.0, 0.0);
        for [along_x, along_y] in neighbours {
            let [i, j] = [at[0].wrapping_add_signed(along_x), at[1].wrapping_add_signed(along_y)];
            if let Some(height) = heights.get([i.wrapping_mul(stride), j.wrapping_mul(stride)]) {
                sum += height;
                count += 1.0;
            }
        }
        heights[at.map(|index| index * stride)] = sum / count;
    }
}

/// Adds a normal number of standard deviation `size` to every `wanted` point of the lattice.
fn displace(
    heights: &mut Array2<f64>,
    stride: usize,
    wanted: impl Fn([usize; 2]) -> bool,
    size: f64,
    normal: &mut Normal,
) {
    for at in lattice(heights, stride).filter(|&at| wanted(at)) {
        heights[at.map(|index| index * stride)] += size * normal.next();
    }
}

/// Iterates over the indices of the lattice with this stride, row by row.
fn lattice(heights: &ArrayRef2<f64>, stride: usize) -> impl Iterator<Item = [usize; 2]> + use<> {
    let points = (heights.nrows() - 1) / stride + 1;
    (0..points).flat_map(move |i| (0..points).map(move |j| [i, j]))
}
