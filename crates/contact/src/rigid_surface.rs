use std::ops::Range;
use std::sync::OnceLock;

use gfmd_field::{Grid, Share};
use gfmd_measure::Boundary;
use gfmd_response::unit_of;
use gfmd_surface::{Moments, Statistics};
use gfmd_vector::{once, reduce};
use ndarray::{ArcArray2, Array2, ArrayRef2};

use crate::{Clearance, Heights, Load, Refusal, Units};

/// Rigid rough surface. A constant in the heights has no effect. Each of several processes has its rows; the numbers
/// describe the whole surface.
#[derive(Clone, Debug)]
pub struct RigidSurface {
    grid: Grid,
    share: Share,
    /// Heights in standard order, in a length of `unit`.
    heights: ArcArray2<f64>,
    /// Height from which the clearance is measured.
    top: f64,
    unit: f64,
    mean_clearance: f64,
    rms_height: f64,
    /// Rounding error of a difference of two heights as given.
    rounding: f64,
    /// True if rounding errors decide which of the heights of this process touch first.
    is_uncertain: bool,
    boundary: Boundary,
    rms_gradient: OnceLock<f64>,
}

/// Length scale of the residuals divided by the prescribed approach, if the approach is very small.
const OF_THE_APPROACH: f64 = 1e6;

/// Length scale of the residuals divided by the extent of the displacement, if the extent is very small. A tolerance of
/// 1e-8 then leaves errors of 1e-5 of the displacement. On rough surfaces the displacement is a larger part of h_rms at
/// all but the smallest loads.
const OF_THE_DISPLACEMENT: f64 = 1e3;

/// Least load divided by the softest stiffness times h_rms, and least approach divided by h_rms.
const LEAST: f64 = 1e-100;

impl PartialEq for RigidSurface {
    fn eq(&self, other: &Self) -> bool {
        let is_like = |other: Clearance| self.clearance().iter().eq(other.iter());
        self.grid == other.grid && self.boundary == other.boundary && is_like(other.clearance())
    }
}

