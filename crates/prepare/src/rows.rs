//! Offsets and drift of the rows of a scan.

use ndarray::Array2;

use crate::PrepareError;
use crate::error::value;
use crate::form::{Legendre, MOST_DEGREE, fit};

/// Way to level the rows of a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Levelling {
    /// Same mean height of all rows. It removes every wave along y alone.
    Mean,
    /// Same median height of all rows. It ignores features that fill less than half of a row.
    Median,
    /// Median difference of neighbouring rows zero, up to a common slope along y. It keeps features that fill most of a
    /// row; long waves along y are uncertain after it.
    Difference,
    /// Polynomial of this degree in x removed from each row.
    Polynomial(usize),
}

/// Levelled heights.
#[derive(Clone, Debug, PartialEq)]
pub struct Levelled {
    /// Heights.
    pub heights: Array2<f64>,
    /// Height subtracted from each row, length; empty for polynomials.
    pub shifts: Vec<f64>,
}

/// Levels the rows, lines along x, by their defined points; `excluded` points are left out of means, medians and fits,
/// and are levelled with their rows.
///
/// The shift of row j is its mean or median less the mean of all shifts, so that the mean height stays; a row without
/// points keeps its heights. For differences the shift is the running sum of the median differences of neighbouring
/// rows less its least-squares line.
///
/// # Errors
/// A single row; a degree above [`MOST_DEGREE`]; no points.
pub fn level_rows(
    heights: &Array2<f64>,
    how: Levelling,
    excluded: Option<&Array2<bool>>,
) -> Result<Levelled, PrepareError> {
    let (nx, ny) = heights.dim();
    if ny < 2 {
        return Err(PrepareError::TooFewPoints { what: "levelling rows", needed: "2 rows".into(), found: ny });
    }
    let used = |i: usize, j: usize| !heights[[i, j]].is_nan() && !excluded.is_some_and(|excluded| excluded[[i, j]]);
    let used_of = |j: usize| (0..nx).filter(move |i| used(*i, j)).map(move |i| heights[[i, j]]);
    let per_row: Vec<Option<f64>> = match how {
        Levelling::Mean => (0..ny)
            .map(|j| {
                let count = used_of(j).count();
                (count > 0).then(|| used_of(j).sum::<f64>() / count as f64)
            })
            .collect(),
        Levelling::Median => {
            (0..ny).map(|j| Some(median(&mut used_of(j).collect::<Vec<_>>())).filter(|m| !m.is_nan())).collect()
        }
        Levelling::Difference => {
            let step = |j: usize| {
                let pairs = (0..nx).filter(|i| used(*i, j) && used(*i, j - 1));
                let middle = median(&mut pairs.map(|i| heights[[i, j]] - heights[[i, j - 1]]).collect::<Vec<_>>());
                if middle.is_nan() { 0.0 } else { middle }
            };
            let mut sum = 0.0;
            let mut sums: Vec<f64> = (0..ny)
                .map(|j| {
                    sum += if j == 0 { 0.0 } else { step(j) };
                    sum
                })
                .collect();
            remove_line(&mut sums);
            return Ok(shifted(heights, sums));
        }
        Levelling::Polynomial(degree) => {
            if degree > MOST_DEGREE {
                return Err(value("degree of the polynomial of a row", degree, format!("0 to {MOST_DEGREE}")));
            }
            let basis = Legendre::new(nx, degree);
            let mut levelled = heights.clone();
            for j in 0..ny {
                let points: Vec<usize> = (0..nx).filter(|i| used(*i, j)).collect();
                let Some(most) = points.len().checked_sub(1) else { continue };
                let terms: Vec<usize> = (0..=degree.min(most)).collect();
                // Two passes: the second fit removes the rounding error of the first.
                for _ in 0..2 {
                    let found = fit(&terms, points.iter().map(|&i| (levelled[[i, j]], [i, 0])), |term, [i, _]| {
                        basis.at(*term, i)
                    });
                    let found = found.ok_or(PrepareError::Undetermined { degree })?;
                    for i in 0..nx {
                        levelled[[i, j]] -=
                            terms.iter().zip(&found).map(|(term, c)| c * basis.at(*term, i)).sum::<f64>();
                    }
                }
            }
            return Ok(Levelled { heights: levelled, shifts: Vec::new() });
        }
    };
    let known: Vec<f64> = per_row.iter().flatten().copied().collect();
    if known.is_empty() {
        return Err(PrepareError::TooFewPoints { what: "levelling rows", needed: "a defined point".into(), found: 0 });
    }
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    Ok(shifted(heights, per_row.into_iter().map(|row| row.map_or(0.0, |row| row - mean)).collect()))
}

/// Levels the columns, lines along y, like [`level_rows`].
///
/// # Errors
/// The errors of `level_rows`, for columns.
pub fn level_columns(
    heights: &Array2<f64>,
    how: Levelling,
    excluded: Option<&Array2<bool>>,
) -> Result<Levelled, PrepareError> {
    if heights.ncols() < 2 {
        let found = "a profile has no columns";
        return Err(PrepareError::Combination { found, allowed: "heights of two or more rows" });
    }
    let turned = heights.t().to_owned();
    let excluded = excluded.map(|excluded| excluded.t().to_owned());
    let Levelled { heights, shifts } = level_rows(&turned, how, excluded.as_ref())?;
    Ok(Levelled { heights: heights.t().as_standard_layout().into_owned(), shifts })
}

fn shifted(heights: &Array2<f64>, shifts: Vec<f64>) -> Levelled {
    let mut levelled = heights.clone();
    for mut line in levelled.rows_mut() {
        line.iter_mut().zip(&shifts).for_each(|(height, shift)| *height -= shift);
    }
    Levelled { heights: levelled, shifts }
}

/// Subtracts the least-squares line in the index.
fn remove_line(values: &mut [f64]) {
    let count = values.len() as f64;
    let (middle, mean) = (0.5 * (count - 1.0), values.iter().sum::<f64>() / count);
    let from_middle = |j: usize| j as f64 - middle;
    let (mut products, mut squares) = (0.0, 0.0);
    for (j, value) in values.iter().enumerate() {
        products += from_middle(j) * (value - mean);
        squares += from_middle(j).powi(2);
    }
    let slope = products / squares;
    values.iter_mut().enumerate().for_each(|(j, value)| *value -= mean + slope * from_middle(j));
}

/// Returns the median, the mean of both middle values for an even number; NaN without values. Changes their order.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let upper = *upper;
    if values.len().is_multiple_of(2) { 0.5 * (lower + upper) } else { upper }
}
