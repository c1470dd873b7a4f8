//! Filters of surfaces that repeat: transmissions of waves.

use std::f64::consts::PI;

use gfmd_plan::Plans;
use ndarray::Array2;
use rayon::prelude::*;

use super::kernels::{keep_real, turned};

/// Multiplies the waves of each line along y, of one period or mirrored to two, by the `transmission` of their number
/// of periods per point.
fn filtered_along_y(heights: &Array2<f64>, is_mirrored: bool, transmission: impl Fn(f64) -> f64) -> Array2<f64> {
    let (nx, ny) = heights.dim();
    if ny == 1 {
        return heights.clone();
    }
    let period = if is_mirrored { 2 * ny } else { ny };
    let (forward, backward) = f64::real(period);
    let factors: Vec<f64> = (0..=period / 2).map(|k| transmission(k as f64 / period as f64) / period as f64).collect();
    let mut filtered = Array2::zeros((nx, ny));
    let lines = filtered.as_slice_mut().expect("a new array is contiguous").par_chunks_exact_mut(ny);
    let fields = heights.as_slice().expect("fields of a filter are contiguous").par_chunks_exact(ny);
    lines.zip(fields).for_each_init(
        || (vec![0.0; period], forward.make_output_vec(), forward.make_scratch_vec(), backward.make_scratch_vec()),
        |(line, waves, there, back), (filtered, heights)| {
            line[..ny].copy_from_slice(heights);
            line[ny..].iter_mut().zip(heights.iter().rev()).for_each(|(image, height)| *image = *height);
            forward.process_with_scratch(line, waves, there).expect("lengths are those of the plan");
            waves.iter_mut().zip(&factors).for_each(|(wave, factor)| *wave *= factor);
            keep_real(waves, period);
            backward.process_with_scratch(waves, line, back).expect("lengths are those of the plan");
            filtered.copy_from_slice(&line[..ny]);
        },
    );
    filtered
}

/// Gaussian filter along both axes: its transmission is the product of both.
fn gaussian(heights: &Array2<f64>, spacing: [f64; 2], index: f64, is_mirrored: bool) -> Array2<f64> {
    let along = |spacing: f64| move |periods: f64| (-(index * periods / spacing).powi(2)).exp2();
    let heights = heights.as_standard_layout().into_owned();
    let there = filtered_along_y(&heights, is_mirrored, along(spacing[1]));
    turned(&filtered_along_y(&turned(&there), is_mirrored, along(spacing[0])))
}

/// Returns the Gaussian filter of a surface that repeats.
pub(super) fn periodic(heights: &Array2<f64>, spacing: [f64; 2], index: f64) -> Array2<f64> {
    gaussian(heights, spacing, index, false)
}

/// Returns the Gaussian filter of a surface between mirror images.
pub(super) fn reflected(heights: &Array2<f64>, spacing: [f64; 2], index: f64) -> Array2<f64> {
    gaussian(heights, spacing, index, true)
}

/// Returns the spline of a profile that repeats.
pub(super) fn closed_spline(heights: &Array2<f64>, spacing: f64, index: f64, tension: f64) -> Array2<f64> {
    let stiffness = 0.25 / (PI * spacing / index).sin().powi(2);
    let transmission = |periods: f64| {
        let square = stiffness * 4.0 * (PI * periods).sin().powi(2);
        1.0 / (1.0 + tension * square * square + (1.0 - tension) * square)
    };
    turned(&filtered_along_y(&turned(heights), false, transmission))
}
