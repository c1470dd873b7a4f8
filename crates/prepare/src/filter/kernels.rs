//! Sampled Gaussian kernels, and their sums along the lines of a field.

use std::f64::consts::{LN_2, PI};

use gfmd_plan::Plans;
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

/// Width of the kernel e^{−π(x/cL)²} whose transmission is 1/2 at λ = L, degrees 0 and 1: √(ln 2/π).
pub(super) fn width(degree: usize) -> f64 {
    if degree < 2 { (LN_2 / PI).sqrt() } else { WIDTH_OF_DEGREE_2 }
}

/// Width for degree 2: π times its square is the root t of (1 + t) e^{−t} = 1/2.
const WIDTH_OF_DEGREE_2: f64 = 0.730_913_428_094_675_9;

/// Distance in widths at which the kernel falls below 10⁻¹⁸.
const REACH: f64 = 3.65;

/// Largest half-width of a kernel that is summed directly.
const DIRECT: usize = 64;

/// Returns the kernel times (x/L)^power at the offsets from -h to h, at most `points - 1`.
pub(super) fn kernel(points: usize, spacing: f64, index: f64, width: f64, power: usize) -> Vec<f64> {
    let half = ((REACH * width * index / spacing).ceil() as usize).min(points - 1) as isize;
    let at = |offset: isize| {
        let x = offset as f64 * spacing / index;
        x.powi(power as i32) * (-PI * (x / width).powi(2)).exp()
    };
    (-half..=half).map(at).collect()
}

/// Returns the sums over offsets d of `kernel[d] * field[i, j + d]`, with zeros outside.
pub(super) fn along_y(field: &Array2<f64>, kernel: &[f64]) -> Array2<f64> {
    let (nx, ny) = field.dim();
    let half = kernel.len() / 2;
    let mut sums = Array2::zeros((nx, ny));
    let lines = sums.as_slice_mut().expect("a new array is contiguous").par_chunks_exact_mut(ny);
    let fields = field.as_slice().expect("fields of a filter are contiguous").par_chunks_exact(ny);
    if half <= DIRECT {
        lines.zip(fields).for_each(|(sums, field)| {
            for (j, sum) in sums.iter_mut().enumerate() {
                let (first, end) = (j.saturating_sub(half), (j + half + 1).min(ny));
                let part = &kernel[first + half - j..end + half - j];
                *sum = field[first..end].iter().zip(part).map(|(value, weight)| value * weight).sum();
            }
        });
        return sums;
    }
    let padded = quick_length(ny + half);
    let (forward, backward) = f64::real(padded);
    let mut wrapped = vec![0.0; padded];
    for (place, weight) in kernel.iter().enumerate() {
        wrapped[(place + padded - half) % padded] += weight / padded as f64;
    }
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut wrapped, &mut spectrum).expect("lengths are those of the plan");
    lines.zip(fields).for_each_init(
        || (vec![0.0; padded], forward.make_output_vec(), forward.make_scratch_vec(), backward.make_scratch_vec()),
        |(line, waves, there, back), (sums, field)| {
            line[..ny].copy_from_slice(field);
            line[ny..].fill(0.0);
            forward.process_with_scratch(line, waves, there).expect("lengths are those of the plan");
            waves.iter_mut().zip(&spectrum).for_each(|(wave, weight)| *wave *= weight.conj());
            keep_real(waves, padded);
            backward.process_with_scratch(waves, line, back).expect("lengths are those of the plan");
            sums.copy_from_slice(&line[..ny]);
        },
    );
    sums
}

/// Returns the sums like [`along_y`], over offsets along x.
pub(super) fn along_x(field: &Array2<f64>, kernel: &[f64]) -> Array2<f64> {
    turned(&along_y(&turned(field), kernel))
}

/// Returns the transposed field, contiguous.
pub(super) fn turned(field: &Array2<f64>) -> Array2<f64> {
    field.t().as_standard_layout().into_owned()
}

/// Sets the imaginary parts to zero that a real row cannot have.
pub(super) fn keep_real(waves: &mut [Complex64], points: usize) {
    waves[0].im = 0.0;
    if points.is_multiple_of(2) {
        waves[points / 2].im = 0.0;
    }
}

/// Returns the smallest product of 2, 3 and 5 that is at least `points`.
fn quick_length(points: usize) -> usize {
    let is_quick = |n: usize| {
        let mut rest = n;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (points..).find(|n| is_quick(*n)).unwrap_or(points)
}
