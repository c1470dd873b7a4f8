//! Means and extremes of fields, over the points of all processes that share them.

use std::ops::Range;

use gfmd_vector::{Serialise, Share, add};

/// Reduces a vector with `length` values on this process, as [`gfmd_vector::reduce`]: its components one after another,
/// each with the points of the share. Vectors of other lengths belong to a single process.
pub(crate) fn reduce<R: Serialise>(
    share: &Share,
    length: usize,
    leaf: &(impl Fn(Range<usize>) -> R + Sync),
    merge: &(impl Fn(R, R) -> R + Sync),
) -> R {
    match length / share.own().len() {
        components @ 1.. if length == components * share.own().len() => {
            share.reduce_components(components, leaf, merge)
        }
        _ => gfmd_vector::reduce(length, leaf, merge),
    }
}

/// Returns the sum over a vector with `length` values on this process; `leaf` returns the sum over a range.
pub(crate) fn sum(share: &Share, length: usize, leaf: &(impl Fn(Range<usize>) -> f64 + Sync)) -> f64 {
    reduce(share, length, leaf, &|a, b| a + b)
}

/// Returns the sum of a vector.
pub(crate) fn total(share: &Share, vector: &[f64]) -> f64 {
    sum(share, vector.len(), &|range| vector[range].iter().sum())
}

/// Returns the scalar product of two vectors.
pub(crate) fn dot(share: &Share, a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    sum(share, length, &|range| a[range.clone()].iter().zip(&b[range]).map(|(a, b)| a * b).sum())
}

/// Returns the mean of a field of a single process.
pub(crate) fn mean(field: &[f64]) -> f64 {
    gfmd_vector::total(field) / field.len() as f64
}

/// Returns the mean of a field over the points where `counts` is true; 0 if there are none.
pub(crate) fn mean_where(share: &Share, field: &[f64], counts: impl Fn(usize) -> bool + Sync) -> f64 {
    let [total, count] = reduce(
        share,
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
