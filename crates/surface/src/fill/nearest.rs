//! Nearest defined point of every point by exact squared distances: a pass along y, then the lower envelope of
//! parabolas along x (Felzenszwalb and Huttenlocher 2012).

use ndarray::{Array2, ArrayRef2};
use rayon::prelude::*;

/// Fills NaN with the height of the nearest defined point. At least one point must be defined.
pub(super) fn fill(heights: &ArrayRef2<f64>, spacing: [f64; 2]) -> Array2<f64> {
    let (nx, ny) = heights.dim();
    // In units of the spacing along x, so that distances on a square grid are whole numbers and ties are exact.
    let ratio = spacing[1] / spacing[0];
    let along_y: Vec<Vec<Option<usize>>> =
        (0..nx).into_par_iter().map(|i| nearest_along(ny, |j| !heights[[i, j]].is_nan())).collect();
    let columns: Vec<Vec<f64>> = (0..ny)
        .into_par_iter()
        .map(|j| {
            let square = |i: usize| along_y[i][j].map(|at| ((at as f64 - j as f64) * ratio).powi(2));
            let nearest = lower_envelope(nx, square);
            (0..nx).map(|i| along_y[nearest[i]][j].map_or(f64::NAN, |at| heights[[nearest[i], at]])).collect()
        })
        .collect();
    Array2::from_shape_fn((nx, ny), |(i, j)| if heights[[i, j]].is_nan() { columns[j][i] } else { heights[[i, j]] })
}

/// Returns the nearest index at which `defined` holds, the lower of two.
fn nearest_along(count: usize, defined: impl Fn(usize) -> bool) -> Vec<Option<usize>> {
    let mut nearest = vec![None; count];
    let mut last = None;
    for (j, found) in nearest.iter_mut().enumerate() {
        last = if defined(j) { Some(j) } else { last };
        *found = last;
    }
    let mut next = None;
    for (j, found) in nearest.iter_mut().enumerate().rev() {
        next = if *found == Some(j) { Some(j) } else { next };
        let ahead = next.map(|next: usize| next - j);
        if ahead.is_some_and(|ahead| found.is_none_or(|last| ahead < j - last)) {
            *found = next;
        }
    }
    nearest
}

/// Returns for every i the index q with the smallest (i − q)² + f(q), the lowest of several. At least one f(q) exists.
fn lower_envelope(count: usize, f: impl Fn(usize) -> Option<f64>) -> Vec<usize> {
    // Parabolas of the envelope, each with the position from where it is the lowest.
    let mut parabolas: Vec<(usize, f64, f64)> = Vec::with_capacity(count);
    for (q, height) in (0..count).filter_map(|q| Some((q, f(q)?))) {
        let mut start = f64::NEG_INFINITY;
        while let Some(&(p, below, from)) = parabolas.last() {
            let [p_, q_] = [p as f64, q as f64];
            start = ((height + q_ * q_) - (below + p_ * p_)) / (2.0 * (q_ - p_));
            if start > from {
                break;
            }
            parabolas.pop();
            start = f64::NEG_INFINITY;
        }
        parabolas.push((q, height, start));
    }
    let mut current = 0;
    let nearest = |i: usize| {
        while parabolas.get(current + 1).is_some_and(|&(_, _, start)| start < i as f64) {
            current += 1;
        }
        parabolas[current].0
    };
    (0..count).map(nearest).collect()
}