impl RigidSurface {
    /// Makes the surface with the profile `heights`, in length, with peaks towards the body. It may be flat.
    ///
    /// # Errors
    /// Heights that differ in shape from the grid, are not finite, or differ by more than the largest number.
    pub fn new<'a>(grid: &Grid, heights: impl Into<Heights<'a>>) -> Result<Self, Refusal> {
        let [rows, columns] = grid.rows();
        Self::distributed(&Share::whole(rows, columns), grid, heights)
    }

    /// Makes the surface as [`new`](Self::new), from the rows of this process, its `share`; all make the same calls.
    ///
    /// # Errors
    /// As [`new`](Self::new), on all processes.
    pub fn distributed<'a>(share: &Share, grid: &Grid, heights: impl Into<Heights<'a>>) -> Result<Self, Refusal> {
        Self::shared(share, grid, heights.into())
    }

    fn shared(share: &Share, grid: &Grid, heights: Heights) -> Result<Self, Refusal> {
        let (found, expected) = (heights.shape(), shape(share, grid));
        if share.any(found != expected) {
            return Err(Refusal::Shape { found, expected });
        }
        let (heights, unit) = heights.shared();
        let values = slice_of(&heights);
        let start = share.own().start;
        let hole_in = |mut range: Range<usize>| range.find(|i| !values[*i].is_finite());
        let hole = reduce(values.len(), &hole_in, &|first: Option<usize>, other| first.or(other));
        let hole = hole.map(|hole| (start + hole, values[hole] / unit));
        if let Some((hole, value)) = share.first(hole) {
            return Err(Refusal::Height { index: [hole / expected[1], hole % expected[1]], value });
        }
        let wider = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let own =
            reduce(values.len(), &|range| values[range].iter().fold(none, |ends, h| wider(ends, [*h; 2])), &wider);
        let [bottom, top] = share.each(own).into_iter().fold(none, wider);
        let clearance = Clearance::below(top, values).in_unit(unit);
        let n = share.total() as f64;
        let mean_clearance = share.sum(&|range| clearance.part(range).iter().sum()) / n;
        let rounding = f64::EPSILON * top.abs().max(bottom.abs()) / unit;
        let is_uncertain = clearance.iter().any(|c| c > 0.0 && c <= rounding);
        // The squares of very large or small heights overflow or vanish. A power of two changes no digit.
        let scale = unit_of((top - bottom) / unit);
        let squares =
            share.sum(&|range| clearance.part(range).iter().map(|c| ((c - mean_clearance) / scale).powi(2)).sum());
        let rms_height = (squares / n).sqrt() * scale;
        if !(rms_height.is_finite() && mean_clearance.is_finite()) {
            return Err(Refusal::RmsHeight { found: rms_height });
        }
        let (share, rms_gradient) = (share.clone(), OnceLock::new());
        let surface = Self {
            grid: *grid,
            share,
            heights,
            top,
            unit,
            mean_clearance,
            rms_height,
            rounding,
            is_uncertain,
            boundary: Boundary::Periodic,
            rms_gradient,
        };
        if !surface.share.is_whole() {
            // All processes take part in its transform, but not all may ask for it later.
            surface.rms_gradient();
        }
        Ok(surface)
    }

    /// Returns the surface as a patch that does not repeat, without the step from its last to its first points.
    #[must_use]
    pub fn alone(self) -> Self {
        let patch = Self { boundary: Boundary::Free, rms_gradient: OnceLock::new(), ..self };
        if !patch.share.is_whole() {
            // All processes take part in its sums, but not all may ask for it later.
            patch.rms_gradient();
        }
        patch
    }

    /// Returns two surfaces on equal grids as one, with the rows of `lower` after the rows of `upper`: the surfaces
    /// that press the two faces of a plate. Each keeps its own highest point. The squares of their rms heights add, and
    /// the rms gradient is the larger one.
    ///
    /// # Errors
    /// Surfaces of different shapes, or of too many points.
    pub fn stacked(upper: &Self, lower: &Self) -> Result<Self, Refusal> {
        let ([found, expected], [nx, ny]) = ([lower.shape(), upper.shape()], upper.grid.points());
        let (true, Ok(grid)) = (found == expected, Grid::new([2 * nx, ny], upper.grid.lengths())) else {
            return Err(Refusal::Shape { found, expected });
        };
        let shape = [2 * found[0], found[1]];
        Ok(Self {
            grid,
            share: upper.share.of_faces(),
            heights: below_zero(shape, upper.clearance().iter().chain(lower.clearance().iter())),
            top: 0.0,
            unit: 1.0,
            mean_clearance: 0.5 * (upper.mean_clearance + lower.mean_clearance),
            rms_height: upper.rms_height.hypot(lower.rms_height),
            rounding: upper.rounding.max(lower.rounding),
            is_uncertain: upper.is_uncertain || lower.is_uncertain,
            boundary: Boundary::Periodic,
            rms_gradient: OnceLock::from(upper.rms_gradient().max(lower.rms_gradient())),
        })
    }

    /// Returns the boundary condition of the fields on the surface.
    pub fn boundary(&self) -> Boundary {
        self.boundary
    }

    /// Returns the surface with `depth` added to its clearance. Its rms height and gradient do not change.
    pub fn with_indentation(&self, depth: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let (share, found, expected) = (&self.share, depth.dim().into(), self.shape());
        if share.any(found != expected) {
            return Err(Refusal::Shape { found, expected });
        }
        let before = self.clearance();
        let heights = below_zero(expected, before.iter().zip(depth).map(|(c, d)| c + d));
        let clearance = Clearance::below(0.0, slice_of(&heights));
        let start = share.own().start;
        let hole = clearance.iter().position(|c| !c.is_finite()).map(|hole| (start + hole, clearance.at(hole)));
        if let Some((hole, value)) = share.first(hole) {
            return Err(Refusal::Height { index: [hole / expected[1], hole % expected[1]], value });
        }
        let mean_clearance = share.sum(&|range| clearance.part(range).iter().sum()) / share.total() as f64;
        // The clearance of a top has no rounding error, nor has the sum of zero and a depth.
        let is_near = |(before, after): (f64, f64)| before > 0.0 && after.abs() <= self.rounding;
        let is_uncertain = before.iter().zip(clearance.iter()).any(is_near);
        let rms_gradient = OnceLock::from(self.rms_gradient());
        Ok(Self { heights, top: 0.0, unit: 1.0, mean_clearance, rms_gradient, is_uncertain, ..self.clone() })
    }

    /// Returns the surface in other units of lengths and heights, given in the present units: powers of two.
    pub(crate) fn in_units(&self, units: &Units) -> Self {
        Self {
            grid: units.grid(&self.grid),
            share: self.share.clone(),
            heights: self.heights.clone(),
            top: self.top,
            unit: self.unit * units.length(),
            mean_clearance: self.mean_clearance / units.length(),
            rms_height: self.rms_height / units.length(),
            rounding: self.rounding / units.length(),
            is_uncertain: self.is_uncertain,
            boundary: self.boundary,
            rms_gradient: if self.share.is_whole() {
                OnceLock::new()
            } else {
                OnceLock::from(self.rms_gradient() / units.gradient())
            },
        }
    }

    /// Returns the rows of this process, all of them if it is alone.
    pub fn share(&self) -> &Share {
        &self.share
    }

    /// Returns the shape of the fields of this process.
    pub fn shape(&self) -> [usize; 2] {
        shape(&self.share, &self.grid)
    }

    /// Returns the grid of the heights.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns the clearance, row by row of this process.
    pub fn clearance(&self) -> Clearance<'_> {
        Clearance::below(self.top, slice_of(&self.heights)).in_unit(self.unit)
    }

    /// Returns the mean clearance, in length.
    pub fn mean_clearance(&self) -> f64 {
        self.mean_clearance
    }

    /// Returns the root mean square of the heights about their mean, in length.
    pub fn rms_height(&self) -> f64 {
        self.rms_height
    }

    /// Returns the length scale of the residuals of a contact without attraction, before its displacement is known:
    /// h_rms, or a million times the prescribed approach if that is less. Errors that are small compared with h_rms may
    /// exceed a very small approach.
    pub fn length_scale(&self, load: Load) -> f64 {
        Self::scale_of(self.rms_height, load)
    }

    /// Returns the [length scale](Self::length_scale) for an rms height.
    pub(crate) fn scale_of(rms_height: f64, load: Load) -> f64 {
        match load {
            Load::Approach(approach) if approach > 0.0 => rms_height.min(OF_THE_APPROACH * approach),
            _ => rms_height,
        }
    }

    /// Returns the length scale of the residuals of a contact with a surface displacement of this `extent` (largest
    /// minus smallest): `scale`, or a thousand times the extent if that is less. On a surface with flat tops errors
    /// that are small compared with h_rms may exceed the displacement. Without displacement it is `scale`.
    pub fn finer_scale(scale: f64, extent: f64) -> f64 {
        if extent > 0.0 { scale.min(OF_THE_DISPLACEMENT * extent) } else { scale }
    }

    /// Checks that the rounding errors of the heights do not decide a contact with residuals relative to `scale`, which
    /// is less than h_rms because the displacement is very small. The errors must be below the tolerance, or no point
    /// may be within them of the highest. Points exactly as high as the highest are a flat top and do no harm.
    ///
    /// # Errors
    /// The load, with the least possible one.
    pub(crate) fn check_heights(&self, load: Load, scale: f64, tolerance: f64) -> Result<(), Refusal> {
        let allowed = tolerance * scale;
        if self.rounding <= allowed || !self.share.any(self.is_uncertain) {
            return Ok(());
        }
        let (what, found) = load.named();
        Err(Refusal::LoadBelowRoughnessRounding { what, found, least: found * (self.rounding / allowed) })
    }

    /// Checks that the numbers of a contact without attraction under `load` can be resolved: squares of much smaller
    /// loads and approaches vanish, and the rounding errors of much larger ones exceed the `tolerance`. `softest` is
    /// the smallest stiffness of a wave, in stress/length.
    ///
    /// # Errors
    /// The load, with the largest or smallest possible one.
    pub fn check_resolution(&self, load: Load, softest: f64, tolerance: f64) -> Result<(), Refusal> {
        let (what, found, unit) = match load {
            Load::MeanPressure(mean) => ("mean pressure", mean, softest * self.rms_height),
            Load::Approach(approach) => ("approach", approach, self.rms_height),
        };
        let least = LEAST * unit;
        if found < least {
            return Err(Refusal::LoadUnderflows { what, found, least });
        }
        Self::check_rounding(what, found, unit, tolerance)
    }

    /// Checks that the displacement by a traction of size `found` can be resolved: its rounding error follows from the
    /// softest wave, even if most of the traction deforms the body less. `softest` is the smallest stiffness of a wave,
    /// in stress/length, and `what` the name of the traction.
    ///
    /// # Errors
    /// The traction, with the largest possible one.
    pub fn check_traction(&self, what: &'static str, found: f64, softest: f64, tolerance: f64) -> Result<(), Refusal> {
        Self::check_rounding(what, found, softest * self.rms_height, tolerance)
    }

    fn check_rounding(what: &'static str, found: f64, unit: f64, tolerance: f64) -> Result<(), Refusal> {
        let most = tolerance / f64::EPSILON * unit;
        if found > most { Err(Refusal::Rounding { what, found, most, tolerance }) } else { Ok(()) }
    }

    /// Returns the root mean square of the gradient |∇h| over the whole surface, dimensionless: from the spectrum or,
    /// if the surface does not repeat, from the differences between neighbours. Computed at the first call.
    pub fn rms_gradient(&self) -> f64 {
        *once(&self.rms_gradient, || {
            let units = Units::of_surface(self);
            let clearance: Vec<f64> = self.clearance().iter().map(|c| c / units.length()).collect();
            let grid = units.grid(&self.grid);
            let gradient = if self.boundary == Boundary::Periodic {
                Moments::distributed(&clearance, &grid, &self.share).map(|moments| moments.rms_gradient())
            } else {
                let Ok(clearance) = Array2::from_shape_vec(self.shape(), clearance) else { return f64::NAN };
                let statistics = Statistics::distributed(&clearance, &grid, &self.share);
                statistics.map(|statistics| statistics.rms_gradient_inside)
            };
            gradient.unwrap_or(f64::NAN) * units.gradient()
        })
    }
}

