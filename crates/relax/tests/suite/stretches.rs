//! Vectors in stretches for small dense problems.

use gfmd_vector::{Rows, Split};

/// Passes `values` to `sink`, stretch by stretch.
pub(crate) fn hand_on<T, O: Split, R>(
    stretch: usize,
    values: &[T],
    output: O,
    sink: impl Fn(&[T], O) -> R,
    sums: &mut [R],
) {
    let outputs = Rows(output, stretch).parts(1);
    for ((values, Rows(output, _)), sum) in values.chunks(stretch).zip(outputs).zip(sums) {
        *sum = sink(values, output);
    }
}

/// Returns the vector that `source` generates, stretch by stretch.
pub(crate) fn made<I: Split>(stretch: usize, length: usize, input: I, source: impl Fn(I, &mut [f32])) -> Vec<f64> {
    let mut row = vec![0.0; length];
    for (row, Rows(input, _)) in row.chunks_mut(stretch).zip(Rows(input, stretch).parts(1)) {
        source(input, row);
    }
    row.into_iter().map(f64::from).collect()
}
