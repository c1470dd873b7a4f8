//! Points and lines of a scan that are not part of the surface.

use ndarray::Array2;
use rayon::prelude::*;

use crate::PrepareError;
use crate::error::value;
use crate::rows::median;

/// Rule for points that stand out of their neighbourhood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spikes {
    /// Smallest distance from the local median that makes a spike, in robust standard deviations (1.4826 times the
    /// median distance) of all points.
    pub threshold: f64,
    /// Number of points along each side of the window of the local median, odd.
    pub window: usize,
}

impl Default for Spikes {
    fn default() -> Self {
        Self { threshold: 5.0, window: 5 }
    }
}

/// Standard deviation of normal numbers divided by the median of their magnitudes.
const TO_DEVIATION: f64 = 1.4826;

/// Largest share of the points that may be spikes.
const MOST_SPIKES: f64 = 0.1;

/// Returns the heights with undefined points in place of spikes, and the number of spikes.
///
/// A spike is a point whose residual q from the median of the defined points in a window around it satisfies
/// |q − median q| > K · 1.4826 · median|q − median q|. The window is cut at the edges. Where half of all residuals are
/// equal there are no spikes.
///
/// # Errors
/// A threshold that is not positive, an even window, spikes at more than a tenth of the defined points.
pub fn despike(heights: &Array2<f64>, spikes: Spikes) -> Result<(Array2<f64>, usize), PrepareError> {
    let Spikes { threshold, window } = spikes;
    if !(threshold > 0.0 && threshold.is_finite()) {
        return Err(value("threshold of spikes", threshold, "positive and finite"));
    }
    if window.is_multiple_of(2) || !(3..=99).contains(&window) {
        return Err(value("window of spikes", window, "an odd number of points from 3 to 99"));
    }
    let ((nx, ny), half) = (heights.dim(), window / 2);
    let residual_row = |i: usize| -> Vec<f64> {
        let mut around = Vec::with_capacity(window * window);
        let columns = |j: usize| (j.saturating_sub(half), (j + half + 1).min(ny));
        let residual = |j: usize| {
            if heights[[i, j]].is_nan() {
                return f64::NAN;
            }
            around.clear();
            let (first, end) = columns(j);
            for k in i.saturating_sub(half)..(i + half + 1).min(nx) {
                around.extend((first..end).map(|l| heights[[k, l]]).filter(|height| !height.is_nan()));
            }
            heights[[i, j]] - median(&mut around)
        };
        (0..ny).map(residual).collect()
    };
    let residuals: Vec<f64> = (0..nx).into_par_iter().map(residual_row).collect::<Vec<_>>().concat();
    let mut defined: Vec<f64> = residuals.iter().copied().filter(|residual| !residual.is_nan()).collect();
    let points = defined.len();
    let middle = median(&mut defined);
    defined.iter_mut().for_each(|residual| *residual = (*residual - middle).abs());
    let least = threshold * TO_DEVIATION * median(&mut defined);
    let mut cleaned = heights.clone();
    let mut found = 0;
    for (height, residual) in cleaned.iter_mut().zip(&residuals) {
        if least > 0.0 && (residual - middle).abs() > least {
            *height = f64::NAN;
            found += 1;
        }
    }
    if found as f64 > MOST_SPIKES * points as f64 {
        return Err(PrepareError::TooManySpikes { found, points });
    }
    Ok((cleaned, found))
}

/// Rule for line defects along x, which a probe that loses the surface for a part of a row leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scars {
    /// Step at both sides of a scar that makes its core, in rms differences along y.
    pub high: f64,
    /// Step at both sides that extends a core along x, in rms differences along y.
    pub low: f64,
    /// Least number of points along x.
    pub length: usize,
    /// Largest number of rows.
    pub width: usize,
}

impl Default for Scars {
    fn default() -> Self {
        Self { high: 0.666, low: 0.25, length: 16, width: 4 }
    }
}

/// Returns the heights with undefined points in place of scars, and the number of these points.
///
/// A scar is a run of at least `length` points along x, up to `width` rows wide, that all lie above the rows at both
/// sides by `low` rms differences along y, and somewhere by `high`; likewise below them. Undefined points end it.
///
/// # Errors
/// A profile; steps that are not positive or in the wrong order; a length or width of zero.
pub fn descar(heights: &Array2<f64>, scars: Scars) -> Result<(Array2<f64>, usize), PrepareError> {
    let Scars { high, low, length, width } = scars;
    if !(low > 0.0 && high >= low && high.is_finite()) {
        return Err(value("steps of scars", format!("{high}, {low}"), "HIGH,LOW with HIGH >= LOW > 0"));
    }
    if length == 0 || !(1..=99).contains(&width) {
        return Err(value("length and width of scars", format!("{length}, {width}"), "at least 1, the width up to 99"));
    }
    let (nx, ny) = heights.dim();
    if ny < 3 {
        return Err(PrepareError::TooFewPoints { what: "scars", needed: "3 rows".into(), found: ny });
    }
    let steps = heights.rows().into_iter().flat_map(|line| {
        let line = line.to_vec();
        line.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| !step.is_nan()).collect::<Vec<_>>()
    });
    let (count, squares) = steps.fold((0_usize, 0.0), |(count, sum), step| (count + 1, sum + step * step));
    let rms = (squares / count.max(1) as f64).sqrt();
    let mut cleaned = heights.clone();
    let mut found = 0;
    if rms == 0.0 {
        return Ok((cleaned, 0));
    }
    for sign in [1.0, -1.0] {
        // Largest step at which a scar of some width covers the point.
        let mut strength = Array2::<f64>::zeros((nx, ny));
        for ((i, j), _) in heights.indexed_iter().filter(|((_, j), _)| *j > 0) {
            let mut lowest = f64::INFINITY;
            for end in j + 1..(j + width + 1).min(ny) {
                lowest = lowest.min(sign * heights[[i, end - 1]]);
                let sides = (sign * heights[[i, j - 1]], sign * heights[[i, end]]);
                let step = if sides.0.is_nan() || sides.1.is_nan() { f64::NAN } else { lowest - sides.0.max(sides.1) };
                if (j..end).any(|k| heights[[i, k]].is_nan()) {
                    break;
                }
                if step >= low * rms {
                    (j..end).for_each(|k| strength[[i, k]] = strength[[i, k]].max(step / rms));
                }
            }
        }
        for j in 0..ny {
            let mut first = 0;
            while first < nx {
                let end = (first..nx).find(|i| strength[[*i, j]] < low).unwrap_or(nx);
                let has_core = (first..end).any(|i| strength[[i, j]] >= high);
                if end - first >= length && has_core {
                    for i in first..end {
                        found += usize::from(!cleaned[[i, j]].is_nan());
                        cleaned[[i, j]] = f64::NAN;
                    }
                }
                first = end + 1;
            }
        }
    }
    Ok((cleaned, found))
}
