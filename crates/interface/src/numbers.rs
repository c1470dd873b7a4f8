//! Means and extremes of fields.

use gfmd_vector::{add, reduce, total};

/// Returns the mean of a field.
pub(crate) fn mean(field: &[f64]) -> f64 {
    total(field) / field.len() as f64
}

/// Returns the mean of a field over the points where `counts` is true; 0 if there are none.
pub(crate) fn mean_where(field: &[f64], counts: impl Fn(usize) -> bool + Sync) -> f64 {
    let [total, count] = reduce(
        field.len(),
        &|range| range.filter(|i| counts(*i)).fold([0.0; 2], |sums, i| add(sums, [field[i], 1.0])),
        &add,
    );
    if count > 0.0 { total / count } else { 0.0 }
}

/// Returns the larger number, NaN if either is NaN.
pub(crate) fn higher(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Returns the smaller number, NaN if either is NaN.
pub(crate) fn lower(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

/// Returns the larger number of each pair, NaN if either is NaN.
pub(crate) fn higher_each<const K: usize>(a: [f64; K], b: [f64; K]) -> [f64; K] {
    std::array::from_fn(|k| higher(a[k], b[k]))
}