/// Returns the shape of the fields of a process on a grid.
fn shape(share: &Share, grid: &Grid) -> [usize; 2] {
    let [nx, ny] = grid.points();
    [if share.is_whole() { nx } else { share.faces() * share.rows().len() }, ny]
}

fn slice_of(heights: &ArcArray2<f64>) -> &[f64] {
    heights.as_slice().expect("the heights of a rigid surface are in standard order")
}

/// Returns heights with this clearance below zero.
fn below_zero(shape: [usize; 2], clearance: impl Iterator<Item = f64>) -> ArcArray2<f64> {
    let heights = clearance.map(|clearance| -clearance).collect();
    Array2::from_shape_vec(shape, heights).expect("each point has a clearance").into_shared()
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
        (heights[[1, 2]], heights[[2, 1]]) = (1e308, -1e308);
        assert!(matches!(RigidSurface::new(&grid, &heights), Err(Refusal::RmsHeight { .. })));
    }

    #[test]
    fn sizes_scale_with_the_heights_over_the_whole_range_of_numbers() {
        let grid = Grid::square(8, 1.0).unwrap();
        let heights = Array2::from_shape_fn((8, 8), |(i, j)| 0.01 * ((3 * i + 5 * j) % 8) as f64);
        let surface = RigidSurface::new(&grid, &heights).unwrap();
        for exponent in (-300..=300).step_by(20) {
            let factor = 10.0_f64.powi(exponent);
            let large = RigidSurface::new(&grid, &(factor * &heights)).unwrap();
            approx::assert_relative_eq!(large.rms_height() / factor, surface.rms_height(), max_relative = 1e-13);
            approx::assert_relative_eq!(large.rms_gradient() / factor, surface.rms_gradient(), max_relative = 1e-13);
            // Longer cells make flatter surfaces.
            let wide = Grid::square(8, factor).unwrap();
            let wide = RigidSurface::new(&wide, &(factor * &heights)).unwrap();
            approx::assert_relative_eq!(wide.rms_gradient(), surface.rms_gradient(), max_relative = 1e-13);
        }
    }
}
