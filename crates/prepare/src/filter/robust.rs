//! Robust Gaussian regression.

use ndarray::{Array2, Zip};

use super::Smoothed;
use super::kernels::{along_x, along_y, kernel, width};
use super::regression::regressed;
use crate::rows::median;

/// Largest number of passes.
const MOST_PASSES: usize = 20;

/// Relative change of the cut-off at which the passes end.
const SETTLED: f64 = 0.01;

/// Cut-off of the residuals in medians of their magnitude: three normal standard deviations, 3 · 1.4826 (ISO 16610-31).
const CUT_OFF: f64 = 4.4478;

/// First pass after which neighbourhoods that would lose most of their weight keep it.
const FIRST_GUARDED: usize = 3;

/// Smallest part of the weight that a neighbourhood may keep.
const LEAST_KEPT: f64 = 0.5;

/// Smooths by regressions with Tukey's weights (1 − (r/c)²)² of the residuals of the last pass, until the cut-off c
/// changes by less than 1 %, at most 20 times.
///
/// Iterated without a guard, the filter runs away where the surface curves at an edge: points there are rejected, the
/// fit extrapolates, and more are rejected. From the fourth pass on, a point where the weights of the neighbourhood sum
/// to less than half has weight 1 again. This guard is not part of the standard.
pub(super) fn smooth(heights: &Array2<f64>, spacing: [f64; 2], index: f64, degree: usize) -> Smoothed {
    passes(heights, spacing, index, degree, &Rule { most: MOST_PASSES, settled: SETTLED, is_guarded: true })
}

/// Rule for the passes.
pub(super) struct Rule {
    pub(super) most: usize,
    /// Relative change of the cut-off that ends them.
    pub(super) settled: f64,
    pub(super) is_guarded: bool,
}

pub(super) fn passes(heights: &Array2<f64>, spacing: [f64; 2], index: f64, degree: usize, rule: &Rule) -> Smoothed {
    let (nx, ny) = heights.dim();
    let line = |axis: usize| match (axis, ny) {
        (1, 1) => vec![1.0],
        _ => kernel([nx, ny][axis], spacing[axis], index, width(0), 0),
    };
    let (x, y) = (line(0), line(1));
    let neighbourhood = |field: &Array2<f64>| along_y(&along_x(field, &x), &y);
    let mut weights = Array2::ones((nx, ny));
    let whole = neighbourhood(&weights);
    let mut smoothed = Smoothed { is_settled: false, ..Smoothed::of(Array2::zeros((0, 0))) };
    let mut last = f64::INFINITY;
    for pass in 1..=rule.most {
        smoothed.heights = regressed(heights, Some(&weights), spacing, index, degree);
        smoothed.passes = pass;
        let residuals = heights - &smoothed.heights;
        let mut sizes: Vec<f64> =
            residuals.iter().filter(|residual| !residual.is_nan()).map(|residual| residual.abs()).collect();
        let cut_off = CUT_OFF * median(&mut sizes);
        // Half of the points lie on the smooth surface, or no point is left.
        if cut_off.is_nan() || cut_off == 0.0 {
            smoothed.is_settled = true;
            break;
        }
        Zip::from(&mut weights).and(&residuals).for_each(|weight, residual| {
            let part = residual / cut_off;
            *weight = if part.abs() < 1.0 { (1.0 - part * part).powi(2) } else { 0.0 };
        });
        smoothed.guarded = 0;
        if rule.is_guarded && pass > FIRST_GUARDED {
            let kept = neighbourhood(&weights);
            Zip::from(&mut weights).and(&kept).and(&whole).and(heights).for_each(|weight, kept, whole, height| {
                if kept / whole < LEAST_KEPT && !height.is_nan() {
                    smoothed.guarded += usize::from(*weight == 0.0);
                    *weight = 1.0;
                }
            });
        }
        smoothed.rejected = weights.iter().zip(heights).filter(|(w, h)| **w == 0.0 && !h.is_nan()).count();
        if (cut_off - last).abs() <= rule.settled * cut_off {
            smoothed.is_settled = true;
            break;
        }
        last = cut_off;
    }
    smoothed
}
