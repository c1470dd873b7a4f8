//! Local polynomials weighted by a Gaussian.

use ndarray::Array2;
use rayon::prelude::*;

use super::kernels::{along_x, along_y, kernel, width};

/// Smallest part of the whole weight on defined points at which a value is defined.
const LEAST_WEIGHT: f64 = 1e-6;

/// Most terms of a polynomial of degree 2 in x and y.
const TERMS: usize = 6;

/// Returns the value at each point of the polynomial of the `degree` with the least squared distance from the defined
/// points, weighted by the kernel and by `weights`, 1 without them.
pub(super) fn regressed(
    heights: &Array2<f64>,
    weights: Option<&Array2<f64>>,
    spacing: [f64; 2],
    index: f64,
    degree: usize,
) -> Array2<f64> {
    let (nx, ny) = heights.dim();
    let is_line = ny == 1;
    let terms: Vec<[usize; 2]> =
        (0..=degree).flat_map(|a| (0..=if is_line { 0 } else { degree - a }).map(move |b| [a, b])).collect();
    let kernels = |axis: usize| -> Vec<Vec<f64>> {
        let points = [nx, ny][axis];
        match is_line && axis == 1 {
            true => vec![vec![1.0]],
            false => (0..=2 * degree).map(|power| kernel(points, spacing[axis], index, width(degree), power)).collect(),
        }
    };
    let (x, y) = (kernels(0), kernels(1));
    let is_whole = weights.is_none() && !heights.iter().any(|height| height.is_nan());
    let weight = |(i, j): (usize, usize)| match (heights[[i, j]].is_nan(), weights) {
        (true, _) => 0.0,
        (false, Some(weights)) => weights[[i, j]],
        (false, None) => 1.0,
    };
    let moment = |field: &Array2<f64>, [a, b]: [usize; 2]| along_y(&along_x(field, &x[a]), &y[b]);
    let loads: Vec<Array2<f64>> = {
        let weighted = Array2::from_shape_fn((nx, ny), |at| match weight(at) {
            0.0 => 0.0,
            weight => weight * heights[at],
        });
        terms.iter().map(|term| moment(&weighted, *term)).collect()
    };
    let moments = if is_whole {
        // Moments of equal weights are products.
        let ones = |points: usize, kernels: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let line = Array2::ones((1, points));
            kernels.iter().map(|kernel| along_y(&line, kernel).into_raw_vec_and_offset().0).collect()
        };
        Moments::Products(ones(nx, &x), ones(ny, &y))
    } else {
        let weights = Array2::from_shape_fn((nx, ny), weight);
        let most = if is_line { 0 } else { 2 * degree };
        let field =
            |a: usize, b: usize| if a + b <= 2 * degree { moment(&weights, [a, b]) } else { Array2::zeros((0, 0)) };
        Moments::Fields((0..=2 * degree).map(|a| (0..=most).map(|b| field(a, b)).collect()).collect())
    };
    let whole: f64 = [&x[0], &y[0]].into_iter().map(|kernel| kernel.iter().sum::<f64>()).product();
    let mut values = Array2::zeros((nx, ny));
    let lines = values.as_slice_mut().expect("a new array is contiguous").par_chunks_exact_mut(ny).enumerate();
    lines.for_each(|(i, line)| {
        for (j, value) in line.iter_mut().enumerate() {
            let mut rows = [[0.0; TERMS + 1]; TERMS];
            for (row, [a, b]) in terms.iter().enumerate() {
                for (column, [c, d]) in terms.iter().enumerate() {
                    rows[row][column] = moments.at([a + c, b + d], [i, j]);
                }
                rows[row][TERMS] = loads[row][[i, j]];
            }
            *value = if rows[0][0] < LEAST_WEIGHT * whole { f64::NAN } else { first_of(&mut rows, terms.len()) };
        }
    });
    values
}

/// Moments of the weights about each point.
enum Moments {
    /// Products of moments along x and y, by power and index.
    Products(Vec<Vec<f64>>, Vec<Vec<f64>>),
    /// Fields by powers of x and y.
    Fields(Vec<Vec<Array2<f64>>>),
}

impl Moments {
    fn at(&self, [a, b]: [usize; 2], [i, j]: [usize; 2]) -> f64 {
        match self {
            Self::Products(x, y) => x[a][i] * y[b][j],
            Self::Fields(fields) => fields[a][b][[i, j]],
        }
    }
}

/// Solves symmetric positive definite equations and returns the first unknown, the value of the polynomial at its
/// origin. Without enough points the remaining terms are left out.
fn first_of(rows: &mut [[f64; TERMS + 1]; TERMS], count: usize) -> f64 {
    // Eliminates from the last unknown on, so that the first one remains.
    for k in (1..count).rev() {
        let pivot = rows[k];
        if pivot[k] <= f64::EPSILON * f64::EPSILON * rows[0][0] {
            continue;
        }
        for row in &mut rows[..k] {
            let factor = row[k] / pivot[k];
            for column in (0..k).chain([TERMS]) {
                row[column] -= factor * pivot[column];
            }
        }
    }
    rows[0][TERMS] / rows[0][0]
}
