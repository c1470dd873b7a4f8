//! Form: polynomials of least squares.

use ndarray::Array2;
use rayon::prelude::*;

use crate::PrepareError;
use crate::error::value;

/// Largest degree of a polynomial.
pub const MOST_DEGREE: usize = 8;

/// Returns the heights less the polynomial of the terms x^a y^b, a + b <= `degree`, with the least squared distance
/// from the defined points that are not `excluded`. Undefined points stay undefined; excluded ones lose the polynomial,
/// too.
///
/// The fit uses products of Legendre polynomials of indices, so that lengths do not matter.
///
/// # Errors
/// A degree above [`MOST_DEGREE`]; points that do not determine all terms.
pub fn remove_polynomial(
    heights: &Array2<f64>,
    degree: usize,
    excluded: Option<&Array2<bool>>,
) -> Result<Array2<f64>, PrepareError> {
    if degree > MOST_DEGREE {
        return Err(value("degree of the polynomial", degree, format!("0 to {MOST_DEGREE}")));
    }
    let (nx, ny) = heights.dim();
    let (x, y) = (Legendre::new(nx, degree), Legendre::new(ny, degree));
    let along_y = if ny == 1 { 0 } else { degree };
    let terms: Vec<[usize; 2]> =
        (0..=degree).flat_map(|a| (0..=along_y.min(degree - a)).map(move |b| [a, b])).collect();
    let used = |i: usize, j: usize| !heights[[i, j]].is_nan() && !excluded.is_some_and(|excluded| excluded[[i, j]]);
    let at = |[a, b]: &[usize; 2], [i, j]: [usize; 2]| x.at(*a, i) * y.at(*b, j);
    let mut rest = heights.clone();
    // Two passes: the second fit removes the rounding error of the first.
    for _ in 0..2 {
        let line = |i: usize| {
            let points = (0..ny).filter(|j| used(i, *j)).map(|j| (rest[[i, j]], [i, j]));
            equations(&terms, points, at)
        };
        let lines: Vec<Vec<f64>> = (0..nx).into_par_iter().map(line).collect();
        let mut sum = vec![0.0; terms.len() * (terms.len() + 1)];
        for line in lines {
            sum.iter_mut().zip(line).for_each(|(sum, part)| *sum += part);
        }
        let found = solve(sum, terms.len()).ok_or(PrepareError::Undetermined { degree })?;
        for ((i, j), height) in rest.indexed_iter_mut() {
            *height -= terms.iter().zip(&found).map(|(term, c)| c * at(term, [i, j])).sum::<f64>();
        }
    }
    Ok(rest)
}

/// Values of the Legendre polynomials up to a degree at the points of a side, from -1 to 1.
pub(crate) struct Legendre {
    points: usize,
    values: Vec<f64>,
}

impl Legendre {
    pub(crate) fn new(points: usize, degree: usize) -> Self {
        let place = |i: usize| if points > 1 { 2.0 * i as f64 / (points as f64 - 1.0) - 1.0 } else { 0.0 };
        let mut values = vec![1.0; points];
        for n in 1..=degree {
            for i in 0..points {
                let (n, u) = (n as f64, place(i));
                let before = |back: usize| values[values.len() - back * points];
                let last = before(1);
                let earlier = if n > 1.0 { before(2) } else { 0.0 };
                values.push(((2.0 * n - 1.0) * u * last - (n - 1.0) * earlier) / n);
            }
        }
        Self { points, values }
    }

    pub(crate) fn at(&self, degree: usize, point: usize) -> f64 {
        self.values[degree * self.points + point]
    }
}

/// Returns the coefficients of the terms with the least squared distance from values at places; `None` if the places do
/// not determine them.
pub(crate) fn fit<T, P: Copy>(
    terms: &[T],
    points: impl Iterator<Item = (f64, P)>,
    at: impl Fn(&T, P) -> f64,
) -> Option<Vec<f64>> {
    solve(equations(terms, points, at), terms.len())
}

/// Returns the normal equations row by row, each with its right-hand side.
fn equations<T, P: Copy>(terms: &[T], points: impl Iterator<Item = (f64, P)>, at: impl Fn(&T, P) -> f64) -> Vec<f64> {
    let count = terms.len();
    let (mut sums, mut here) = (vec![0.0; count * (count + 1)], vec![0.0; count]);
    for (value, place) in points {
        here.iter_mut().zip(terms).for_each(|(here, term)| *here = at(term, place));
        for (row, a) in sums.chunks_exact_mut(count + 1).zip(&here) {
            row[..count].iter_mut().zip(&here).for_each(|(sum, b)| *sum += a * b);
            row[count] += a * value;
        }
    }
    sums
}

/// Smallest pivot of a regular system, relative to its diagonal entry before the elimination.
const SINGULAR: f64 = 1e-10;

/// Solves symmetric positive definite equations, each row with its right-hand side; `None` if singular.
pub(crate) fn solve(mut rows: Vec<f64>, count: usize) -> Option<Vec<f64>> {
    let width = count + 1;
    for k in 0..count {
        let (before, rest) = rows.split_at_mut((k + 1) * width);
        let pivot = &before[k * width..];
        for row in rest.chunks_exact_mut(width) {
            let factor = row[k] / pivot[k];
            let diagonal = row.iter().zip(pivot).skip(k).map(|(value, pivot)| value - factor * pivot);
            let changed: Vec<f64> = diagonal.collect();
            row[k..].copy_from_slice(&changed);
        }
        let scale = rows[k * width + k];
        if scale.is_nan() || scale <= 0.0 {
            return None;
        }
    }
    let largest = (0..count).map(|k| rows[k * width + k]).fold(0.0, f64::max);
    if (0..count).any(|k| rows[k * width + k] <= SINGULAR * largest) {
        return None;
    }
    let mut solution = vec![0.0; count];
    for k in (0..count).rev() {
        let known: f64 = (k + 1..count).map(|l| rows[k * width + l] * solution[l]).sum();
        solution[k] = (rows[k * width + count] - known) / rows[k * width + k];
    }
    Some(solution)
}
